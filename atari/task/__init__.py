"""What is played, as one value: `Task`. `PRESETS` are tasks without a game."""

from atari.task.presets import PRESETS, Preset
from atari.task.task import Task

__all__ = ["PRESETS", "Preset", "Task"]
