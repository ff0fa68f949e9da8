"""`collect`: data sets of many games, played by workers of a cluster; a stopped run can continue."""

import json
import os
import shutil
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, get_args

import ray

from atari.base import durable, json_text
from atari.base.typed_table import check_table, check_type
from atari.base.validation import check_integer, check_name
from atari.cores.options import SEED_LIMIT
from atari.lab.dataset import Format, Observations, check_output, output_format, write_dataset
from atari.lab.labels import Labels
from atari.learning import load_policy
from atari.learning.evaluation.evaluate import EvaluatedPolicy
from atari.learning.evaluation.played import EvaluatedGame, played_task, resolve_games, usual_protocol
from atari.recording.episodes import check_seen
from atari.task import Task
from atari.task.task import GameLike

_MANIFEST = "_manifest.jsonl"
_LINE = {"seed": int, "file": str, "bytes": int, "score": float}
_OF_FORMATS = {"steps": int, "frames": int}
"""The kinds of a line of the manifest."""


@dataclass(frozen=True)
class _Work:
    """A game that a worker plays, and the format of its output."""

    seed: int
    task: Task
    epsilon: float
    policy: Any
    facts: dict[str, Any]
    format: Format
    observations: Observations
    labels: tuple[str, ...]
    version: str


_Part = tuple[bytes, dict[str, Any]]
"""The file of a game, and its facts for the manifest, "seed" among them."""


def collect(
    game: GameLike | EvaluatedGame,
    output: str | os.PathLike[str],
    *,
    policy: Any = "random",
    seeds: Iterable[int] = range(1),
    format: Format | None = None,
    observations: Observations | None = None,
    labels: Sequence[str] | None = None,
    progress: Callable[[int], object] | None = None,
) -> dict[str, Any]:
    """Have workers of Ray play a game for each seed, and write a data set with the columns of `write_dataset`.

    The workers belong to the cluster to which this process is connected. Otherwise `ray.init()` connects it, or starts
    Ray on this machine. Games come to this process through the object store, so workers need no common file system. At
    most two games for each CPU of the cluster are in progress.

    - "parquet": `output` is a folder with a file for each seed, `seed-0000000003.parquet`. The number of an episode is
      its seed. `pyarrow.parquet.read_table(output)` and `ray.data.read_parquet(output)` read the folder. The workers
      play, render and compress.
    - "hdf5", "minari": the workers play, and return replays, which are kept in the folder `OUTPUT.parts` ("/" becomes
      "-"). When all are there, this process renders and writes the output, because these formats have one writer, and
      deletes the folder. `write_dataset` would write the same output from the replays in the order of the seeds.

    The folder has a manifest of the finished seeds. The same call continues a killed one, and more seeds add to a
    Parquet folder; finished seeds are not played again. The rows are the same to the bit for any
    number of workers, provided that the policy's actions depend only on its observations and seeds.

    Args:
        game: a game, an ID or a `Task`. A policy without a task plays an ID or a `Task` unchanged. The manifest and
            the files have the task.
        output: the folder (.parquet), the file (.h5, .hdf5) or the ID of the Minari dataset. The file and the ID must
            not exist.
        policy: a policy, see `load_policy`; the workers load it. The manifest and the files have its name.
        seeds: the seeds of the games, 0..2**32 - 1; a repeated seed counts once.
        format, labels: see `write_dataset`.
        observations: see `write_dataset`; None is "seen" for a policy with `task` or `environment`, else "screen".
        progress: a function to call with the number of finished games, at the start and after each game.

    Returns:
        The result of `write_dataset`, with `played`, the number of games that this call played, and `task`, an object.

    Raises:
        TypeError, ValueError: see `write_dataset` and `evaluate`; or the folder has data of another task or policy, or
            of other options.
        KeyError: the game has no such label.
        RuntimeError: a worker has another version of this package.
        gymnasium.error.DependencyNotInstalled: the package of the format is not installed.

    Example:
        >>> collect("pong", "pong.parquet", seeds=range(1000), observations="seen")  # doctest: +SKIP
    """
    (chosen,) = resolve_games(game)
    if observations is not None:
        check_name("observations", observations, get_args(Observations))
    wanted = sorted({check_integer("a seed", seed, 0, SEED_LIMIT - 1) for seed in seeds})
    if not wanted:
        raise ValueError("a data set needs at least one seed")
    format = output_format(output, format)
    if format != "parquet":
        check_output(output, format)
    loaded = load_policy(policy)  # raises its errors before anything is written
    name = str(policy) if isinstance(policy, (str, Path)) else loaded.name
    protocol = usual_protocol(loaded, chosen)
    played = played_task(chosen, protocol, loaded)
    player = EvaluatedPolicy(loaded, played, protocol.epsilon)  # raises its errors, too
    observations = observations or player.stored_observations
    if observations == "seen":
        check_seen(played)
    names = Labels(played.definition, labels).names
    task = json.loads(played.to_json())
    facts = {
        "game": played.game, "task": task, "policy": name, "format": format, "observations": observations,
        "labels": list(names),
    }  # fmt: skip
    folder = Path(output) if format == "parquet" else Path(os.fspath(output).replace("/", "-") + ".parts")
    manifest = _Manifest(folder, {**facts, "version": version("atari-envs")})
    missing = [seed for seed in wanted if seed not in manifest.finished]
    if progress is not None:
        progress(len(wanted) - len(missing))
    stored = {"task": task, "policy": name}
    given = (played, protocol.epsilon, policy, stored, format, observations, names, version("atari-envs"))
    for data, facts in _played([_Work(seed, *given) for seed in missing]):
        manifest.add(data, facts)
        if progress is not None:
            progress(1)
    lines = [manifest.finished[seed] for seed in wanted]
    if format == "parquet":
        sums = {"episodes": len(lines), "steps": sum(line["steps"] for line in lines)}
        scores = [line["score"] for line in lines]
        return {
            "output": os.fspath(output), "format": format, **sums, "scores": scores, "labels": list(names),
            "played": len(missing), "task": task,
        }  # fmt: skip
    replays = [folder / line["file"] for line in lines]
    stored = {**stored, "seeds": wanted}
    options: dict[str, Any] = {"format": format, "observations": observations, "labels": labels}
    options["chosen"] = lambda episode, steps: player.choices(wanted[episode], steps)
    result = write_dataset(replays, output, facts=stored, **options)
    shutil.rmtree(folder)
    return {**result, "played": len(missing), "task": task}


def _played(work: Sequence[_Work]) -> Iterator[_Part]:
    """Yield the workers' parts, in any order. An error cancels the games in progress."""
    if not ray.is_initialized():
        ray.init()
    cluster: Any = ray  # Ray's functions have no types
    limit = max(2, 2 * int(cluster.cluster_resources().get("CPU", 1)))
    play = ray.remote(_play).options(num_cpus=1)
    waiting = iter(work)
    pending: list[Any] = [play.remote(one) for one, _ in zip(waiting, range(limit), strict=False)]
    try:
        while pending:
            (done,), pending = ray.wait(pending, num_returns=1)
            yield ray.get(done)
            pending.extend(play.remote(one) for one, _ in zip(waiting, range(1), strict=False))
    finally:
        for result in pending:
            ray.cancel(result)


def _play(work: _Work) -> _Part:
    if (own := version("atari-envs")) != work.version:
        raise RuntimeError(f"a worker has atari-envs {own}, and the collection was begun with {work.version}")
    with TemporaryDirectory() as folder:
        replay = Path(folder, "game.a26r")
        player = EvaluatedPolicy(load_policy(work.policy), work.task, work.epsilon)
        ((score, length),) = player.record([work.seed], replay)
        if work.format != "parquet":
            return replay.read_bytes(), {"seed": work.seed, "score": score, "frames": length}
        rows = Path(folder, "rows.parquet")
        options: dict[str, Any] = {"observations": work.observations, "labels": work.labels}
        options |= {"first_episode": work.seed, "chosen": lambda _, steps: player.choices(work.seed, steps)}
        result = write_dataset(replay, rows, facts={**work.facts, "seeds": [work.seed]}, **options)
        return rows.read_bytes(), {"seed": work.seed, "score": score, "steps": result["steps"]}


class _Manifest:
    """The finished seeds of a folder: lines of JSON, first the facts of the data set, then one for each seed.

    A file gets its name before its line is written. A line that a killed process has not finished is dropped.

    Raises:
        ValueError: the folder has other files, or data of another game or other options.
    """

    def __init__(self, folder: Path, facts: dict[str, Any]) -> None:
        self._folder, self._path = folder, folder / _MANIFEST
        self.finished: dict[int, dict[str, Any]] = {}
        """The line of each seed that has a file."""
        if folder.is_file() or (folder.is_dir() and not self._path.exists() and any(folder.iterdir())):
            raise ValueError(f"{folder} is there already, without a manifest; delete it, or choose another name")
        folder.mkdir(parents=True, exist_ok=True)
        data = self._path.read_bytes() if self._path.exists() else b""
        whole = data[: data.rfind(b"\n") + 1]
        if not whole:
            durable.write_file(self._path, (json.dumps(facts) + "\n").encode())
            return
        if whole != data:
            durable.write_file(self._path, whole)
        first, *lines = map(self._parse, whole.splitlines())
        if first != facts:
            other = ", ".join(f"{name} {first.get(name)!r}" for name in facts if first.get(name) != facts[name])
            raise ValueError(f"{folder} has data of {other or 'another kind'}; choose another name")
        for line in lines:
            file = folder / check_table(line, f"{self._path}: a line", _LINE, _OF_FORMATS)["file"]
            if file.is_file() and file.stat().st_size == line["bytes"]:
                self.finished[line["seed"]] = line

    def add(self, data: bytes, facts: dict[str, Any]) -> None:
        seed = facts["seed"]
        file = f"seed-{seed:010}" + (".parquet" if "steps" in facts else ".a26r")
        new = self._folder / f"_{file}"  # readers of a folder skip names that begin with _
        durable.write_file(new, data)
        durable.replace(new, self._folder / file)
        line = {"seed": seed, "file": file, "bytes": len(data), **facts}
        durable.append(self._path, (json.dumps(line) + "\n").encode())
        self.finished[seed] = line

    def _parse(self, line: bytes) -> dict[str, Any]:
        try:
            return dict(check_type(json_text.parse(line, "JSON"), "a line", dict))
        except ValueError as error:
            text = f"{self._path} is damaged at {line[:40]!r}; delete the line, or the folder"
            raise ValueError(f"{text} ({error})") from None
