"""Gym's site, which is closed: `gym.upload`, the last line of many scripts until 2017, and `gym.benchmark_spec`."""

from dataclasses import dataclass
from typing import Any

import gymnasium

from atari.classic import logger

_SEVEN = ("BeamRider", "Breakout", "Enduro", "Pong", "Qbert", "Seaquest", "SpaceInvaders")
_STEPS = {"Atari200M": 200_000_000, "Atari40M": 40_000_000}


@dataclass(frozen=True)
class BenchmarkTask:
    """An environment, with the number of trainings and the most steps of each."""

    env_id: str
    trials: int
    max_timesteps: int


@dataclass(frozen=True)
class Benchmark:
    """A list of Atari tasks, on which courses of 2016 and 2017 trained."""

    id: str
    tasks: tuple[BenchmarkTask, ...]


def benchmark_spec(id: str) -> Benchmark:
    """The benchmark of an ID.

    Raises:
        gymnasium.error.Error: there is no such benchmark here.

    Example:
        >>> from atari import classic
        >>> classic.benchmark_spec("Atari40M").tasks[3].env_id
        'PongNoFrameskip-v4'
    """
    if id not in _STEPS:
        raise gymnasium.error.Error(f"there is no benchmark {id!r}; there are {', '.join(_STEPS)}")
    tasks = (BenchmarkTask(f"{game}NoFrameskip-v4", 2, _STEPS[id]) for game in _SEVEN)
    return Benchmark(id, tuple(tasks))


def upload(training_dir: Any = None, *_: Any, **__: Any) -> None:
    """Say that the site for results is closed, and where results are and go now; the files do not move."""
    folder = "their folder" if training_dir is None else training_dir
    logger.warn_once(
        f"gym.upload() does nothing, as the site it went to is closed; the results are still in {folder}. "
        "`atari evaluate` scores a policy by a published protocol, and `atari web` writes a page of replays to share"
    )
