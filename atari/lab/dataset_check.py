"""`check_dataset`: whether a data set is undamaged, and whether it has the actions that its policy chooses."""

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.base import json_text
from atari.base.text_table import Table
from atari.base.validation import check_file
from atari.lab.dataset import ENDINGS, columns_of, import_format
from atari.lab.dataset_reader import StoredDataset, StoredEpisode, read_dataset
from atari.policy import LoadedPolicy, Policy
from atari.policy.choice import Choice
from atari.policy.needs import needs_of
from atari.policy.watched import WatchedPolicy
from atari.recording.stacks import Stacking
from atari.task import Task

_TIE = 1e-5
"""The gap of the two best scores below which rounding decides between them."""

_BLOCK = 512
"""States whose stacks are in memory."""

_MOST_TIES = 0.001
"""The part of the greedy steps that may be near ties."""


@dataclass(frozen=True)
class Agreement:
    """How many actions of a data set a policy chooses again, by how they were chosen; `str` is a table.

    Attributes:
        steps: the numbers of steps, by `Choice`.
        equal: the numbers of steps with the recorded action.
        near_ties: the numbers of steps with another action, where the two best scores differ by less than 1e-5.
    """

    steps: Mapping[Choice, int]
    equal: Mapping[Choice, int]
    near_ties: Mapping[Choice, int]

    @property
    def agrees(self) -> bool:
        """Whether the actions of all greedy steps are equal, but for near ties in less than 0.1 % of them."""
        steps, equal, ties = (counts[Choice.GREEDY] for counts in (self.steps, self.equal, self.near_ties))
        return equal + ties == steps and ties <= _MOST_TIES * steps

    @property
    def table(self) -> Table:
        """A row for each kind of choice that occurs."""
        columns = "chosen", "steps", "equal", "near ties", "different"
        counts = [(one, self.steps[one], self.equal[one], self.near_ties[one]) for one in Choice if self.steps[one]]
        rows = [(one.name.lower(), steps, same, ties, steps - same - ties) for one, steps, same, ties in counts]
        return Table.of(columns, rows)

    def __str__(self) -> str:
        return str(self.table)


def check_dataset(source: str | os.PathLike[str], policy: Policy | None = None) -> Agreement | None:
    """Read a data set of `write_dataset` from its beginning to its end, and compare all checksums and actions.

    HDF5 compares the checksums of data that a program reads, Parquet with `page_checksum_verification=True` alone.
    Neither compares the checksum of the facts, which is the attribute or metadata "sha256". Minari writes its own
    files, without checksums.

    With `policy`, the policy chooses an action again in each state, from the stored observations, and in the order of
    play: it gets batches of one observation, the seeds of the games, and the beginnings of episodes.

    Args:
        source: an HDF5 or Parquet file, or a folder of Parquet files; with `policy` also the ID of a Minari dataset.
        policy: the policy that has played, see `atari.learning.load_policy`. None compares no actions.

    Returns:
        The agreement of all steps, or None without a policy.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: the file was changed after it was written, or is no such file; or the policy chooses another action
            in a greedy step, where its two best scores differ by 1e-5 or more, or near ties are more than 0.1 % of the
            greedy steps; or the observations are not those that the policy saw, or no step is greedy.
        gymnasium.error.DependencyNotInstalled: the package that reads the format is not installed.

    Example:
        >>> from atari.lab import check_dataset
        >>> check_dataset("game.h5")  # doctest: +SKIP
    """
    path = Path(source)
    parts = sorted(path.glob("*.parquet")) if path.is_dir() else [path]
    if policy is None or ENDINGS.get(path.suffix.lower()) or path.is_dir():
        for part in parts:
            _check_file(part)
    if policy is None:
        return None
    agreement = compare_actions(read_dataset(source), policy)
    if not agreement.steps[Choice.GREEDY]:
        raise ValueError(f"{source} has no greedy step that could be compared; its steps:\n{agreement}")
    if not agreement.agrees:
        raise ValueError(
            f"{source} has other actions than the policy chooses; was it played by this policy? Its steps:\n{agreement}"
        )
    return agreement


def compare_actions(dataset: StoredDataset, policy: Policy) -> Agreement:
    """Let a policy choose the actions of a data set again, see `check_dataset`.

    Raises:
        ValueError: the observations are not those that the policy saw, or do not fit it.
    """
    task, kind = dataset.task, dataset.facts["observations"]["kind"]
    if kind != "seen":
        raise ValueError(f'the data set has observations={kind!r}, and a policy chooses from what it saw: "seen"')
    again = _PolicyAgain(policy, task)
    steps, equal, ties = (dict.fromkeys(Choice, 0) for _ in range(3))
    for episode in dataset:
        same, near = again.choose(episode)
        for one in Choice:
            chosen = episode.chosen == one
            steps[one] += int(chosen.sum())
            equal[one] += int((chosen & same).sum())
            ties[one] += int((chosen & near).sum())
    return Agreement(steps, equal, ties)


class _PolicyAgain:
    """A policy that gets the observations of episodes again, in one lane."""

    def __init__(self, policy: Policy, task: Task) -> None:
        self._policy = WatchedPolicy(policy if isinstance(policy, LoadedPolicy) else LoadedPolicy(policy))
        self._task = task
        needs = needs_of(self._policy, task.definition)
        self._layout = needs.layout(task)
        every = tuple(action.name for action in task.action_set)
        self._names = needs.actions or every
        self._indices = [every.index(name) for name in self._names]

    def choose(self, episode: StoredEpisode) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
        """Whether the action of each step is equal, and whether another one is a near tie."""
        lane, task = np.zeros(1, np.int64), self._task
        begins = np.zeros(len(episode) + 1, np.bool_) if episode.stack is None else episode.stack == Stacking.BEGUN
        self._policy.begin(task.game, self._names, lane, np.array([episode.seed or 0], np.int64))
        same, near = np.zeros(len(episode), np.bool_), np.zeros(len(episode), np.bool_)
        for step, observation in enumerate(self._each(episode)):
            if step and task.new_stack_after_life and begins[step]:
                self._policy.begin_episodes(lane)
            (action,) = self._policy(self._layout.apply(observation), lane)
            same[step] = self._indices[action] == episode.actions[step]
            near[step] = not same[step] and self._gap() < _TIE
        return same, near

    def _each(self, episode: StoredEpisode) -> Iterator[Any]:
        """The observations before the steps as batches of one, in the engine's form."""
        flat = self._task.kind.image is not None and self._task.stack_num is None
        for first in range(0, len(episode), _BLOCK):
            block = episode.observations(first, min(first + _BLOCK, len(episode)))
            yield from block[:, None, None] if flat else block[:, None]

    def _gap(self) -> float:
        """The gap of the two best scores of the last call; infinite for a policy without scores."""
        scores = self._policy.last_scores
        if scores is None or scores.shape[1] < 2:
            return np.inf
        second, best = np.sort(scores[0])[-2:]
        return float(best - second)


def _check_file(path: Path) -> None:
    found = ENDINGS.get(check_file(path).suffix.lower())
    if found is None:
        raise ValueError(f"{path} must end in one of {', '.join(ENDINGS)}")
    module = import_format(found)
    try:
        (_check_parquet if found == "parquet" else _check_hdf5)(module, path)
    except Exception as error:  # both libraries raise errors of all kinds
        raise ValueError(f"{path} is damaged: {error}") from error


def _check_hdf5(h5py: Any, path: Path) -> None:
    def read(_: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            item[()]

    with h5py.File(path) as root:
        json_text.check_seal(dict(root.attrs))
        root.visititems(read)


def _check_parquet(parquet: Any, path: Path) -> None:
    with parquet.ParquetFile(path, page_checksum_verification=True) as file:
        for group in range(file.num_row_groups):
            schema = file.read_row_group(group).schema
        for stored in (file.metadata.metadata, schema.metadata):  # the file has them twice
            facts = {key.decode(): value.decode() for key, value in stored.items() if key != b"ARROW:schema"}
            if json_text.check_seal(facts)["columns"] != columns_of(schema):
                raise ValueError("its columns are not those that were written")
