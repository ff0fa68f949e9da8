"""All of PettingZoo's environments here can be copied, as PettingZoo's own can, and the copies play on equally."""

import copy
import pickle
from collections.abc import Callable
from typing import Any

import cloudpickle
import pytest

pytest.importorskip("pettingzoo")
from copied import match

from atari.multiplayer import ENVIRONMENTS, parallel_env

WAYS: tuple[Callable[[Any], Any], ...] = (
    lambda env: pickle.loads(pickle.dumps(env)),
    lambda env: pickle.loads(cloudpickle.dumps(env)),
    copy.deepcopy,
)


@pytest.mark.parametrize("name", [environment.id for environment in ENVIRONMENTS.values()])
def test_a_copy_of_a_parallel_environment_plays_on_equally(name: str) -> None:
    env = parallel_env(name, obs_type="ram")
    env.reset(seed=4)
    for number, agent in enumerate(env.possible_agents):
        env.action_space(agent).seed(number)
    match(env, 20)
    others = [copied(env) for copied in WAYS]
    expected = match(env, 60)
    for other in others:
        assert other.unwrapped.core is not env.unwrapped.core
        assert other.task == env.task
        assert match(other, 60) == expected
