"""`AtariEnv`, one Atari 2600 game as a Gymnasium environment, and the parts that it and wrappers around it share."""

from atari.env.env import AtariEnv

__all__ = ["AtariEnv"]
