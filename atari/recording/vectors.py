"""The environments that recorders wrap."""

from typing import Any

from atari.base.gymnasium_versions import VectorEnv
from atari.vector import AtariVectorEnv

_SEVERAL = (
    "games of several players are recorded by RecordReplay around a MultiplayerCore, and by "
    "`atari record GAME --players N`, see docs/multiplayer.md"
)


def is_vector(env: Any) -> bool:
    """Whether `env` is a vector environment, in any wrappers."""
    return isinstance(env, VectorEnv) or isinstance(getattr(env, "unwrapped", None), AtariVectorEnv)


def not_recorded(env: Any, recorder: str, other: str = "") -> TypeError:
    """The error for an environment that a recorder does not record; `other` is advice for other environments."""
    if isinstance(getattr(env, "vector", None), AtariVectorEnv):
        return TypeError(f"{recorder} records no {type(env).__name__} of Stable-Baselines3; use atari.sb3.{recorder}")
    inner = getattr(env, "unwrapped", env)
    if getattr(getattr(inner, "core", inner), "players", 1) > 1:
        other = f"; {_SEVERAL}"
    return TypeError(f"{recorder} records an AtariEnv or an AtariVectorEnv, got {type(inner).__name__}{other}")


def recorded_vector(envs: Any, recorder: str) -> AtariVectorEnv:
    """The `AtariVectorEnv` in `envs`, for a recorder of this name.

    Raises:
        TypeError: there is none.
        ValueError: its batches are smaller than the number of environments, or it has several players.
    """
    inner = getattr(envs, "unwrapped", envs)
    if not isinstance(inner, AtariVectorEnv):
        raise not_recorded(envs, recorder)
    if inner.task.players > 1:
        raise ValueError(f"{recorder} records vectors of one player, got players={inner.task.players}; {_SEVERAL}")
    if inner.batch_size != inner.num_envs:
        raise ValueError(f"{recorder} needs batches of all environments, got batch_size={inner.batch_size}")
    return inner
