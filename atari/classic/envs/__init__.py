"""The registry of environments, and the classes of environments by Gym's modules."""

from atari.classic.envs import atari, classic_control, toy_text
from atari.classic.envs.registration import make, register, registry, spec

__all__ = ["atari", "classic_control", "make", "register", "registry", "spec", "toy_text"]
