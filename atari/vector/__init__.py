"""Many Atari games as one Gymnasium vector environment."""

from atari.vector.env import AtariVectorEnv

__all__ = ["AtariVectorEnv"]
