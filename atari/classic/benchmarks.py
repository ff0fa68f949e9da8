"""`gym.benchmark_spec`: the lists of Atari tasks that courses of 2016 and 2017 trained on."""

from dataclasses import dataclass

import gymnasium

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
    """A list of tasks."""

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
