"""Games of two to four players: PettingZoo's Atari environments on the native emulator (extra `multiplayer`).

import atari.multiplayer

env = atari.multiplayer.parallel_env("pong")    # or .env("pong"): agents take turns
observations, infos = env.reset(seed=42)
"""

import inspect
import sys
from collections.abc import Callable
from types import ModuleType
from typing import TYPE_CHECKING, Any

import gymnasium

from atari.base.extras import install_extra
from atari.games.pettingzoo import ENVIRONMENTS, Environment
from atari.multiplayer.ale import ALEInterface
from atari.multiplayer.core import MultiplayerCore

if TYPE_CHECKING:
    from pettingzoo import AECEnv, ParallelEnv

    from atari.multiplayer.parallel import MultiplayerEnv
    from atari.task.task import GameLike

__all__ = [
    "ENVIRONMENTS",
    "ALEInterface",
    "MultiplayerCore",
    "MultiplayerEnv",
    "env",
    "parallel_env",
    "raw_env",
]


def raw_env(game: "GameLike", **options: Any) -> "AECEnv[str, Any, int]":
    """The task as PettingZoo's AEC environment, in which agents take turns, without checks.

    The emulator plays a step when the last agent has acted. Arguments, errors and `task` are those of `MultiplayerEnv`.

    Example:
        >>> from atari.multiplayer import raw_env
        >>> env = raw_env("pong_v3")
        >>> env.reset(seed=0)
        >>> env.agent_selection
        'first_0'
        >>> env.step(0)
        >>> env.agent_selection
        'second_0'
    """
    _require()
    from pettingzoo.utils.conversions import parallel_to_aec_wrapper

    from atari.multiplayer.parallel import MultiplayerEnv

    return _with_task(parallel_to_aec_wrapper, MultiplayerEnv(game, **options))


def env(game: "GameLike", **options: Any) -> "AECEnv[str, Any, int]":
    """The game as PettingZoo's AEC environment, with PettingZoo's checks of actions and of the order of calls.

    Arguments and errors are those of `raw_env`.

    Example:
        >>> from atari.multiplayer import env
        >>> game = env("boxing", obs_type="ram")
        >>> game.reset(seed=1)
        >>> observation, reward, termination, truncation, info = game.last()
        >>> game.step(game.action_space(game.agent_selection).sample())
        >>> observation.shape, game.agent_selection
        ((128,), 'second_0')
    """
    _require()
    from pettingzoo.utils import wrappers

    checked = wrappers.AssertOutOfBoundsWrapper(raw_env(game, **options))
    return wrappers.OrderEnforcingWrapper(checked)


def parallel_env(game: "GameLike", **options: Any) -> "ParallelEnv[str, Any, int]":
    """The game as PettingZoo's parallel environment, in which all agents act at once, with PettingZoo's checks.

    Arguments and errors are those of `raw_env`.

    Example:
        >>> from atari.multiplayer import parallel_env
        >>> env = parallel_env("pong_v3")
        >>> observations, infos = env.reset(seed=0)
        >>> env.agents
        ['first_0', 'second_0']
        >>> observations, rewards, terminations, truncations, infos = env.step({agent: 0 for agent in env.agents})
        >>> dict(rewards) == {"first_0": 0, "second_0": 0}
        True
    """
    _require()
    from pettingzoo.utils.conversions import aec_to_parallel_wrapper

    return _with_task(aec_to_parallel_wrapper, env(game, **options))


def _with_task(wrapper: Any, inner: Any) -> Any:
    """A conversion of PettingZoo's with the `task` of the environment inside, which it would hide."""
    env = wrapper(inner)
    env.task = inner.task
    return env


def _require() -> None:
    try:
        import pettingzoo  # noqa: F401
    except ImportError:
        raise gymnasium.error.DependencyNotInstalled(
            f"environments of several players need PettingZoo: {install_extra('multiplayer')}; "
            "MultiplayerCore works without"
        ) from None


def _of_environment(environment: Environment, function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of a game as a function of the parameters of PettingZoo's environment."""
    kind = inspect.Parameter
    parameters = [kind(name, kind.POSITIONAL_OR_KEYWORD, default=value) for name, value in environment.defaults.items()]
    signature = inspect.Signature([*parameters, kind("options", kind.VAR_KEYWORD)])

    def make(*values: Any, **options: Any) -> Any:
        given = signature.bind(*values, **options).arguments
        return function(environment.id, **given.pop("options", {}), **given)

    make.__name__, make.__doc__ = function.__name__, function.__doc__
    vars(make)["__signature__"] = signature
    return make


# PettingZoo has a module for each environment: `from atari.multiplayer import pong_v3`.
for _one in ENVIRONMENTS.values():
    _module = ModuleType(f"{__name__}.{_one.id}", f"PettingZoo's environment {_one.id}.")
    vars(_module).update(
        {function.__name__: _of_environment(_one, function) for function in (raw_env, env, parallel_env)}
    )
    sys.modules[_module.__name__] = globals()[_one.id] = _module


def __getattr__(name: str) -> Any:
    if name == "MultiplayerEnv":
        _require()
        from atari.multiplayer.parallel import MultiplayerEnv

        return MultiplayerEnv
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
