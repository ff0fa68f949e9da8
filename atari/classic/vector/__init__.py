"""Several environments at once, with the old interface."""

from typing import Any

from atari.classic.envs.registration import make as make_one
from atari.classic.vector.async_vector_env import AsyncVectorEnv
from atari.classic.vector.sync_vector_env import SyncVectorEnv
from atari.classic.vector.vector_env import VectorEnv, VectorEnvWrapper, WrapMany

__all__ = ["AsyncVectorEnv", "SyncVectorEnv", "VectorEnv", "VectorEnvWrapper", "make"]


def make(
    id: str,
    num_envs: int = 1,
    asynchronous: bool = True,
    wrappers: WrapMany | None = None,
    disable_env_checker: bool | None = None,
    **kwargs: Any,
) -> VectorEnv:
    """Make several environments of an ID.

    Args:
        id: the ID.
        num_envs: their number.
        asynchronous: each in a process of its own.
        wrappers: a wrapper, or several from the innermost to the outermost, around each environment.
        disable_env_checker: has no effect.
        **kwargs: arguments of the environment.

    Raises:
        ValueError: `num_envs` is less than 1.

    Example:
        >>> from atari import classic
        >>> envs = classic.vector.make("CartPole-v1", 3, asynchronous=False)
        >>> envs.reset().shape
        (3, 4)
    """

    def make_env() -> Any:
        env: Any = make_one(id, **kwargs)
        for wrap in [wrappers] if callable(wrappers) else wrappers or []:
            env = wrap(env)
        return env

    kind: type[AsyncVectorEnv | SyncVectorEnv] = AsyncVectorEnv if asynchronous else SyncVectorEnv
    return kind([make_env] * num_envs)
