"""Files that are written durably, and files of strangers that are read with care."""
