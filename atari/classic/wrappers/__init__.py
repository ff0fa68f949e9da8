"""Wrappers with the old interface."""

from atari.classic.wrappers import monitoring, normalize
from atari.classic.wrappers.atari_preprocessing import AtariPreprocessing
from atari.classic.wrappers.frame_stack import FrameStack, LazyFrames
from atari.classic.wrappers.monitor import Monitor
from atari.classic.wrappers.record_episode_statistics import RecordEpisodeStatistics
from atari.classic.wrappers.record_video import RecordVideo
from atari.classic.wrappers.time_limit import TimeLimit
from atari.classic.wrappers.transforms import (
    ClipAction,
    FlattenDictWrapper,
    FlattenObservation,
    GrayScaleObservation,
    RescaleAction,
    ResizeObservation,
    TransformObservation,
    TransformReward,
)

__all__ = [
    "AtariPreprocessing",
    "ClipAction",
    "FlattenDictWrapper",
    "FlattenObservation",
    "FrameStack",
    "GrayScaleObservation",
    "LazyFrames",
    "Monitor",
    "RecordEpisodeStatistics",
    "RecordVideo",
    "RescaleAction",
    "ResizeObservation",
    "TimeLimit",
    "TransformObservation",
    "TransformReward",
    "monitoring",
    "normalize",
]
