"""The runs of a sweep: games, a grid of options, seeds, and a folder that has no others."""

import dataclasses
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from atari.base import durable
from atari.base.frozen import FrozenDict
from atari.base.typed_table import in_text
from atari.base.validation import check_file
from atari.cores.options import SEED_LIMIT
from atari.learning.agent import AgentCode, read_options
from atari.learning.evaluation.played import EvaluatedGame, played_task
from atari.learning.evaluation.protocols import GAME_SETS, EvaluationProtocol
from atari.learning.options import TrainingOptions
from atari.learning.programs import Program, is_program, program, sha256
from atari.learning.run_folder import RunFolder

MOST_SEEDS = 1000

Chosen = Mapping[str, Any]
"""One value of each option of a grid, by the name of the option."""

Resolve = Callable[[str, int, Chosen], TrainingOptions]
"""A function of a game, as a user names it, a seed and values of a grid, which returns the options of the training."""


@dataclass(frozen=True)
class TrainingRun:
    """A training of a sweep.

    Attributes:
        path: its run folder.
        game: the game as the user names it.
        options: its options; `options.task.game` is the game's id.
        chosen: the values of the grid, as the user gave them.
    """

    path: Path
    game: str
    options: TrainingOptions
    chosen: Chosen = dataclasses.field(default_factory=dict)

    @property
    def name(self) -> str:
        """The name of the run folder."""
        return self.path.name

    @property
    def values(self) -> dict[str, str]:
        """The values of the grid by option, in words: 1e-4 and 0.0001 are one value, "0.0001"."""
        return _values(self.options, self.chosen)

    @property
    def combination(self) -> str:
        """The values of the grid in words, such as "learning_rate=0.0001 gamma=0.99"; "" without a grid."""
        return " ".join(f"{name}={text}" for name, text in self.values.items())


def find_games(text: str) -> list[str]:
    """The games of the words "pong,breakout", in which a name of `GAME_SETS` stands for its games.

    Raises:
        ValueError: a word is empty.
    """
    words = [word.strip() for word in text.split(",")]
    if not all(words):
        raise ValueError(f"games are named with commas between, as in pong,breakout or atari26, got {text!r}")
    return [game for word in words for game in GAME_SETS.get(word, (word,))]


def find_seeds(text: str) -> list[int]:
    """The seeds of a text such as "0-2,7".

    Raises:
        ValueError: the text has another form, a seed is named twice or is too large, or there are too many.
    """
    seeds: list[int] = []
    for part in text.split(","):
        found = re.fullmatch(r"(\d{1,10})(?:-(\d{1,10}))?", part.strip())
        low, high = (int(found[1]), int(found[2] or found[1])) if found else (1, 0)
        if not low <= high < SEED_LIMIT:
            raise ValueError(f"seeds are numbers and ranges below 2**32 with commas between, as in 0-2,7, got {text!r}")
        if len(seeds) + high - low >= MOST_SEEDS:
            raise ValueError(f"a sweep has at most {MOST_SEEDS:,} seeds, and {text!r} has more")
        seeds += range(low, high + 1)
    if twice := sorted({seed for seed in seeds if seeds.count(seed) > 1}):
        raise ValueError(f"seed {twice[0]} is named twice in {text!r}; leave one of them out")
    return seeds


def find_grid(texts: Sequence[str]) -> dict[str, list[str]]:
    """The grid of texts such as "learning_rate=1e-4,3e-4": the values of each option by its name.

    Raises:
        ValueError: a text has another form, or an option or a value is named twice.
    """
    grid: dict[str, list[str]] = {}
    for text in texts:
        name, equals, values = text.partition("=")
        name, listed = name.strip().replace("-", "_"), [value.strip() for value in values.split(",")]
        if not (name.isidentifier() and equals and all(listed)):
            raise ValueError(f"a grid is an option and its values, as in learning_rate=1e-4,3e-4, got {text!r}")
        if name == "seed":
            raise ValueError("the seeds of a sweep are --seeds, such as --seeds 0-2; leave seed out of the grid")
        if name in grid or len({*listed}) < len(listed):
            raise ValueError(f"the grid names {name}, or one of its values, twice in {text!r}; leave one of them out")
        grid[name] = listed
    return grid


def plan(
    games: Sequence[str],
    seeds: Sequence[int],
    folder: Path,
    resolve: Resolve,
    grid: Mapping[str, Sequence[Any]] = FrozenDict(),
) -> list[TrainingRun]:
    """The runs of a sweep, game by game: all combinations of the grid's values, each with all seeds.

    Args:
        games: the games, as a user names them.
        seeds: the seeds.
        folder: the folder of the run folders, whose names have game, values and seed.
        resolve: makes the options of a run.
        grid: values of options by name, such as {"gamma": [0.99, 0.997]}; without it, each game has one combination.

    Raises:
        ValueError: a game or a value is named twice.
    """
    runs: list[TrainingRun] = []
    named: dict[str, str] = {}
    combinations = [dict(zip(grid, values, strict=True)) for values in product(*grid.values())]
    for game in games:
        own = [_run(game, seed, chosen, folder, resolve) for chosen in combinations for seed in seeds]
        id_ = own[0].options.task.game
        if id_ in named:
            raise ValueError(f"{id_} is named twice, as {named[id_]!r} and {game!r}; leave one of them out")
        named[id_] = game
        if twice := [run for run in own if [one.path for one in own].count(run.path) > 1]:
            raise ValueError(
                f"the sweep has {twice[0].name} twice; leave one of the seeds, or of the grid's values, out"
            )
        runs += own
    return runs


def _run(game: str, seed: int, chosen: Chosen, folder: Path, resolve: Resolve) -> TrainingRun:
    options = resolve(game, seed, chosen)
    parts = (options.task.game, *map("=".join, _values(options, chosen).items()), f"seed{seed}")
    return TrainingRun(folder / "-".join(map(_in_name, parts)), game, options, chosen)


def _values(options: TrainingOptions, chosen: Chosen) -> dict[str, str]:
    """The values of a grid as the options have them; in the user's words, if they are no numbers or words there."""
    found = {name: getattr(options, name, getattr(options.task, name, value)) for name, value in chosen.items()}
    return {name: in_text(value if _is_plain(value) else chosen[name]) for name, value in found.items()}


def _is_plain(value: Any) -> bool:
    return value is None or isinstance(value, (bool, int, float, str))


def _in_name(part: str) -> str:
    """A part of the name of a folder: other signs than in numbers and names become "_"."""
    return re.sub(r"[^\w.,=+-]", "_", part)


def check_protocol(runs: Sequence[TrainingRun], protocol: EvaluationProtocol) -> None:
    """Check that the policies of the runs can be evaluated by a protocol.

    Raises:
        ValueError: a task and the protocol differ; the message names the field.
    """
    for run in runs:
        task = run.options.task
        played_task(EvaluatedGame.of_policy(task), protocol, SimpleNamespace(task=task))


def check_folder(folder: Path, code: AgentCode, runs: Sequence[TrainingRun], resolve: Resolve) -> None:
    """Check that all run folders in a folder are of this sweep, or of one with more games, seeds or values of the grid.

    Raises:
        FileNotFoundError, ValueError: a run folder is damaged, or has other options; the message names them.
    """
    planned = {run.path: run for run in runs}
    for config in sorted(folder.glob("*/config.json")):
        found = RunFolder.open(config.parent)
        if (agent := found.config["agent"]) != code.name:
            raise ValueError(f"{found.path} is a run of {agent}, and this sweep is of {code.name}; give another folder")
        kept = {kind: entry["sha256"] for kind, entry in found.config.get("programs", {}).items()}
        if kept.get("agent") != (code.program and sha256(code.program.file.read_bytes())):
            whose = code.program.file if code.program else f"the agent {agent} of this package"
            copy = found.path.parent / f"{code.name}.py"
            raise ValueError(
                f"{found.path} is a run of another program than {whose}; give another folder"
                + (f", or go on with the sweep's copy: `atari train {copy} ...`" if copy.is_file() else "")
            )
        theirs = read_options(found)
        run = planned.get(found.path)
        expected = run.options if run else resolve(theirs.task.game, theirs.seed, {})
        of_grid = () if run else {name for one in runs for name in one.chosen}  # a run with another value of the grid
        if differing := [text for name, text in _differences(theirs, expected) if name not in of_grid]:
            raise ValueError(f"{found.path} has {', '.join(differing)}; give another folder, or equal options")


def keep_programs(folder: Path, words: Sequence[str]) -> list[str]:
    """Copy the Python files that words of a command line name into a folder, and name the copies in their place.

    So an edit of a file during a sweep changes no run.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: two files have one name.
    """
    copied: dict[str, Path] = {}
    kept = []
    for word in words:
        flag, equals, value = word.partition("=") if word.startswith("--") else ("", "", word)
        if is_program(value):
            named = program(value)
            if copied.setdefault(named.file.name, named.file.absolute()) != named.file.absolute():
                other = copied[named.file.name]
                raise ValueError(f"{named.file} and {other} have one name, and a sweep keeps both; rename one of them")
            durable.write_file(folder / named.file.name, check_file(named.file).read_bytes())
            value = str(Program(folder / named.file.name, named.name))
        kept.append(f"{flag}{equals}{value}")
    return kept


def _differences(theirs: TrainingOptions, ours: TrainingOptions) -> Iterator[tuple[str, str]]:
    """The names of the options that differ, and both values in words."""
    for field in dataclasses.fields(ours):
        one, other = getattr(theirs, field.name), getattr(ours, field.name)
        if one == other:
            continue
        if callable(one) and callable(other):  # a program of the user's own
            yield field.name, f"another program as {field.name} than this sweep"
            continue
        pairs: dict[str, tuple[Any, Any]] = {field.name: (one, other)}
        if field.name == "task":
            pairs = theirs.task.differences(ours.task)
        for name, (first, second) in pairs.items():
            yield name, f"{name}={first!r}, and this sweep {second!r}"
