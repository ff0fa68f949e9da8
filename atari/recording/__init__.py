"""Recorded gameplay: the screens and the sound of a game as a video."""

from atari.recording.formats import FORMATS, Format
from atari.recording.record_video import RecordVideo
from atari.recording.video import VideoWriter, frame_rate

__all__ = ["FORMATS", "Format", "RecordVideo", "VideoWriter", "frame_rate"]
