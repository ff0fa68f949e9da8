"""What environments of finitely many states were built on."""

from atari.classic.envs.toy_text import discrete

__all__ = ["discrete"]
