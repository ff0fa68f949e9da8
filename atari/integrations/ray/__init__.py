"""Atari on a cluster, with Ray (extra `ray`).

RLlib: `config` makes an algorithm's configuration, `register` and `env_creator` the environment alone (`rllib.py`).
Other learners: `RolloutActors` plays environments in actors and returns batches of steps (`rollout_actors.py`).
Data sets: `collect` has many workers play games, and writes data sets (`collection.py`).
Each name is imported when it is first used.
"""

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import gymnasium

from atari.base.extras import install_extra

if TYPE_CHECKING:
    from atari.integrations.ray.collection import collect
    from atari.integrations.ray.rllib import GameScores, config, env_creator, register
    from atari.integrations.ray.rollout_actors import RolloutActors

if find_spec("ray") is None:
    raise gymnasium.error.DependencyNotInstalled(f"atari.integrations.ray needs Ray: {install_extra('ray')}")

_MODULES = {
    "RolloutActors": "rollout_actors",
    "GameScores": "rllib",
    "collect": "collection",
    "config": "rllib",
    "env_creator": "rllib",
    "register": "rllib",
}
"""The module of this package that has each public name."""

__all__ = ["GameScores", "RolloutActors", "collect", "config", "env_creator", "register"]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
