"""The vector environments that recorders wrap."""

from typing import Any

from atari._gymnasium import VectorEnv
from atari.vector import AtariVectorEnv


def is_vector(env: Any) -> bool:
    """Whether `env` is a vector environment, in any wrappers."""
    return isinstance(env, VectorEnv) or isinstance(getattr(env, "unwrapped", None), AtariVectorEnv)


def recorded_vector(envs: Any, recorder: str) -> AtariVectorEnv:
    """The `AtariVectorEnv` in `envs`, for a recorder of this name.

    Raises:
        TypeError: there is none.
        ValueError: its batches are smaller than the number of environments.
    """
    inner = getattr(envs, "unwrapped", envs)
    if not isinstance(inner, AtariVectorEnv):
        raise TypeError(f"{recorder} records an AtariEnv or an AtariVectorEnv, got {type(inner).__name__}")
    if inner.batch_size != inner.num_envs:
        raise ValueError(f"{recorder} needs batches of all environments, got batch_size={inner.batch_size}")
    return inner
