"""Replays: the file format, the recorder, the runner that plays a file again, and the wrappers that record."""
