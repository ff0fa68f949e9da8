"""`ReplayMemory.from_dataset`: the steps of a data set or of replays, one episode at a time, as a memory takes them."""

from collections.abc import Iterable, Iterator
from itertools import count
from os import PathLike
from typing import Any, Protocol, cast

import numpy as np
import numpy.typing as npt

from atari.env.settings import observation_space
from atari.lab.dataset_reader import StoredEpisode, read_dataset
from atari.learning.memory.options import check_lives
from atari.policy.choice import Choice
from atari.recording.episodes import EpisodeArrays, Source, check_seen, load_replays, seen_episodes
from atari.recording.replay.file_format import is_replay
from atari.recording.stacks import Stacking
from atari.task import Task

_SERVED = "fill a memory by reset and add from read_dataset"


class _Data(Protocol):
    """The games that fill a memory: a `StoredDataset`, or replays."""

    @property
    def task(self) -> Task:
        """The task that was played."""

    def stacks(self) -> Iterator[npt.NDArray[np.uint8]]:
        """See `StoredDataset.stacks`."""

    def __iter__(self) -> Iterator[StoredEpisode]:
        """Yield the episodes."""


class _Replays:
    """Replays, whose games are played again."""

    def __init__(self, replays: Source | Iterable[Source]) -> None:
        self._replays = load_replays(replays)
        self.task = self._replays[0].task
        check_seen(self.task)

    def stacks(self) -> Iterator[npt.NDArray[np.uint8]]:
        return (episode.infos["stack"] for episode in seen_episodes(self._replays))

    def __iter__(self) -> Iterator[StoredEpisode]:
        return map(_stored, count(), seen_episodes(self._replays))


def _stored(number: int, played: EpisodeArrays) -> StoredEpisode:
    return StoredEpisode(
        number,
        seed=None,
        frames=played.observations["image"],
        stack=played.infos["stack"],
        ram=played.observations["ram"],
        actions=played.actions,
        rewards=played.rewards,
        terminations=played.terminations,
        truncations=played.truncations,
        chosen=np.full(len(played.rewards), Choice.UNKNOWN, np.uint8),
    )


def open_data(source: Source | Iterable[Source]) -> _Data:
    """A data set or replays, as `ReplayMemory.from_dataset` takes them, with a task that a memory serves.

    Raises:
        ValueError, FileNotFoundError, gymnasium.error.DependencyNotInstalled: see there.
    """
    stored = isinstance(source, (str, PathLike)) and not is_replay(source)
    data: _Data = read_dataset(cast("str | PathLike[str]", source)) if stored else _Replays(source)
    task = data.task
    check_lives(task)
    if task.reward is not None:
        raise ValueError(
            f"the agent was paid {task.reward!r}, and the data have the game's own rewards; {_SERVED}, with rewards of "
            "yours"
        )
    if task.episodic_life and task.on_reset == "new_game":
        raise ValueError(
            "a lost life began a new game (episodic_life with on_reset='new_game'), and a data set does not say which "
            f"games ended so; collect the data with on_reset='noop' or 'continue', or {_SERVED}"
        )
    return data


def rows_of(data: _Data) -> tuple[int, int]:
    """The number of steps, and that of the rows of a memory that has them and the observation after each end."""
    lengths = [(len(stack) - 1, int((stack == Stacking.BEGUN).sum())) for stack in data.stacks()]
    steps, begun = (sum(numbers) for numbers in zip(*lengths, strict=True))
    return steps, steps + begun - 1


def options_of(task: Task) -> dict[str, Any]:
    """The options of a memory that has the observations and actions of a task."""
    single = 1 if task.kind.image and task.stack_num is not None else None
    return {
        "num_envs": 1,
        "observation_shape": observation_space(task.replace(stack_num=single)).shape,
        "stack_num": task.stack_num or 1,
        "padding": task.padding,
        "autoreset_mode": "next_step",
        "action_shape": (3,) if task.continuous else (),
        "action_dtype": "float32" if task.continuous else "int64",
    }
