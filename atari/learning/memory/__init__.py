"""`ReplayMemory`, which stores each frame once, and the batches that it samples."""

from atari.learning.memory.replay_memory import ReplayMemory

__all__ = ["ReplayMemory"]
