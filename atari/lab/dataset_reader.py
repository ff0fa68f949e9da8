"""`read_dataset`: the episodes of a data set of `write_dataset`, with the observations that an agent got."""

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.base import json_text
from atari.base.extras import import_extra, pip_install
from atari.lab.dataset import ENDINGS, VERSION, Format, import_format
from atari.recording.stacks import rows_of_stacks
from atari.task import Task

Array = npt.NDArray[Any]

_TEXTS = ("game", "columns", "sha256")
"""The facts that are not JSON, or of the file's form alone."""


@dataclass(frozen=True, eq=False)
class StoredEpisode:
    """One episode of n steps; see `write_dataset` for the arrays.

    Attributes:
        number: its number in the data set.
        seed: the seed of the game; None if the data set does not have it.
        frames: (n + 1, ...) uint8; None without frames.
        stack: (n + 1,) uint8; None unless the frames are those that an agent saw.
        ram: (n + 1, 128) uint8.
        actions, rewards, terminations, truncations, chosen: (n,).
        stack_num, padding: the task's, for `observations`.
    """

    number: int
    seed: int | None
    frames: Array | None
    stack: npt.NDArray[np.uint8] | None
    ram: npt.NDArray[np.uint8]
    actions: Array
    rewards: npt.NDArray[np.float64]
    terminations: npt.NDArray[np.bool_]
    truncations: npt.NDArray[np.bool_]
    chosen: npt.NDArray[np.uint8]
    stack_num: int | None = None
    padding: str = "zero"

    def __len__(self) -> int:
        """The number of steps."""
        return len(self.actions)

    def observations(self, first: int = 0, stop: int | None = None) -> Array:
        """The observations of the states first .. stop-1, equal to the bit to what the agent got, (states, ...) uint8.

        With stacks they are (states, stack_num, ...), the oldest frame first, as from `AtariVectorEnv`. In a data set
        of screens they are the frames, in one without frames the RAM.

        Args:
            first, stop: states, 0..n; None is the end. A stack of four images of 84x84 takes 28 kB.
        """
        frames = self.ram if self.frames is None else self.frames
        if self.stack is None or self.stack_num is None:
            return frames[first:stop]
        rows = self.stack_rows[first:stop]
        stacks = frames[rows]
        stacks[rows < 0] = 0
        return stacks

    @cached_property
    def stack_rows(self) -> npt.NDArray[np.int64]:
        """The rows of `frames` in each state's stack, (n + 1, stack_num), the oldest first; -1 is a frame of zeros.

        Raises:
            ValueError: the episode has no stacks.
        """
        if self.stack is None or self.stack_num is None:
            raise ValueError('the episode has no stacks of frames; write_dataset(..., observations="seen") stores them')
        return rows_of_stacks(self.stack, self.stack_num, self.padding)


class StoredDataset:
    """A data set that was opened by `read_dataset`. Iterating reads one episode at a time, in their order.

    Attributes:
        files: the files, or the ID of the Minari dataset.
        facts: the facts of the first file, such as `task`, `policy`, `seeds`, `observations`.

    Raises:
        ValueError: it is no data set of `write_dataset`, or of another version.
    """

    def __init__(self, files: Sequence[str | Path], format: Format) -> None:
        self.files = files
        self._format = format
        self._module = import_format(format)
        self.facts: Mapping[str, Any] = self._facts_of(files[0])

    @property
    def task(self) -> Task:
        """The task that was played."""
        return Task.from_json(json.dumps(self.facts["task"]))

    def __iter__(self) -> Iterator[StoredEpisode]:
        """Read the episodes."""
        for file in self.files:
            facts = self._facts_of(file)
            seen, seeds = facts["observations"], facts.get("seeds") or ()
            for index, (number, arrays) in enumerate(_READERS[self._format](self._module, file)):
                stack = {name: seen[name] for name in ("stack_num", "padding") if name in seen}
                episode = StoredEpisode(number, seeds[index] if index < len(seeds) else None, **arrays, **stack)
                arrays.clear()  # a caller can drop the episode before the next is read
                yield episode
                del episode

    def stacks(self) -> Iterator[npt.NDArray[np.uint8]]:
        """Read the array `stack` of each episode, (n + 1,) uint8, without its frames from HDF5 and Parquet.

        Raises:
            ValueError: the data set does not have what an agent saw.
        """
        if (kind := self.facts["observations"]["kind"]) != "seen":
            raise ValueError(
                f'{self.files[0]} has observations={kind!r}, not what the agent saw; write it with observations="seen" '
                "(--observations seen)"
            )
        for file in self.files:
            yield from _STACKS[self._format](self._module, file)

    def _facts_of(self, file: str | Path) -> dict[str, Any]:
        texts = _FACTS[self._format](self._module, file)
        facts = {name: json_text.parse(text, str(file)) for name, text in texts.items() if name not in _TEXTS}
        described = facts.get("observations")
        version = described.get("version") if isinstance(described, dict) else None
        if version != VERSION or "task" not in facts:
            raise ValueError(f"{file} has data of version {version}, not {VERSION}; write it again from its replays")
        return facts


def read_dataset(source: str | os.PathLike[str]) -> StoredDataset:
    """Open a data set of `write_dataset` or `atari collect`.

    Args:
        source: an HDF5 or Parquet file, a folder of Parquet files, or the ID of a Minari dataset.

    Raises:
        FileNotFoundError: there is no such file or dataset.
        ValueError: it is no data set of this package, or of another version.
        gymnasium.error.DependencyNotInstalled: the package that reads the format is not installed.

    Example:
        >>> import atari
        >>> from atari.lab import read_dataset, write_dataset
        >>> from atari.recording import RecordReplay
        >>> with RecordReplay(atari.make("pong", preset="dqn2015"), "game.a26r") as env:
        ...     observation, info = env.reset(seed=0)
        ...     for _ in range(10):
        ...         observation = env.step(2)[0]
        >>> written = write_dataset("game.a26r", "game.h5", observations="seen")
        >>> (episode,) = read_dataset("game.h5")
        >>> episode.frames.shape, episode.observations().shape
        ((11, 84, 84), (11, 4, 84, 84))
        >>> bool((episode.observations()[-1] == observation).all())
        True
    """
    path = Path(source)
    if path.is_dir() and (files := sorted(path.glob("*.parquet"))):
        return StoredDataset(files, "parquet")
    if (format := ENDINGS.get(path.suffix.lower())) is None:
        return StoredDataset([os.fspath(source)], "minari")
    if not path.is_file():
        raise FileNotFoundError(f"there is no data set {path}")
    return StoredDataset([path], format)


def _hdf5_facts(h5py: Any, file: Path) -> dict[str, Any]:
    with h5py.File(file) as root:
        return dict(root.attrs)


def _hdf5_episodes(h5py: Any, file: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    names = ("frames", "stack", "ram", "actions", "rewards", "terminations", "truncations", "chosen")
    with h5py.File(file) as root:
        for number in _hdf5_numbers(root):
            group = root[f"episode_{number}"]
            yield number, {name: group[name][()] if name in group else None for name in names}


def _hdf5_stacks(h5py: Any, file: Path) -> Iterator[npt.NDArray[np.uint8]]:
    with h5py.File(file) as root:
        yield from (root[f"episode_{number}/stack"][()] for number in _hdf5_numbers(root))


def _hdf5_numbers(root: Any) -> list[int]:
    return sorted(int(name.removeprefix("episode_")) for name in root)


def _parquet_facts(parquet: Any, file: Path) -> dict[str, Any]:
    stored = parquet.read_schema(file).metadata or {}
    return {key.decode(): value.decode() for key, value in stored.items() if key != b"ARROW:schema"}


def _parquet_episodes(parquet: Any, file: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    with parquet.ParquetFile(file, page_checksum_verification=True) as opened:
        columns = [name for name in opened.schema_arrow.names if not name.startswith("label.")]
        for group in range(opened.num_row_groups):
            yield _parquet_episode(opened.read_row_group(group, columns))


def _parquet_episode(table: Any) -> tuple[int, dict[str, Any]]:
    names = {"rewards": "reward", "terminations": "terminated", "truncations": "truncated", "chosen": "chosen"}
    steps = table.slice(0, len(table) - 1)
    arrays = {name: steps[column].to_numpy() for name, column in names.items()}
    actions = steps["action"]
    several = actions.type.num_fields > 0  # (radius, angle, fire)
    arrays["actions"] = np.array(actions.to_pylist(), np.float32) if several else actions.to_numpy()
    arrays["ram"] = np.array([np.frombuffer(row.as_py(), np.uint8) for row in table["ram"]])
    columns = table.column_names
    arrays["frames"] = np.array([_image(frame.as_py()) for frame in table["frame"]]) if "frame" in columns else None
    arrays["stack"] = table["stack"].to_numpy() if "stack" in columns else None
    return table["episode"][0].as_py(), arrays


def _parquet_stacks(parquet: Any, file: Path) -> Iterator[npt.NDArray[np.uint8]]:
    with parquet.ParquetFile(file, page_checksum_verification=True) as opened:
        for group in range(opened.num_row_groups):
            yield opened.read_row_group(group, ["stack"])["stack"].to_numpy()


def _image(stored: bytes) -> Array:
    data = np.frombuffer(stored, np.uint8)
    if len(data) == 128:  # RAM; a PNG file of any screen is longer
        return data
    pillow = import_extra("PIL.Image", f"the frames of a data set in Parquet need Pillow: {pip_install('pillow')}")
    try:
        with pillow.open(BytesIO(stored), formats=("PNG",)) as image:
            return np.array(image)
    except (OSError, SyntaxError, pillow.DecompressionBombError) as error:
        raise ValueError("a frame is no PNG image") from error


def _minari_facts(minari: Any, dataset_id: str) -> dict[str, Any]:
    if dataset_id not in minari.list_local_datasets():
        raise FileNotFoundError(f"there is no data set {dataset_id}; name a file (.h5, .parquet) or a Minari dataset")
    stored = minari.load_dataset(dataset_id).storage.metadata
    return {name: stored[name] for name in ("task", "policy", "seeds", "observations") if name in stored}


def _minari_episodes(minari: Any, dataset_id: str) -> Iterator[tuple[int, dict[str, Any]]]:
    for episode in minari.load_dataset(dataset_id).iterate_episodes():
        shown, infos = episode.observations, episode.infos
        arrays = {name: getattr(episode, name) for name in ("actions", "rewards", "terminations", "truncations")}
        frames = {"frames": shown.get("image"), "ram": shown["ram"], "stack": infos.get("stack")}
        yield int(episode.id), {**arrays, **frames, "chosen": infos["chosen"][:-1]}


def _minari_stacks(minari: Any, dataset_id: str) -> Iterator[npt.NDArray[np.uint8]]:
    return (episode.infos["stack"] for episode in minari.load_dataset(dataset_id).iterate_episodes())


_FACTS: Mapping[Format, Any] = {"hdf5": _hdf5_facts, "parquet": _parquet_facts, "minari": _minari_facts}
_READERS: Mapping[Format, Any] = {"hdf5": _hdf5_episodes, "parquet": _parquet_episodes, "minari": _minari_episodes}
_STACKS: Mapping[Format, Any] = {"hdf5": _hdf5_stacks, "parquet": _parquet_stacks, "minari": _minari_stacks}
