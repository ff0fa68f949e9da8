"""`Task`: game, rules, actions, observations and rewards as one value. `PRESETS` are tasks without a game."""

from atari.task.presets import PRESETS, Preset
from atari.task.task import Task

__all__ = ["PRESETS", "Preset", "Task"]
