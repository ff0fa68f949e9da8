"""The files of monitors: how they are written, which are in a folder, and what they say together."""

import json
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from os import replace  # noqa: F401, a name of Gym's `utils.atomic_write`
from pathlib import Path
from typing import IO, Any

import numpy as np

from atari.base import durable
from atari.classic import error, logger

FILE_PREFIX = "openaigym"
MANIFEST_PREFIX = f"{FILE_PREFIX}.manifest"

Folder = str | os.PathLike[str]


def detect_monitor_files(training_dir: Folder) -> list[str]:
    """The paths of all files of monitors in a folder."""
    return sorted(str(path) for path in Path(training_dir).glob(f"{FILE_PREFIX}.*"))


def detect_training_manifests(training_dir: Folder, files: Sequence[str] | None = None) -> list[str]:
    """The paths of the manifests in a folder, or of those among the names `files`."""
    names = sorted(os.listdir(training_dir)) if files is None else files
    return [os.path.join(training_dir, name) for name in names if name.startswith(f"{MANIFEST_PREFIX}.")]


def clear_monitor_files(training_dir: Folder) -> None:
    """Remove all files of monitors in a folder."""
    for path in detect_monitor_files(training_dir):
        os.unlink(path)


def load_results(training_dir: Folder) -> dict[str, Any] | None:
    """The records of all monitors of a folder, with the episodes in the order of time; None if there is nothing.

    Returns:
        "manifests", "videos" (paths), "env_info", and a list with an item for each episode: "episode_lengths",
        "episode_rewards", "episode_types", "timestamps", and "data_sources", the number of its statistics file.
        "initial_reset_timestamps" has an item for each file, "initial_reset_timestamp" is the least.

    Raises:
        gymnasium.error.Error: the monitors had different environments.

    Example:
        >>> import tempfile
        >>> import atari.classic as gym
        >>> from atari.classic.wrappers.monitor import load_results
        >>> folder = tempfile.mkdtemp()
        >>> with gym.wrappers.Monitor(gym.make("CartPole-v0"), folder, video_callable=False) as env:
        ...     observation = env.reset()
        ...     result = env.step(0)
        >>> load_results(folder)["episode_lengths"]
        [1]
    """
    manifests = detect_training_manifests(training_dir) if os.path.exists(training_dir) else []
    if not manifests:
        logger.error("there is no manifest of a monitor in %s", training_dir)
        return None
    contents = [_read(path) for path in manifests]
    names = ("data_sources", "initial_reset_timestamps", "timestamps", "episode_lengths", "episode_rewards")
    stats = merge_stats_files([os.path.join(training_dir, each["stats"]) for each in contents])
    return {
        "manifests": manifests,
        "env_info": collapse_env_infos([each["env_info"] for each in contents], training_dir),
        **dict(zip((*names, "episode_types", "initial_reset_timestamp"), stats, strict=True)),
        "videos": [
            tuple(os.path.join(training_dir, name) for name in video) for each in contents for video in each["videos"]
        ],
    }


def merge_stats_files(stats_files: Sequence[Folder]) -> tuple[Any, ...]:
    """The statistics of several files, with the episodes in the order of time.

    Returns:
        Lists for the episodes' file numbers, for the first reset of each file, and for the episodes' timestamps,
        lengths, rewards and types (None if no file has types), and the time of the first reset (0 without episodes).
    """
    contents = {number: each for number, each in enumerate(map(_read, stats_files)) if each["timestamps"]}
    places = [(number, i) for number, each in contents.items() for i in range(len(each["timestamps"]))]
    order = sorted(places, key=lambda place: contents[place[0]]["timestamps"][place[1]])

    def merged(name: str) -> list[Any]:
        return [contents[number][name][i] for number, i in order]

    has_types = bool(contents) and all("episode_types" in each for each in contents.values())
    starts = [each["initial_reset_timestamp"] for each in contents.values()]
    return (
        [number for number, _ in order],
        starts,
        merged("timestamps"),
        merged("episode_lengths"),
        merged("episode_rewards"),
        merged("episode_types") if has_types else None,
        min(starts, default=0),
    )


def load_env_info_from_manifests(manifests: Sequence[Folder], training_dir: Folder) -> dict[str, Any]:
    """The `env_info` that all manifests have; see `collapse_env_infos`."""
    return collapse_env_infos([_read(path)["env_info"] for path in manifests], training_dir)


def collapse_env_infos(env_infos: Sequence[dict[str, Any]], training_dir: Folder) -> dict[str, Any]:
    """The `env_info` that all have.

    Raises:
        gymnasium.error.Error: there is none, two differ, or one lacks the ID or the version.
    """
    if not env_infos:
        raise error.Error(f"there is no env_info in {training_dir}")
    for other in env_infos:
        if other != env_infos[0]:
            raise error.Error(
                f"{training_dir} has results of several runs, with {env_infos[0]} and {other}; give each run a folder"
            )
        if not {"env_id", "gym_version"} <= set(other):
            raise error.Error(f"an env_info has 'env_id' and 'gym_version', got {other} in {training_dir}")
    return env_infos[0]


def capped_cubic_video_schedule(episode_id: int) -> bool:
    """Whether an episode is recorded by default: 0, 1, 8, 27, ..., then every thousandth."""
    return round(episode_id ** (1 / 3)) ** 3 == episode_id if episode_id < 1000 else episode_id % 1000 == 0


def disable_videos(episode_id: int) -> bool:
    """False: no episode is recorded."""
    return False


@contextmanager
def atomic_write(filepath: str | os.PathLike[str], binary: bool = False, fsync: bool = False) -> Iterator[IO[Any]]:
    """A file to write, which takes the place of `filepath` once the block ends without an exception.

    Args:
        filepath: the file.
        binary: whether it takes bytes rather than text.
        fsync: has no effect; the content is on the disk.

    Example:
        >>> import pathlib, tempfile
        >>> from atari.classic.utils.atomic_write import atomic_write
        >>> path = pathlib.Path(tempfile.mkdtemp(), "results.txt")
        >>> with atomic_write(path) as file:
        ...     _ = file.write("195.0")
        >>> path.read_text()
        '195.0'
    """
    with durable.replacing(Path(filepath)) as part, open(part, "wb" if binary else "w") as file:
        yield file


def json_encode_np(obj: Any) -> Any:
    """The Python value of a number or array of NumPy.

    Raises:
        TypeError: it is something else, which JSON cannot hold.

    Example:
        >>> import json, numpy
        >>> from atari.classic.utils.json_utils import json_encode_np
        >>> json.dumps({"steps": numpy.int64(200)}, default=json_encode_np)
        '{"steps": 200}'
    """
    if isinstance(obj, (np.ndarray, np.generic)):
        return obj.tolist()
    if obj is None or isinstance(obj, (str, int, float, list, dict)):
        return obj
    raise TypeError(f"JSON holds no {type(obj).__name__}, got {obj!r}; give numbers, texts, lists or dictionaries")


def _read(path: Folder) -> dict[str, Any]:
    return json.loads(Path(path).read_text(encoding="utf-8"))
