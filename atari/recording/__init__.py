"""Recorded gameplay: videos with sound, replays that reproduce a game exactly, and datasets made from replays."""

from atari.recording.datasets import to_minari
from atari.recording.replay.players import RecordMatch
from atari.recording.replay.record_replay import RecordReplay
from atari.recording.replay.record_vector_replay import RecordVectorReplay
from atari.recording.replay.replay import Replay
from atari.recording.replay.results import Divergence, Episode, Frame, Verification
from atari.recording.video.facts import video_facts
from atari.recording.video.formats import FORMATS, Format
from atari.recording.video.record_vector_video import RecordVectorVideo
from atari.recording.video.record_video import RecordVideo
from atari.recording.video.writer import VideoWriter, frame_rate

__all__ = [
    "FORMATS",
    "Divergence",
    "Episode",
    "Format",
    "Frame",
    "RecordMatch",
    "RecordReplay",
    "RecordVectorReplay",
    "RecordVectorVideo",
    "RecordVideo",
    "Replay",
    "Verification",
    "VideoWriter",
    "frame_rate",
    "to_minari",
    "video_facts",
]
