"""Wrappers with the old interface."""

from atari.classic.wrappers.time_limit import TimeLimit

__all__ = ["TimeLimit"]
