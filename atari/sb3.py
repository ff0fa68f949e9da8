"""The public names for Stable-Baselines3: `AtariVecEnv`, its vector environment, and its recorders."""

from atari.integrations.sb3 import AtariVecEnv, RecordReplay, RecordVideo

__all__ = ["AtariVecEnv", "RecordReplay", "RecordVideo"]
