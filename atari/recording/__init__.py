"""Recorded gameplay: the screens of a game as an MP4 file."""

from atari.recording.video import VideoWriter, frame_rate

__all__ = ["VideoWriter", "frame_rate"]
