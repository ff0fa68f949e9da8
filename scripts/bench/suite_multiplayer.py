"""The suite `multiplayer` of `bench.py`: games of two players beside PettingZoo's with SuperSuit's wrappers."""

import importlib
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import ale_py.roms
import numpy as np
from comparison import Comparison, Run

import atari
from atari.multiplayer import ENVIRONMENTS

GAMES = ["pong", "boxing", "joust", "space_invaders", "tennis", "combat_tank"]
"""PettingZoo's names."""

COUNT = 8


def comparisons() -> Iterator[Comparison]:
    """One step of a game of two players, 4 frames, resets counted; both sides have 8 games and one thread."""
    sides = [("native", partial(batches_of, make=native)), ("PettingZoo", partial(batches_of, make=pettingzoo))]
    yield Comparison(f"{COUNT} x 84x84 gray, two players, one thread", sides)


def native(name: str) -> Any:
    """Our vector environment."""
    environment = ENVIRONMENTS[name]
    mode = environment.choose({})
    return atari.AtariVectorEnv(environment.game, COUNT, players=2, mode=mode, num_threads=1)


def pettingzoo(name: str) -> Any:
    """PettingZoo's environment with the same preprocessing by SuperSuit, in one process."""
    import supersuit

    warnings.simplefilter("ignore")
    roms = Path(str(ale_py.roms.get_rom_path("pong"))).parent
    module = importlib.import_module(f"pettingzoo.atari.{ENVIRONMENTS[name].id}")
    env = module.parallel_env(obs_type="grayscale_image", auto_rom_install_path=str(roms))
    env = supersuit.frame_skip_v0(supersuit.max_observation_v0(env, 2), 4)
    env = supersuit.frame_stack_v1(supersuit.resize_v1(env, 84, 84), 4)
    env = supersuit.pettingzoo_env_to_vec_env_v1(env)
    return supersuit.concat_vec_envs_v1(env, COUNT, num_cpus=0, base_class="gymnasium")


def batches_of(name: str, make: Callable[[str], Any]) -> Run:
    """Steps of a vector, counted by its games; in each step both players of a game act."""
    envs = make(name)
    envs.reset(seed=0)
    shape = (2 * COUNT,) if envs.num_envs == 2 * COUNT else (COUNT, 2)
    count = int(np.min(envs.action_space.nvec if shape == (COUNT, 2) else envs.action_space.n))

    def run(steps: int) -> float:
        batches = -(-steps // COUNT)
        actions = np.random.default_rng(0).integers(count, size=(batches, *shape))
        started = perf_counter()
        for batch in actions:
            envs.step(batch)
        return (perf_counter() - started) * steps / (batches * COUNT)

    return run
