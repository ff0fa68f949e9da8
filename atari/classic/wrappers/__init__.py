"""Wrappers with the old interface."""

from atari.classic.wrappers.atari_preprocessing import AtariPreprocessing
from atari.classic.wrappers.frame_stack import FrameStack
from atari.classic.wrappers.monitor import Monitor
from atari.classic.wrappers.time_limit import TimeLimit
from atari.classic.wrappers.transforms import (
    ClipAction,
    FlattenObservation,
    GrayScaleObservation,
    RecordEpisodeStatistics,
    RescaleAction,
    ResizeObservation,
    TransformObservation,
    TransformReward,
)

__all__ = [
    "AtariPreprocessing",
    "ClipAction",
    "FlattenObservation",
    "FrameStack",
    "GrayScaleObservation",
    "Monitor",
    "RecordEpisodeStatistics",
    "RescaleAction",
    "ResizeObservation",
    "TimeLimit",
    "TransformObservation",
    "TransformReward",
]
