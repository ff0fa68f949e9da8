"""The registry of environments: `registry`, `make`, `spec`, `register`."""

from atari.classic.envs.registration import make, register, registry, spec

__all__ = ["make", "register", "registry", "spec"]
