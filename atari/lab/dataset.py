"""`write_dataset`: recorded games as data: observations, RAM, values of labels, actions, rewards, in three formats.

Replays are played again, so that games of a policy, a person or a training become data.
"""

import json
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from importlib import import_module
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
import numpy.typing as npt

from atari.base import durable, json_text
from atari.base.extras import import_extra, pip_install
from atari.base.png import png
from atari.base.validation import check_name
from atari.base.writer_process import write_apart
from atari.env.env import ObsType
from atari.lab.labels import Labels
from atari.policy.choice import Choice
from atari.recording.episodes import (
    EpisodeArrays,
    Source,
    check_seen,
    facts_of_replays,
    load_replays,
    replayed_episodes,
    seen_episodes,
)
from atari.recording.minari import NO_STEPS, check_new_dataset, import_minari, write_minari
from atari.recording.replay.replay import Replay
from atari.recording.stacks import Stacking
from atari.task import Task

Format = Literal["minari", "parquet", "hdf5"]

ENDINGS: dict[str, Format] = {".parquet": "parquet", ".h5": "hdf5", ".hdf5": "hdf5"}
"""The format of a file by its ending."""

Observations = Literal["seen", "screen", "grayscale", "ram"]

VERSION = 1
"""The version of the fact `observations`, and of the columns that it describes."""

_OWN_FACTS = {"columns", "game", "labels", "observations", "options", "sha256"}
_CHECKED: dict[str, Any] = {"fletcher32": True}
_GZIP: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, **_CHECKED}
_HDF5_VERSION = "v110"  # the oldest format with checksums of groups and attributes
_CHUNK = 1 << 16  # bytes that are compressed together, unless a frame has more
_PORTION = 1 << 24  # bytes that the process that writes HDF5 has in memory


def write_dataset(
    replays: Source | Iterable[Source],
    output: str | os.PathLike[str],
    *,
    format: Format | None = None,
    observations: Observations = "screen",
    labels: Sequence[str] | None = None,
    core: str = "native",
    first_episode: int = 0,
    chosen: Callable[[int, int], npt.NDArray[np.uint8]] | None = None,
    facts: Mapping[str, Any] | None = None,
    progress: Callable[[int], object] | None = None,
) -> dict[str, Any]:
    """Write the steps of replays as a data set: observations, RAM, values of labels, actions, rewards, ends.

    A step is a step of the recorded environment, as in `to_minari`. An episode of n steps has n + 1 states, beginning
    with the state before the first step. One episode at a time is in memory: 100 kB a step for screens, 7 kB for
    observations of 84x84. Another process writes HDF5 and Minari, which crash after a failed write; for Minari it has
    the episode in memory, too.

    `observations` decides the frame of a state:

    - "seen": what the agent of the recorded task saw, see `Replay.observations`. Each frame (or RAM vector, if the
      agent sees RAM) is stored once: a state has the newest frame of its stack, and how the stack follows from the
      stack before. `read_dataset` gives the stacks back, equal to the bit. After a lost life a state is that after the
      reset, in which the next action was chosen.
    - "screen": the screen after the last frame of a step, in RGB; "grayscale": the same in ALE's gray values.
    - "ram": no frame.

    The formats:

    - "hdf5": a group `episode_0`, ... for each episode, with the datasets `frames` (n + 1, height, width[, 3]) or
      (n + 1, 128) and `ram` (n + 1, 128), uint8, `actions` (n,) int64 (or (n, 3) float32), `rewards` (n,) float64,
      `terminations` and `truncations` (n,) bool, `chosen` (n,) uint8; with "seen" also `stack` (n + 1,) uint8. The
      group `labels` has a dataset (n + 1,) int32 for each label; the group `visible` has a dataset (n + 1,) bool for
      each label that can be invisible. The attributes of the file have `game`, `options`, `observations` and `labels`
      as JSON. Readers need HDF5 1.10 or newer.
    - "parquet": a row for each state, with the columns `episode`, `step`, `frame` (PNG, or 128 bytes), `ram` (128
      bytes), `stack`, a column `label.NAME` for each label (null where it is not visible), and `action`, `reward`,
      `terminated`, `truncated`, `chosen` of the step from this state (null in the last state of an episode).
    - "minari": a Minari dataset of dict observations `image` and `ram`. Its infos have `labels`, `visible`, `stack` and
      `chosen`.

    `chosen` says how an action was chosen: 0 unknown, 1 greedily, 2 drawn by the policy, 3 drawn in its place, see
    `atari.policy.choice.Choice`. The fact `observations` has a `version`, the `kind`, and the meanings of both columns.

    Args:
        replays: `Replay`s or files, of one game with the same options.
        output: the file, or the ID of the Minari dataset, such as "atari/pong/random-v0". It must not exist.
        format: the format; None decides by the ending of `output`: .parquet, .h5, .hdf5; with "-v0" or the like at the
            end, "minari".
        observations: see above.
        labels: names of labels; None writes all labels of the game.
        core: the core to play the replays on.
        first_episode: the number of the first episode, in Parquet and HDF5.
        chosen: a function of the number of an episode, counted from 0, and of its steps n, which returns `chosen` (n,)
            uint8; None marks all actions as unknown.
        facts: facts of JSON's types. The attributes of an HDF5 file, and the metadata of a Parquet file and of a Minari
            dataset, have them as JSON, beside the replays' own: `task`, `core_seeds` and `package`, see
            `atari.recording.Replay.facts`. `atari collect` writes the task with all fields, as the object of
            `Task.to_json`, the `policy`, and the `seeds` of the episodes.
        progress: called with the number of steps of each episode that was written.

    Returns:
        `output`, the format, the numbers of `episodes` and `steps`, the `score` of each, and the names of the `labels`.

    Raises:
        ValueError: there are no replays, they differ in game or options, or have no steps; `output` exists or has
            another ending; or a data set does not hold what the agent saw (dicts, sound, delayed actions).
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
    check_name("observations", observations, get_args(Observations))
    module = import_format(format)
    loaded = load_replays(replays)
    named = Labels(loaded[0].game, labels)
    if taken := _OWN_FACTS & {*(facts or {})}:
        raise ValueError(f"facts cannot have the name {min(taken)!r}, which the file has for its own; choose another")
    if observations == "seen":
        check_seen(loaded[0].task)
    said = {**facts_of_replays(loaded), **(facts or {}), "observations": _described(observations, loaded[0].task)}
    scores: list[float] = []
    steps: list[int] = []

    def episodes() -> Iterator[EpisodeArrays]:
        for number, episode in enumerate(_episodes(loaded, observations, core)):
            count = len(episode.rewards)
            marks = np.zeros(count, np.uint8) if chosen is None else chosen(number, count)
            own = {"chosen": np.append(marks, np.uint8(0)), **_values(named, episode.observations["ram"])}
            yield replace(episode, infos={**episode.infos, **own})
            scores.append(float(episode.rewards.sum()))
            steps.append(count)
            if progress is not None:
                progress(count)

    if format == "minari":
        image: ObsType = "grayscale" if observations == "grayscale" else "rgb"
        write_minari(episodes(), os.fspath(output), loaded[0], "dict", core=core, image=image, facts=_as_json(said))
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
    import_format(found)
    return found


def import_format(format: Format) -> Any:
    """The library that reads and writes a format, or an error that says how to install it."""
    if format == "minari":
        return import_minari()
    name = {"parquet": "pyarrow.parquet", "hdf5": "h5py"}[format]
    package = name.partition(".")[0]
    return import_extra(name, f"a data set in the format {format} needs {package}: {pip_install(package)}")


Numbered: TypeAlias = Iterable[tuple[int, EpisodeArrays]]


def _episodes(replays: Sequence[Replay], observations: Observations, core: str) -> Iterator[EpisodeArrays]:
    """The episodes; their observations have "ram", and with frames "image"."""
    if observations == "seen":
        return seen_episodes(replays, core)
    if observations == "ram":
        played = replayed_episodes(replays, "ram", core)
        return (replace(episode, observations={"ram": episode.observations}) for episode in played)
    return replayed_episodes(replays, "dict", core, "rgb" if observations == "screen" else "grayscale")


def _described(observations: Observations, task: Task) -> dict[str, Any]:
    """The fact `observations`."""
    described: dict[str, Any] = {"version": VERSION, "kind": observations}
    if observations == "seen":
        stack = {str(one.value): one.name.lower() for one in Stacking}
        described |= {"stack_num": task.stack_num, "padding": task.padding, "stack": stack}
    return {**described, "chosen": {str(one.value): one.name.lower() for one in Choice}}


def _values(labels: Labels, ram: npt.NDArray[np.uint8]) -> dict[str, dict[str, npt.NDArray[Any]]]:
    """The values of labels, and where those that can be invisible are visible."""
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
    for number, episode in episodes:
        group, infos = f"episode_{number}", episode.infos
        if (frames := episode.observations.get("image")) is not None:
            rows = min(len(frames), max(1, _CHUNK // frames[0].nbytes))
            yield from _portions(f"{group}/frames", frames, {"chunks": (rows, *frames.shape[1:]), **_GZIP})
        yield from _portions(f"{group}/ram", episode.observations["ram"], _GZIP)
        if "stack" in infos:
            yield from _portions(f"{group}/stack", infos["stack"], _GZIP)
        for name in ("actions", "rewards", "terminations", "truncations"):
            yield from _portions(f"{group}/{name}", getattr(episode, name), _CHECKED)
        yield from _portions(f"{group}/chosen", infos["chosen"][:-1], _GZIP)
        for kind in ("labels", "visible"):
            yield f"{group}/{kind}", None
            for name, column in infos[kind].items():
                yield from _portions(f"{group}/{kind}/{name}", column, _GZIP)


def _portions(name: str, array: npt.NDArray[Any], options: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    rows = max(1, _PORTION // max(1, array[0].nbytes))
    for first in range(0, len(array), rows):
        yield name, (array.shape, first, array[first : first + rows], options)


def _write_parquet(parquet: Any, file: Path, facts: Mapping[str, str], episodes: Numbered) -> None:
    pyarrow = import_module("pyarrow")
    writer = None
    try:
        for number, episode in episodes:
            table = pyarrow.table(_columns(pyarrow, number, episode))
            if writer is None:
                sealed = json_text.seal({**facts, "columns": columns_of(table.schema)})
                schema = table.schema.with_metadata(sealed)
                writer = parquet.ParquetWriter(file, schema, compression="zstd", write_page_checksum=True)
            writer.write_table(table.cast(writer.schema))
    finally:
        if writer is not None:
            writer.close()


def columns_of(schema: Any) -> str:
    """The names and types of the columns of a Parquet file, as JSON."""
    return json.dumps([[column.name, str(column.type)] for column in schema])


def _columns(pyarrow: Any, number: int, episode: EpisodeArrays) -> dict[str, Any]:
    states, infos = len(episode.rewards) + 1, episode.infos
    last = np.arange(states) == states - 1

    def with_last(column: npt.NDArray[Any]) -> Any:
        if column.ndim == 1:
            return pyarrow.array(np.append(column, column[-1:]), mask=last)
        return pyarrow.array([*column.tolist(), None], pyarrow.list_(pyarrow.float32()))

    columns = {
        "episode": pyarrow.array(np.full(states, number, np.int64)),
        "step": pyarrow.array(np.arange(states, dtype=np.int32)),
    }
    if (frames := episode.observations.get("image")) is not None:
        columns["frame"] = pyarrow.array([frame.tobytes() if frame.ndim == 1 else png(frame) for frame in frames])
    columns["ram"] = pyarrow.array([row.tobytes() for row in episode.observations["ram"]], pyarrow.binary(128))
    if "stack" in infos:
        columns["stack"] = pyarrow.array(infos["stack"])
    for name in ("actions", "rewards"):
        columns[name[:-1]] = with_last(getattr(episode, name))
    columns["terminated"], columns["truncated"] = with_last(episode.terminations), with_last(episode.truncations)
    columns["chosen"] = with_last(infos["chosen"][:-1])
    for name, column in infos["labels"].items():
        visible = infos["visible"].get(name)
        columns[f"label.{name}"] = pyarrow.array(column, mask=None if visible is None else ~visible)
    return columns
