"""Recorded gameplay: videos with sound, replays that reproduce a game exactly, and datasets made from replays."""

from atari.recording.minari import to_minari
from atari.recording.replay.record_replay import RecordReplay
from atari.recording.replay.record_search import RecordSearch
from atari.recording.replay.replay import Replay
from atari.recording.video.facts import video_facts
from atari.recording.video.record_video import RecordVideo
from atari.recording.video.writer import VideoWriter

__all__ = ["RecordReplay", "RecordSearch", "RecordVideo", "Replay", "VideoWriter", "to_minari", "video_facts"]
