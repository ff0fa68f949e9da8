"""Atari on a cluster, with Ray: `pip install 'atari-envs[ray]'`.

RLlib: `config` makes an algorithm's configuration, `register` and `env_creator` the environment alone (`rllib.py`).
Learners of your own: `RolloutActors` plays environments in actors and returns batches of steps (`rollout_actors.py`).
Data sets: `collect` has many workers play games and writes them (`collection.py`).
Each name is imported when it is first used.
"""

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import gymnasium

if TYPE_CHECKING:
    from atari.integrations.ray.collection import collect
    from atari.integrations.ray.rllib import GameScores, config, env_creator, register
    from atari.integrations.ray.rollout import Rollout
    from atari.integrations.ray.rollout_actors import RolloutActors

if find_spec("ray") is None:
    raise gymnasium.error.DependencyNotInstalled("atari.integrations.ray needs Ray: pip install 'atari-envs[ray]'")

_MODULES = {
    "Rollout": "rollout",
    "RolloutActors": "rollout_actors",
    "GameScores": "rllib",
    "collect": "collection",
    "config": "rllib",
    "env_creator": "rllib",
    "register": "rllib",
}
"""By public name, the module of this package that has it."""

__all__ = ["GameScores", "Rollout", "RolloutActors", "collect", "config", "env_creator", "register"]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
