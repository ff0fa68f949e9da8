"""The runs of a sweep: games, seeds, options, and a folder that has no others."""

import dataclasses
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from atari.base import durable
from atari.base.validation import check_file
from atari.cores.options import SEED_LIMIT
from atari.learning.agent import AgentCode, read_options
from atari.learning.evaluation.played import EvaluatedGame, played_task
from atari.learning.evaluation.protocols import GAME_SETS, EvaluationProtocol
from atari.learning.options import TrainingOptions
from atari.learning.programs import Program, is_program, program, sha256
from atari.learning.run_folder import RunFolder

MOST_SEEDS = 1000

Resolve = Callable[[str, int], TrainingOptions]
"""A function of a game, as a user names it, and a seed, which returns the options of the training."""


@dataclass(frozen=True)
class TrainingRun:
    """A training of a sweep.

    Attributes:
        path: its run folder.
        game: the game as the user names it.
        options: its options; `options.task.game` is the game's id.
    """

    path: Path
    game: str
    options: TrainingOptions

    @property
    def name(self) -> str:
        """The name of the run folder."""
        return self.path.name


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


def plan(games: Sequence[str], seeds: Sequence[int], folder: Path, resolve: Resolve) -> list[TrainingRun]:
    """The runs of a sweep, game by game.

    Raises:
        ValueError: a game is named twice.
    """
    runs: list[TrainingRun] = []
    named: dict[str, str] = {}
    for game in games:
        for seed in seeds:
            options = resolve(game, seed)
            run = TrainingRun(folder / f"{options.task.game}-seed{seed}", game, options)
            if named.setdefault(options.task.game, game) != game or run.path in [other.path for other in runs]:
                other = named[options.task.game]
                raise ValueError(
                    f"{options.task.game} is named twice, as {other!r} and {game!r}; leave one of them out"
                )
            runs.append(run)
    return runs


def check_protocol(runs: Sequence[TrainingRun], protocol: EvaluationProtocol) -> None:
    """Check that the policies of the runs can be evaluated by a protocol.

    Raises:
        ValueError: a task and the protocol differ; the message names the field.
    """
    for run in runs:
        task = run.options.task
        played_task(EvaluatedGame.of_policy(task), protocol, SimpleNamespace(task=task))


def check_folder(folder: Path, code: AgentCode, runs: Sequence[TrainingRun], resolve: Resolve) -> None:
    """Check that all run folders in a folder are of this sweep, or of one with more games or seeds.

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
        expected = run.options if run else resolve(theirs.task.game, theirs.seed)
        if differing := [*_differences(theirs, expected)]:
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


def _differences(theirs: TrainingOptions, ours: TrainingOptions) -> Iterator[str]:
    for field in dataclasses.fields(ours):
        one, other = getattr(theirs, field.name), getattr(ours, field.name)
        if one == other:
            continue
        if callable(one) and callable(other):  # a program of the user's own
            yield f"another program as {field.name} than this sweep"
            continue
        pairs: dict[str, tuple[Any, Any]] = {field.name: (one, other)}
        if field.name == "task":
            pairs = theirs.task.differences(ours.task)
        yield from (f"{name}={first!r}, and this sweep {second!r}" for name, (first, second) in pairs.items())
