"""The page in which games play in a browser; its core in C++ is in `web/`, at the top of the repository."""
