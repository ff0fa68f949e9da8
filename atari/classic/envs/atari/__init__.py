"""Atari games."""

from atari.classic.envs.atari.atari_env import AtariEnv

__all__ = ["AtariEnv"]
