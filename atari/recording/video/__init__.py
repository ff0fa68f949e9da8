"""Videos of games: the encoders, the writer of video files, and the wrappers that record environments."""
