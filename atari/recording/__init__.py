"""Recorded gameplay: videos with sound, replays that are the game again, and datasets made of them."""

from atari.recording.datasets import to_minari
from atari.recording.formats import FORMATS, Format
from atari.recording.record_replay import RecordReplay
from atari.recording.record_vector_replay import RecordVectorReplay
from atari.recording.record_vector_video import RecordVectorVideo
from atari.recording.record_video import RecordVideo
from atari.recording.replay import Divergence, Episode, Frame, Replay, Verification
from atari.recording.video import VideoWriter, frame_rate

__all__ = [
    "FORMATS",
    "Divergence",
    "Episode",
    "Format",
    "Frame",
    "RecordReplay",
    "RecordVectorReplay",
    "RecordVectorVideo",
    "RecordVideo",
    "Replay",
    "Verification",
    "VideoWriter",
    "frame_rate",
    "to_minari",
]
