"""The base of environments with finitely many states."""

from atari.classic.envs.toy_text import discrete

__all__ = ["discrete"]
