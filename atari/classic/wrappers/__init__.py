"""Wrappers with the old interface."""

from atari.classic import error
from atari.classic.monitor import Monitor
from atari.classic.monitor_files import capped_cubic_video_schedule
from atari.classic.wrappers import normalize
from atari.classic.wrappers.atari_preprocessing import AtariPreprocessing
from atari.classic.wrappers.conversions import (
    EnvCompatibility,
    OrderEnforcing,
    PassiveEnvChecker,
    StepAPICompatibility,
    VectorListInfo,
)
from atari.classic.wrappers.episodes import AutoResetWrapper, RecordEpisodeStatistics, TimeLimit
from atari.classic.wrappers.normalize import NormalizeObservation, NormalizeReward
from atari.classic.wrappers.observations import (
    FilterObservation,
    FrameStack,
    LazyFrames,
    PixelObservationWrapper,
    TimeAwareObservation,
)
from atari.classic.wrappers.record_video import RecordVideo
from atari.classic.wrappers.rendering import HumanRendering, RenderCollection
from atari.classic.wrappers.transforms import (
    ClipAction,
    FlattenDictWrapper,
    FlattenObservation,
    GrayScaleObservation,
    RescaleAction,
    ResizeObservation,
    SkipWrapper,
    TransformObservation,
    TransformReward,
)

__all__ = [
    "AtariPreprocessing",
    "AutoResetWrapper",
    "ClipAction",
    "EnvCompatibility",
    "FilterObservation",
    "FlattenDictWrapper",
    "FlattenObservation",
    "FrameStack",
    "GrayScaleObservation",
    "HumanRendering",
    "LazyFrames",
    "Monitor",
    "NormalizeObservation",
    "NormalizeReward",
    "OrderEnforcing",
    "PassiveEnvChecker",
    "PixelObservationWrapper",
    "RecordEpisodeStatistics",
    "RecordVideo",
    "RenderCollection",
    "RescaleAction",
    "ResizeObservation",
    "SkipWrapper",
    "StepAPICompatibility",
    "TimeAwareObservation",
    "TimeLimit",
    "TransformObservation",
    "TransformReward",
    "VectorListInfo",
    "capped_cubic_video_schedule",
    "error",
    "normalize",
]
