"""The environments that recorders wrap."""

from typing import Any

from atari._gymnasium import VectorEnv
from atari.vector import AtariVectorEnv


def is_vector(env: Any) -> bool:
    """Whether `env` is a vector environment, in any wrappers."""
    return isinstance(env, VectorEnv) or isinstance(getattr(env, "unwrapped", None), AtariVectorEnv)


def not_recorded(env: Any, recorder: str, other: str = "") -> TypeError:
    """The error for an environment that a recorder does not record; `other` is advice for other environments."""
    if isinstance(getattr(env, "vector", None), AtariVectorEnv):
        return TypeError(f"{recorder} records no {type(env).__name__} of Stable-Baselines3; use atari.sb3.{recorder}")
    kind = type(getattr(env, "unwrapped", env)).__name__
    return TypeError(f"{recorder} records an AtariEnv or an AtariVectorEnv, got {kind}{other}")


def recorded_vector(envs: Any, recorder: str) -> AtariVectorEnv:
    """The `AtariVectorEnv` in `envs`, for a recorder of this name.

    Raises:
        TypeError: there is none.
        ValueError: its batches are smaller than the number of environments.
    """
    inner = getattr(envs, "unwrapped", envs)
    if not isinstance(inner, AtariVectorEnv):
        raise not_recorded(envs, recorder)
    if inner.batch_size != inner.num_envs:
        raise ValueError(f"{recorder} needs batches of all environments, got batch_size={inner.batch_size}")
    return inner
