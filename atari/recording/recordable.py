"""The environments that recorders wrap, and the base of recorders, which defers errors of writing."""

from typing import Any

from atari.vector import AtariVectorEnv

_SEVERAL = (
    "games of several players are recorded by RecordReplay around a MultiplayerCore, and by "
    "`atari record GAME --players N`, see docs/multiplayer.md"
)


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


class DeferredErrorMixin:
    """The base of recorders that write files during steps. It owns at most one deferred error.

    An error raised in the middle of a step would leave the environment between two states. So the recording ends, the
    step completes, and the next call of the environment raises the error before it changes anything.
    """

    _deferred_error: OSError | None = None

    def raise_deferred_error(self) -> None:
        """Raise the deferred error and drop it; without one, do nothing.

        Raises:
            OSError: the file could not be written.
        """
        error, self._deferred_error = self._deferred_error, None
        if error is not None:
            raise error
