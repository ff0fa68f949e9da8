"""`Result`: the scores of an evaluation, with everything that they depend on, as a table and as JSON."""

import json
import math
import platform
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from importlib.metadata import version
from os import PathLike
from pathlib import Path
from statistics import fmean, median, pstdev
from typing import Any

from atari.learning.evaluation.protocols import EvaluationProtocol
from atari.validation import check_file

FORMAT = "atari evaluation 2"
_OLD_FORMATS = ("atari evaluation 1",)
"""Older formats that are read, too. In format 1, games and protocols have no task."""
_LARGEST = 256 * 2**20


@dataclass(frozen=True)
class GameResult:
    """The results of one game in a `Result`."""

    game: str
    scores: tuple[float, ...]
    frames: tuple[int, ...]
    truncated: tuple[bool, ...]
    seeds: tuple[int, ...]
    observation: Mapping[str, Any] = field(default_factory=dict)
    task: Mapping[str, Any] = field(default_factory=dict)

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
        return pstdev(self.scores)

    @property
    def truncations(self) -> int:
        """The number of games that the limit of frames has stopped."""
        return sum(self.truncated)


@dataclass(frozen=True)
class Result:
    """The result of `evaluate`. It prints as a table.

    `result["pong"]` has the whole games that were played of one game, as tuples in the order of the games:

    - `scores`: the sum of all rewards of each game, not clipped, over all lives; `mean`, `median` and `std` of them;
    - `frames`: the length of each game in emulated frames, no-ops included;
    - `truncated`: whether the protocol's limit of frames has stopped each game; `truncations` is their number;
    - `seeds`: the seed of each game;
    - `game`: the game's id; `observation`: the options of the policy's observations; `task`: the task that was played,
      as the object of `Task.to_json`, empty if it is not known or its game has no file.

    Attributes:
        policy: the policy's name.
        protocol: the protocol with all its numbers.
        seed: the seed of the evaluation.
        games: the results of the games, in the order of the evaluation.
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

    def __str__(self) -> str:
        rows: list[Sequence[object]] = [("game", "games", "mean", "std", "median", "min", "max", "truncated")]
        for one in self.games:
            numbers = (one.mean, one.std, one.median, min(one.scores), max(one.scores))
            rows.append((one.game, len(one.scores), *(f"{number:,.1f}" for number in numbers), one.truncations))
        lines = [f"policy {self.policy}, seed {self.seed}", f"protocol {self.protocol}", "", *aligned(rows)]
        if truncated := sum(one.truncations for one in self.games):
            every = sum(len(one.scores) for one in self.games)
            lines += ["", f"{truncated:,} of {every:,} games did not end within {self.protocol.max_frames:,} frames"]
        return "\n".join(lines)

    def to_json(self) -> dict[str, Any]:
        """The whole result as the types of JSON."""
        own = {one.name: getattr(self, one.name) for one in fields(self)}
        games = [asdict(one) for one in self.games]
        return {"format": FORMAT, **own, "protocol": self.protocol.to_json(), "games": games}

    def save(self, file: str | PathLike[str]) -> None:
        """Write a JSON file; an existing one is replaced.

        Raises:
            OSError: the file cannot be written.
        """
        Path(file).write_text(json.dumps(self.to_json(), indent=1) + "\n", encoding="utf-8")

    @classmethod
    def load(cls, file: str | PathLike[str]) -> "Result":
        """Read a file that `save` has written.

        Raises:
            FileNotFoundError: the file does not exist.
            ValueError: the file is no result of an evaluation, of another version, or damaged.
        """
        path = check_file(Path(file))
        if path.stat().st_size > _LARGEST:
            raise ValueError(f"{path} is no result of an evaluation: it is too large")
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
        except (ValueError, RecursionError) as error:
            raise ValueError(f"{path} is no result of an evaluation: {error}") from None
        if not isinstance(content, dict) or content.get("format") not in (FORMAT, *_OLD_FORMATS):
            raise ValueError(
                f'{path} is no result of an evaluation, or of a newer release: its "format" must be {FORMAT!r} or '
                f"{' or '.join(map(repr, _OLD_FORMATS))}"
            )
        try:
            return _checked_result(content)
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            what = f"{error} is missing" if isinstance(error, KeyError) else str(error)
            raise ValueError(f"{path} is damaged: {what}") from None


def _checked_result(content: dict[str, Any]) -> Result:
    """The result of a file's content.

    Raises:
        KeyError, TypeError, ValueError: a field is missing, or of the wrong kind.
    """
    frames = content["training_frames"]
    games = tuple(_checked_game(one) for one in _of_type(content["games"], list, "games"))
    if not games or len({one.game for one in games}) < len(games):
        raise ValueError("games must have each game once, and at least one")
    return Result(
        policy=_of_type(content["policy"], str, "policy"),
        protocol=EvaluationProtocol.from_json(_of_type(content["protocol"], dict, "protocol")),
        seed=_of_type(content["seed"], int, "seed"),
        games=games,
        training_frames=None if frames is None else _of_type(frames, int, "training_frames"),
        versions=_of_type(content["versions"], dict, "versions"),
    )


def _checked_game(content: Any) -> GameResult:
    content = _of_type(content, dict, "a game")
    game = GameResult(
        game=_of_type(content["game"], str, "game"),
        scores=tuple(float(_of_type(score, (int, float), "a score")) for score in content["scores"]),
        frames=tuple(_of_type(number, int, "frames") for number in content["frames"]),
        truncated=tuple(_of_type(one, bool, "truncated") for one in content["truncated"]),
        seeds=tuple(_of_type(seed, int, "a seed") for seed in content["seeds"]),
        observation=_of_type(content["observation"], dict, "observation"),
        task=_of_type(content.get("task", {}), dict, "task"),
    )
    if not game.scores or not len(game.scores) == len(game.frames) == len(game.truncated) == len(game.seeds):
        raise ValueError(f"{game.game} must have as many scores, frames, truncated and seeds, and at least one")
    if not all(map(math.isfinite, game.scores)):
        raise ValueError(f"{game.game} has a score that is no number")
    return game


def _of_type(value: Any, kind: Any, name: str) -> Any:
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise TypeError(f"{name} is {type(value).__name__} {value!r:.60}")
    return value


def versions() -> dict[str, str]:
    """The versions of this package and Python, and of the imported packages that a policy may use."""
    own = {"atari-envs": version("atari-envs"), "python": platform.python_version()}
    others = ("gymnasium", "numpy", "torch", "stable_baselines3", "onnxruntime")
    return {**own, **{name: str(sys.modules[name].__version__) for name in others if name in sys.modules}}


def aligned(rows: Iterable[Sequence[object]]) -> list[str]:
    """Rows as lines of aligned columns: the first to the left, the others to the right."""
    cells = [[str(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return [
        "  ".join(
            cell.rjust(width) if column else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in cells
    ]
