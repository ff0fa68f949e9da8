"""The public name of `AtariVecEnv`, the vector environment for Stable-Baselines3."""

from atari.integrations.sb3 import AtariVecEnv

__all__ = ["AtariVecEnv"]
