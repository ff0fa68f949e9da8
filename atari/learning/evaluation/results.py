"""`Result`: the scores of an evaluation, with everything that they depend on, as a table and as JSON."""

import json
import math
import platform
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from importlib.metadata import version
from itertools import combinations
from os import PathLike
from pathlib import Path
from statistics import fmean, median, pstdev
from typing import Any

from atari.base import durable, json_text, notebook
from atari.base.text_table import aligned
from atari.base.typed_table import check_table, check_type
from atari.games.catalog import games
from atari.learning.evaluation.played import EvaluatedGame, played_task
from atari.learning.evaluation.protocols import EvaluationProtocol
from atari.learning.evaluation.statistics import Estimate, mean_estimate
from atari.learning.evaluation.variants import variant_name
from atari.task import Task
from atari.task.fields import DEFAULTS, FIELDS, GROUPS, OF_GAME

FORMAT = "atari evaluation 3"
_LARGEST = 64 << 20


@dataclass(frozen=True, repr=False)
class GameResult:
    """The results of one game in a `Result`."""

    game: str
    scores: tuple[float, ...]
    frames: tuple[int, ...]
    truncated: tuple[bool, ...]
    seeds: tuple[int, ...]
    observation: Mapping[str, Any] = field(default_factory=dict)
    task: Mapping[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"GameResult({self.game!r}, {len(self.scores)} games, mean {self.mean:,.1f})"

    @property
    def mean(self) -> float:
        """The mean score."""
        return fmean(self.scores)

    @property
    def median(self) -> float:
        """The median score."""
        return float(median(self.scores))

    @property
    def std(self) -> float:
        """The standard deviation of the scores (of the population)."""
        try:
            return pstdev(self.scores)
        except OverflowError:  # of scores near the greatest float, with Python 3.10
            return math.inf

    @property
    def estimate(self) -> Estimate:
        """The mean score with its interval of 95 %, by a bootstrap over the games."""
        return mean_estimate(self.scores)

    def difference(self, other: "GameResult") -> Estimate:
        """The mean score minus that of other games with equal seeds, with the interval of the differences by seed.

        Raises:
            ValueError: the games have other seeds.
        """
        if self.seeds != other.seeds:
            raise ValueError(f"a difference is of games with equal seeds, and these of {self.game} have others")
        return mean_estimate([own - theirs for own, theirs in zip(self.scores, other.scores, strict=True)])

    @property
    def changes(self) -> dict[str, Any]:
        """Mode, difficulty, interventions and delays of the task, those that differ from the game's own.

        Of a game that is not in the package's catalogue, its mode and difficulty, too.
        """
        return changes_of(self.game, self.task)

    @property
    def truncations(self) -> int:
        """The number of games that the limit of frames has stopped."""
        return sum(self.truncated)


@dataclass(frozen=True, repr=False)
class Result:
    """The result of `evaluate`. It prints as a table.

    `result["pong"]` has the whole games that were played of one game, as tuples in the order of the games:

    - `scores`: the sum of all rewards of each game, not clipped, over all lives; `mean`, `median` and `std` of them;
    - `frames`: the length of each game in emulated frames, no-ops included;
    - `truncated`: whether the protocol's limit of frames has stopped each game; `truncations` is their number;
    - `seeds`: the seed of each game;
    - `game`: the game's id; `observation`: the options of the policy's observations; `task`: the task that was played,
      as the object of `Task.to_json`, empty if it is not known or its game has no file;
    - `estimate`: the mean with its interval of 95 %; `difference(other)`: the same of the differences to other games
      with equal seeds, such as the results of another policy or variant.

    With variants, this is the task as given, and `result.variants("pong")` has all of them by name.

    Attributes:
        policy: the policy's name.
        protocol: the protocol with all its numbers.
        seed: the seed of the evaluation.
        games: the results of the games, in the order of the evaluation; the variants of a game follow it.
        training_frames: emulator frames of the policy's training; None is not known.
        versions: the versions of packages, by name.

    Example:
        >>> from atari.learning import evaluate
        >>> result = evaluate("random", ["pong", "breakout"], "dopamine", episodes=2, seed=0)
        >>> result["pong"].scores, result["pong"].mean, len(result["pong"].seeds)
        ((-20.0, -20.0), -20.0, 2)
        >>> result.save("result.json")
    """

    policy: str
    protocol: EvaluationProtocol
    seed: int
    games: tuple[GameResult, ...]
    training_frames: int | None = None
    versions: Mapping[str, str] = field(default_factory=dict)

    def __getitem__(self, game: str) -> GameResult:
        for one in self.games:
            if one.game == game:
                return one
        raise KeyError(f"there is no result of {game!r}; there are some of {', '.join(one.game for one in self.games)}")

    def variants(self, game: str | None = None) -> dict[str, GameResult]:
        """The results of a game by the name of the variant, such as "mode=1", after the task "as given".

        Args:
            game: the game's id; None is the only game.

        Raises:
            KeyError: there is no result of this game.
            ValueError: `game` is None, and there are several games.

        Example:
            >>> from atari.learning import evaluate
            >>> result = evaluate("noop", "freeway", "dopamine", variants="difficulties", episodes=1, progress=print)
            0 2
            1 2
            2 2
            >>> list(result.variants()), result.variants()["difficulty=1"].mean
            (['as given', 'difficulty=1'], 0.0)
        """
        listed = {one.game for one in self.games}
        if game is None and len(listed) > 1:
            raise ValueError(f"there are results of several games; name one of {', '.join(sorted(listed))}")
        base = self[self.games[0].game if game is None else game]
        return {variant_name(base.task, one.task): one for one in self.games if one.game == base.game}

    def __str__(self) -> str:
        lines = [f"policy {self.policy}, seed {self.seed}", f"protocol {self.protocol}", ""]
        given = [self[game] for game in dict.fromkeys(one.game for one in self.games)]
        if len(given) == len(self.games):
            rows: list[Sequence[object]] = [("game", "games", "mean", "std", "median", "min", "max", "truncated")]
            for one in given:
                numbers = (one.mean, one.std, one.median, min(one.scores), max(one.scores))
                rows.append((one.game, len(one.scores), *(f"{number:,.1f}" for number in numbers), one.truncations))
            lines += aligned(rows, bool)
        else:
            lines += score_tables({one.game: self.variants(one.game) for one in given})
        notes = self.notes
        return "\n".join([*lines, *([""] if notes else []), *notes])

    @property
    def notes(self) -> list[str]:
        """Sentences on everything in which the games differ from the protocol, and on truncated games."""
        given = [self[game] for game in dict.fromkeys(one.game for one in self.games)]
        notes = [f"{one.game} was played with {_in_words(changed)}" for one in given if (changed := self._unlike(one))]
        counts = dict.fromkeys(f"{len(one.scores):,}" for one in self.games)
        if {*counts} != {f"{self.protocol.episodes:,}"}:
            notes.append(f"games of each: {' or '.join(counts)}; {self.protocol.name} has {self.protocol.episodes:,}")
        if truncated := sum(one.truncations for one in self.games):
            every = sum(len(one.scores) for one in self.games)
            notes.append(f"{truncated:,} of {every:,} games did not end within {self.protocol.max_frames:,} frames")
        return notes

    def _unlike(self, one: GameResult) -> dict[str, Any]:
        """The fields in which the task that was played differs from the protocol's in the game as it comes.

        A field that is None has no effect, such as the sizes of images in a task of RAM.
        """
        protocol, own = self.protocol, games.get(one.game)
        if own is None or not one.task:
            return one.changes
        task = Task.of(own) if protocol.task is None else protocol.task
        usual = json.loads(played_task(EvaluatedGame.of_policy(task), protocol, None).to_json())
        shown = [name for name in FIELDS if name in OF_GAME or name not in _NOT_PLAYED]
        return {name: value for name in shown if (value := one.task.get(name)) is not None and value != usual[name]}

    def plot(self, file: str | PathLike[str]) -> None:
        """Draw the mean scores with their intervals, of each game and its variants; the file's ending is the format.

        Raises:
            gymnasium.error.DependencyNotInstalled: Matplotlib is not installed.
            ValueError: Matplotlib does not know the format.
            OSError: the file cannot be written.
        """
        from atari.learning.evaluation.plot import plot_scores  # here, because it imports Matplotlib

        plot_scores(estimates_of({one.game: self.variants(one.game) for one in self.games}), Path(file))

    def __repr__(self) -> str:
        games = [one.game for one in self.games]
        listed = ", ".join(games if len(games) < 4 else [*games[:2], f"{len(games) - 2} more"])
        return f"Result({self.policy!r}, {listed}, protocol {self.protocol.name!r}, seed {self.seed})"

    def _repr_html_(self) -> str:
        return notebook.report(str(self))

    def to_json(self) -> dict[str, Any]:
        """The whole result as the types of JSON."""
        own = {one.name: getattr(self, one.name) for one in fields(self)}
        games = [asdict(one) for one in self.games]
        return {"format": FORMAT, **own, "protocol": self.protocol.to_json(), "games": games}

    def save(self, file: str | PathLike[str]) -> None:
        """Write a JSON file with a checksum; an existing file is replaced, and a symbolic link to one, too.

        Raises:
            OSError: the file cannot be written.
        """
        table = json.loads(json.dumps(self.to_json()))  # the types of JSON, as `load` sees them
        durable.write_file(Path(file), (json.dumps(json_text.seal(table), indent=1) + "\n").encode())

    @classmethod
    def load(cls, file: str | PathLike[str]) -> "Result":
        """Read a file that `save` has written.

        Raises:
            FileNotFoundError: the file does not exist.
            ValueError: the file is no result of an evaluation, of another version, or was changed after `save`.
        """
        path = Path(file)
        what = f"{path} is no result of an evaluation: it"
        content = json_text.read(path, what=what, most_bytes=_LARGEST)
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            raise ValueError(
                f'{path} is no result of an evaluation, or of another release: its "format" must be {FORMAT!r}'
            )
        try:
            return _checked_result(json_text.check_seal(content))
        except (TypeError, ValueError) as error:
            raise ValueError(f"{path} is damaged: {error}") from None


_NOT_PLAYED = (*GROUPS["game"], *GROUPS["reward"])
"""Fields of a task that no protocol decides."""


def changes_of(game: str, task: Mapping[str, Any]) -> dict[str, Any]:
    """The `GameResult.changes` of a task, an object of `Task.to_json`."""
    own = games.get(game)
    usual = {**DEFAULTS, **({"mode": own.default_mode, "difficulty": 0} if own is not None else {})}
    return {name: value for name in OF_GAME if (value := task.get(name)) not in (None, [], usual[name])}


def estimates_of(tables: Mapping[str, Mapping[str, GameResult]]) -> dict[str, dict[str, Estimate]]:
    """By game, the mean scores of variants or agents by name."""
    return {game: {name: one.estimate for name, one in named.items()} for game, named in tables.items()}


def score_rows(title: str, named: Mapping[str, GameResult]) -> list[tuple[object, ...]]:
    """A table of variants or agents with equal seeds: means with intervals, and differences to the first row."""
    rows: list[tuple[object, ...]] = [(title, "games", "mean score", "difference", "median", "max", "truncated")]
    base = next(iter(named.values()))
    for name, one in named.items():
        difference = "" if one is base else f"{one.difference(base):+,.1f}"
        others = (f"{one.median:,.1f}", f"{max(one.scores):,.1f}", one.truncations)
        rows.append((name, len(one.scores), f"{one.estimate:,.1f}", difference, *others))
    return rows


def score_tables(tables: Mapping[str, Mapping[str, GameResult]]) -> list[str]:
    """The lines of a table for each game, of its variants or of agents by name."""
    lines = [line for game, named in tables.items() for line in (*aligned(score_rows(game, named), bool), "")]
    return [*lines, "[the interval of 95 %]; a difference is to the first row, of games with equal seeds"]


_KINDS: dict[str, Any] = {
    "format": str, "policy": str, "protocol": dict, "seed": int, "games": list, "training_frames": int | None,
    "versions": dict,
}  # fmt: skip
_KINDS_OF_GAME = {
    "game": str, "scores": list, "frames": list, "truncated": list, "seeds": list, "observation": dict, "task": dict
}  # fmt: skip


def _checked_result(content: dict[str, Any]) -> Result:
    check_table(content, "it", _KINDS)
    games = tuple(_checked_game(one) for one in content["games"])
    if not games or any(one.task == other.task for one, other in combinations(games, 2) if one.game == other.game):
        raise ValueError("games must have each game, or each of its variants, once, and at least one")
    own = {name: value for name, value in content.items() if name != "format"}
    return Result(**{**own, "protocol": EvaluationProtocol.from_json(content["protocol"]), "games": games})


def _checked_game(content: Any) -> GameResult:
    content = check_table(content, "a game", _KINDS_OF_GAME)
    kinds = {"scores": float, "frames": int, "truncated": bool, "seeds": int}
    lists = {
        name: tuple(check_type(one, f"each of {name}", kind) for one in content[name]) for name, kind in kinds.items()
    }
    if len({*map(len, lists.values()), 0}) != 2:
        raise ValueError(f"{content['game']} must have as many scores, frames, truncated and seeds, and at least one")
    return GameResult(**{**content, **lists, "scores": tuple(map(float, lists["scores"]))})


def _in_words(changes: Mapping[str, Any]) -> str:
    named = {**changes}
    if isinstance(each := named.get("interventions"), list):  # a file may have anything else
        named["interventions"] = [one.get("name") if isinstance(one, dict) else one for one in each]
    return ", ".join(f"{name}={value!r}" for name, value in named.items())


def versions() -> dict[str, str]:
    """The versions of this package and Python, and of the imported packages that a policy may use."""
    own = {"atari-envs": version("atari-envs"), "python": platform.python_version()}
    others = ("gymnasium", "numpy", "torch", "stable_baselines3", "onnxruntime")
    return {**own, **{name: str(sys.modules[name].__version__) for name in others if name in sys.modules}}
