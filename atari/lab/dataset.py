"""`write_dataset`: recorded games as data: frames, RAM, values of labels, actions, rewards, in three formats.

Replays are played again, so that games of a policy, a person or a training become data, whatever they observed.
"""

import json
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from importlib import import_module
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

import cv2
import numpy as np
import numpy.typing as npt

from atari.base import durable, json_text
from atari.base.extras import import_extra, pip_install
from atari.base.validation import check_file, check_name
from atari.base.writer_process import write_apart
from atari.lab.labels import Labels
from atari.recording.episodes import EpisodeArrays, Source, facts_of_replays, load_replays, replayed_episodes
from atari.recording.minari import NO_STEPS, check_new_dataset, import_minari, write_minari

Format = Literal["minari", "parquet", "hdf5"]

ENDINGS: dict[str, Format] = {".parquet": "parquet", ".h5": "hdf5", ".hdf5": "hdf5"}
"""The format of a file by its ending."""

_COLOURS = ("rgb", "grayscale")
_OWN_FACTS = {"columns", "game", "labels", "options", "sha256"}
_CHECKED: dict[str, Any] = {"fletcher32": True}
_GZIP: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, **_CHECKED}
_HDF5_VERSION = "v110"  # the oldest format with checksums of groups and attributes
_PORTION = 1 << 24  # bytes that the process that writes HDF5 has in memory


def write_dataset(
    replays: Source | Iterable[Source],
    output: str | os.PathLike[str],
    *,
    format: Format | None = None,
    frames: Literal["rgb", "grayscale"] = "rgb",
    labels: Sequence[str] | None = None,
    core: str = "native",
    first_episode: int = 0,
    facts: Mapping[str, Any] | None = None,
    progress: Callable[[int], object] | None = None,
) -> dict[str, Any]:
    """Write the steps of replays as a data set: frames, RAM, values of labels, actions, rewards, ends.

    A step is a step of the recorded environment, as in `to_minari`. An episode of n steps has n + 1 states, beginning
    with the state before the first step. One episode at a time is in memory: 100 kB a step in RGB, a third in
    grayscale. Another process writes HDF5 and Minari, which crash after a failed write; for Minari it has the episode
    in memory, too.

    - "hdf5": a group `episode_0`, ... for each episode, with the datasets `frames` (n + 1, height, width[, 3]) and
      `ram` (n + 1, 128), uint8, `actions` (n,) int64 (or (n, 3) float32), `rewards` (n,) float64, `terminations` and
      `truncations` (n,) bool. The group `labels` has a dataset (n + 1,) int32 for each label; the group `visible` has
      a dataset (n + 1,) bool for each label that can be invisible. The attributes of the file have `game`, `options`
      and `labels` as JSON. Readers need HDF5 1.10 or newer.
    - "parquet": a row for each state, with the columns `episode`, `step`, `frame` (PNG), `ram` (128 bytes), a column
      `label.NAME` for each label (null where it is not visible), and `action`, `reward`, `terminated`, `truncated` of
      the step from this state (null in the last state of an episode).
    - "minari": a Minari dataset of dict observations `image` and `ram`. Its infos have `labels` and `visible`.

    Args:
        replays: `Replay`s or files, of one game with the same options.
        output: the file, or the ID of the Minari dataset, such as "atari/pong/random-v0". It must not exist.
        format: the format; None decides by the ending of `output`: .parquet, .h5, .hdf5; with "-v0" or the like at the
            end, "minari".
        frames: the colours of the frames.
        labels: names of labels; None writes all labels of the game.
        core: the core to play the replays on.
        first_episode: the number of the first episode, in Parquet and HDF5.
        facts: facts of JSON's types. The attributes of an HDF5 file, and the metadata of a Parquet file and of a Minari
            dataset, have them as JSON, beside the replays' own: `task`, `core_seeds` and `package`, see
            `atari.recording.Replay.facts`. `atari collect` writes the task with all fields, as the object of
            `Task.to_json`, the `policy`, and the `seeds` of the episodes.
        progress: called with the number of steps of each episode that was written.

    Returns:
        `output`, the format, the numbers of `episodes` and `steps`, the `score` of each, and the names of the `labels`.

    Raises:
        ValueError: there are no replays, they differ in game or options, or have no steps; `output` exists or has
            another ending.
        KeyError: the game has no such label.
        OSError: the file cannot be written, for example because the disk is full; nothing of it stays.
        gymnasium.error.DependencyNotInstalled: the package of the format is not installed; the text names it.

    Example:
        >>> import atari
        >>> from atari.lab import write_dataset
        >>> from atari.recording import RecordReplay
        >>> env = RecordReplay(atari.AtariEnv("pong"), "game.a26r")
        >>> observation, info = env.reset(seed=0)
        >>> for _ in range(10):
        ...     observation = env.step(2)[0]
        >>> env.close()
        >>> written = write_dataset("game.a26r", "game.h5", labels=["ball_x"])
        >>> written["episodes"], written["steps"], written["labels"]
        (1, 10, ['ball_x'])
    """
    format = check_output(output, format)
    check_name("frames", frames, _COLOURS)
    module = _import_format(format)
    loaded = load_replays(replays)
    named = Labels(loaded[0].game, labels)
    if taken := _OWN_FACTS & {*(facts or {})}:
        raise ValueError(f"facts cannot have the name {min(taken)!r}, which the file has for its own; choose another")
    said = {**facts_of_replays(loaded), **(facts or {})}
    scores: list[float] = []
    steps: list[int] = []

    def episodes() -> Iterator[tuple[EpisodeArrays, Values]]:
        for episode in replayed_episodes(loaded, "dict", core, frames):
            yield episode, _values(named, episode.observations["ram"])
            scores.append(float(episode.rewards.sum()))
            steps.append(len(episode.rewards))
            if progress is not None:
                progress(steps[-1])

    if format == "minari":
        infos = (replace(episode, infos={**episode.infos, **values}) for episode, values in episodes())
        write_minari(infos, os.fspath(output), loaded[0], "dict", core=core, image=frames, facts=_as_json(said))
    else:
        write = _write_parquet if format == "parquet" else _write_hdf5
        described = {name: asdict(named.game.ram_labels[name]) for name in named.names}
        attributes = {**_as_json(said), "game": loaded[0].game.id}
        attributes |= _as_json({"options": loaded[0].options, "labels": described})
        Path(output).parent.mkdir(parents=True, exist_ok=True)
        with durable.replacing(Path(output)) as file:
            write(module, file, attributes, enumerate(episodes(), first_episode))
            if not scores:
                raise ValueError(NO_STEPS)
    return {
        "output": os.fspath(output),
        "format": format,
        "episodes": len(scores),
        "steps": sum(steps),
        "scores": scores,
        "labels": list(named.names),
    }


def check_dataset(file: str | os.PathLike[str]) -> None:
    """Read a file of `write_dataset` from its beginning to its end, and compare all checksums.

    HDF5 compares the checksums of data that a program reads, Parquet with `page_checksum_verification=True` alone.
    Neither compares the checksum of the facts, which is the attribute or metadata "sha256".

    Args:
        file: an HDF5 or Parquet file. Minari writes its own files, without checksums.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: the file was changed after it was written, or is no such file.
        gymnasium.error.DependencyNotInstalled: h5py or pyarrow, which reads the format, is not installed.

    Example:
        >>> from atari.lab import check_dataset
        >>> check_dataset("game.h5")  # doctest: +SKIP
    """
    path = check_file(Path(file))
    found = ENDINGS.get(path.suffix.lower())
    if found is None:
        raise ValueError(f"{path} must end in one of {', '.join(ENDINGS)}")
    module = _import_format(found)
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
            if json_text.check_seal(facts)["columns"] != _columns_of(schema):
                raise ValueError("its columns are not those that were written")


def _columns_of(schema: Any) -> str:
    return json.dumps([[column.name, str(column.type)] for column in schema])


def check_output(output: str | os.PathLike[str], format: str | None = None) -> Format:
    """The format of an output that does not exist yet, as `output_format`.

    Raises:
        TypeError, ValueError, gymnasium.error.DependencyNotInstalled: as `output_format`; or there is such a file or
            dataset.
    """
    text, found = os.fspath(output), output_format(output, format)
    if found == "minari":
        check_new_dataset(import_minari(), text)
    elif Path(text).exists():
        raise ValueError(f"there is a file {text} already; delete it, or choose another name")
    return found


def output_format(output: str | os.PathLike[str], format: str | None = None) -> Format:
    """The format of an output: `format`, or by the output's ending.

    Raises:
        TypeError, ValueError: there is no such format, or the ending names no format.
        gymnasium.error.DependencyNotInstalled: the package that writes the format is not installed.
    """
    text = os.fspath(output)
    found = ENDINGS.get(Path(text).suffix.lower()) or ("minari" if re.search(r"-v\d+$", text) else None)
    if format is not None:
        found = check_name("format", format, get_args(Format))  # type: ignore[assignment]
    if found is None:
        raise ValueError(
            f"the output {text!r} says no format: end it in {', '.join(ENDINGS)}, or in -v0 for a Minari dataset, or "
            f"name one of {', '.join(get_args(Format))}"
        )
    _import_format(found)
    return found


def _import_format(format: Format) -> Any:
    if format == "minari":
        return import_minari()
    name = {"parquet": "pyarrow.parquet", "hdf5": "h5py"}[format]
    package = name.partition(".")[0]
    return import_extra(name, f"a data set in the format {format} needs {package}: {pip_install(package)}")


Values: TypeAlias = dict[str, dict[str, npt.NDArray[Any]]]
Numbered: TypeAlias = Iterable[tuple[int, tuple[EpisodeArrays, Values]]]


def _values(labels: Labels, ram: npt.NDArray[np.uint8]) -> Values:
    values, visible = labels.evaluate(ram)
    hidden = {labels.names[number]: visible[number] for number in labels.hiding}
    return {"labels": dict(zip(labels.names, values, strict=True)), "visible": hidden}


def _as_json(facts: Mapping[str, Any]) -> dict[str, str]:
    return {name: json.dumps(value) for name, value in facts.items()}


def _write_hdf5(_: Any, file: Path, facts: Mapping[str, str], episodes: Numbered) -> None:
    arguments = {"path": os.fspath(file), "facts": json_text.seal(facts), "version": _HDF5_VERSION}
    write_apart("hdf5", arguments, _hdf5_parts(episodes))


def _hdf5_parts(episodes: Numbered) -> Iterator[tuple[str, Any]]:
    """The groups and datasets of episodes, in portions; see `atari.base.writer_process`."""
    for number, (episode, values) in episodes:
        group = f"episode_{number}"
        frames = episode.observations["image"]
        yield from _portions(f"{group}/frames", frames, {"chunks": (1, *frames.shape[1:]), **_GZIP})
        yield from _portions(f"{group}/ram", episode.observations["ram"], _GZIP)
        for name in ("actions", "rewards", "terminations", "truncations"):
            yield from _portions(f"{group}/{name}", getattr(episode, name), _CHECKED)
        for kind, columns in values.items():
            yield f"{group}/{kind}", None
            for name, column in columns.items():
                yield from _portions(f"{group}/{kind}/{name}", column, _GZIP)


def _portions(name: str, array: npt.NDArray[Any], options: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    rows = max(1, _PORTION // max(1, array[0].nbytes))
    for first in range(0, len(array), rows):
        yield name, (array.shape, first, array[first : first + rows], options)


def _write_parquet(parquet: Any, file: Path, facts: Mapping[str, str], episodes: Numbered) -> None:
    pyarrow = import_module("pyarrow")
    writer = None
    try:
        for number, (episode, values) in episodes:
            table = pyarrow.table(_columns(pyarrow, number, episode, values))
            if writer is None:
                sealed = json_text.seal({**facts, "columns": _columns_of(table.schema)})
                schema = table.schema.with_metadata(sealed)
                writer = parquet.ParquetWriter(file, schema, compression="zstd", write_page_checksum=True)
            writer.write_table(table.cast(writer.schema))
    finally:
        if writer is not None:
            writer.close()


def _columns(pyarrow: Any, number: int, episode: EpisodeArrays, values: Values) -> dict[str, Any]:
    states = len(episode.rewards) + 1
    last = np.arange(states) == states - 1

    def with_last(column: npt.NDArray[Any]) -> Any:
        if column.ndim == 1:
            return pyarrow.array(np.append(column, column[-1:]), mask=last)
        return pyarrow.array([*column.tolist(), None], pyarrow.list_(pyarrow.float32()))

    columns = {
        "episode": pyarrow.array(np.full(states, number, np.int64)),
        "step": pyarrow.array(np.arange(states, dtype=np.int32)),
        "frame": pyarrow.array([_png(frame) for frame in episode.observations["image"]]),
        "ram": pyarrow.array([row.tobytes() for row in episode.observations["ram"]], pyarrow.binary(128)),
        "action": with_last(episode.actions),
        "reward": with_last(episode.rewards),
        "terminated": with_last(episode.terminations),
        "truncated": with_last(episode.truncations),
    }
    for name, column in values["labels"].items():
        visible = values["visible"].get(name)
        columns[f"label.{name}"] = pyarrow.array(column, mask=None if visible is None else ~visible)
    return columns


def _png(frame: npt.NDArray[np.uint8]) -> bytes:
    pixels = cv2.cvtColor(frame, cv2.COLOR_RGB2BGR) if frame.ndim == 3 else frame
    return bytes(cv2.imencode(".png", pixels, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1])
