"""Wrappers with the old interface."""

from atari.classic.wrappers.atari_preprocessing import AtariPreprocessing
from atari.classic.wrappers.frame_stack import FrameStack
from atari.classic.wrappers.monitor import Monitor
from atari.classic.wrappers.time_limit import TimeLimit

__all__ = ["AtariPreprocessing", "FrameStack", "Monitor", "TimeLimit"]
