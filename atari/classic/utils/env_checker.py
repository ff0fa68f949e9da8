"""`check_env`: whether an environment keeps to the interface."""

from typing import Any

import gymnasium
from gymnasium.utils import env_checker as _modern
from gymnasium.utils.env_checker import check_env as _check_modern
from gymnasium.utils.env_checker import check_space_limit, data_equivalence

from atari.classic import logger
from atari.classic.core import Env
from atari.classic.modern import Modern
from atari.classic.spaces import Box

__all__ = [
    "check_env",
    "check_reset_options",
    "check_reset_return_info_deprecation",
    "check_reset_return_type",
    "check_reset_seed",
    "check_seed_deprecation",
    "check_space_limit",
    "data_equivalence",
]


def check_env(env: Env, warn: bool = True, skip_render_check: bool = True) -> None:
    """Check the spaces of an environment, and the results of its `reset` and `step`.

    Args:
        env: an environment of this interface.
        warn: also warn of what works, but hurts: actions of a Box beyond -1..1.
        skip_render_check: do not render it in its modes.

    Raises:
        TypeError, ValueError, AssertionError, gymnasium.error.Error: something is wrong; the message says what.

    Example:
        >>> import atari.classic as gym
        >>> from atari.classic.utils.env_checker import check_env
        >>> check_env(gym.make("CartPole-v1"))
    """
    if not isinstance(env, Env):
        raise TypeError(f"check_env() checks an environment derived from gym.Env, got a {type(env).__name__}")
    space = getattr(env, "action_space", None)
    if warn and isinstance(space, Box) and ((space.low != -1).any() or (space.high != 1).any()):
        logger.warn_once(f"agents learn best with actions within -1..1; {env} has another action space")
    modern = Modern(env)
    if type(env.unwrapped).seed is not Env.seed:
        _check_modern(modern, skip_render_check=True)
    else:
        _check_results(modern)
    for mode in () if skip_render_check else env.metadata.get("render.modes", []):
        if mode != "human":
            env.render(mode=mode)


def _check_results(modern: Any) -> None:
    """The checks for an environment without seeds: its results are in the spaces."""
    observation, _ = modern.reset()
    for _ in range(10):
        if not modern.observation_space.contains(observation):
            raise ValueError(f"the observation {observation!r} is not in the observation space")
        observation, _, terminated, truncated, _ = modern.step(modern.action_space.sample())
        if terminated or truncated:
            observation, _ = modern.reset()


def check_reset_seed(env: Any) -> None:
    """Check that equal seeds give equal episodes."""
    _modern.check_reset_seed_determinism(_as_modern(env))


def check_reset_options(env: Any) -> None:
    """Check that `reset` takes options, for an environment of Gymnasium's interface."""
    _modern.check_reset_options(_as_modern(env))


def check_reset_return_info_deprecation(env: Any) -> None:
    """Check that `reset` has no argument `return_info`, which only Gym 0.22 to 0.25 had."""
    _modern.check_reset_return_info_deprecation(_as_modern(env))


def check_reset_return_type(env: Any) -> None:
    """Check what `reset` returns."""
    _modern.check_reset_return_type(_as_modern(env))


def check_seed_deprecation(env: Any) -> None:
    """Warn if an environment of Gymnasium's interface has a method `seed`; in this interface it is right."""
    if isinstance(env, gymnasium.Env):
        _modern.check_seed_deprecation(env)


def _as_modern(env: Any) -> Any:
    return env if isinstance(env, gymnasium.Env) else Modern(env)
