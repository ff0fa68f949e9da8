"""`published`: learning curves and scores that other projects have published, and tables of human scores.

Where they are from, under which licences, is in `Published.source`, in docs/evaluation.md, and in `data/LICENSES.md`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.learning.evaluation.tables import check_known_name, read_table
from atari.validation import check_integer

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Curve:
    """A learning curve of one game.

    Attributes:
        frames: (n,) int64, emulator frames of the training at the right end of each interval.
        mean: (n,) float64, mean score over seeds of the games that ended in the interval; NaN where none did.
        std: (n,) float64, standard deviation over seeds (of the population); NaN where it is not known.

    Example:
        >>> from atari.learning import published
        >>> curve = published("dopamine/rainbow").curve("pong")
        >>> int(curve.frames[-1]), round(float(curve.mean[-1]), 1)
        (199000000, 20.2)
    """

    frames: npt.NDArray[np.int64]
    mean: Floats
    std: Floats


@dataclass(frozen=True)
class Published:
    """The published results of one agent. Scores are of whole games and not clipped.

    Attributes:
        name: such as "dopamine/rainbow".
        title: the agent's, in the words of its source.
        protocol: facts of its environments: `repeat_action_probability`, `noop_max`, `full_action_space`,
            `frame_skip`, `max_frames` (None is not stated), and `phase`, when its scores were taken.
        source: where it is from: `repo`, `commit`, `paths`, `licence`, `copyright`, `notes`, and `score`, what its
            scores are.
        games: the games with scores.
        final_frames: emulator frames of the whole training; None is not stated.

    Example:
        >>> from atari.learning import published
        >>> rainbow = published("dopamine/rainbow")
        >>> rainbow.title, len(rainbow.games), rainbow.has_curves
        ('Rainbow', 60, True)
    """

    name: str
    title: str
    protocol: Mapping[str, Any]
    source: Mapping[str, Any]
    games: tuple[str, ...]
    final_frames: int | None

    @property
    def _entry(self) -> dict[str, Any]:
        return _entry(self.name)

    def _game(self, game: str) -> dict[str, Any]:
        found: dict[str, Any] = self._entry["games"][
            check_known_name(f"score of {self.name} in game", game, self.games)
        ]
        return found

    @property
    def has_curves(self) -> bool:
        """Whether there are learning curves, not only final scores."""
        return "frames" in self._entry

    @property
    def budgets(self) -> tuple[int, ...]:
        """The emulator frames of training at which there are scores, in ascending order; () if they are not stated."""
        last = [] if self.final_frames is None else [self.final_frames]
        return tuple(sorted({*self._entry.get("marks", []), *self._entry.get("frames", []), *last}))

    def interval(self, frames: int) -> tuple[int, int]:
        """The first and the last frame of training whose games the score at `frames` is a mean of.

        Both are `frames` where the source has a score at that number.

        Raises:
            TypeError, ValueError: `frames` is no integer, or there is no score at that number.
        """
        frames = check_integer("frames", frames, 1, 10**15)
        points = self._entry.get("frames", [])
        if frames in self.budgets:
            return frames, frames
        if not points or frames > points[-1]:
            until = "until" if points else "only at"
            limit = "an unknown number of" if self.final_frames is None else f"{self.final_frames:,}"
            raise ValueError(f"{self.name} has scores {until} {limit} frames, not at {frames:,}")
        if frames < points[0]:
            first = ", ".join(f"{budget:,}" for budget in self.budgets if budget <= points[0])
            raise ValueError(
                f"the first scores of {self.name} are at {first} frames, not at {frames:,}: its curve begins with the "
                f"mean of all games until {points[0]:,} frames"
            )
        last = int(np.searchsorted(points, frames))
        return points[last - 1] + 1, points[last]

    def curve(self, game: str) -> Curve:
        """The learning curve of a game.

        Raises:
            ValueError: there is no such game, or the source has final scores only.
        """
        data = self._game(game)
        if not self.has_curves:
            raise ValueError(f"{self.name} has final scores only; use final({game!r})")
        frames = np.array(self._entry["frames"], np.int64)
        missing = np.full(len(frames), np.nan)
        return Curve(frames, _floats(data["mean"]), _floats(data["std"]) if "std" in data else missing)

    def final(self, game: str) -> Floats:
        """The scores at the end of the training: (seeds,) float64, or (1,), the mean, where seeds are not given.

        Raises:
            ValueError: there is no such game.
        """
        data = self._game(game)
        values = _floats(data.get("final") or [data["score"]])
        return values[~np.isnan(values)]

    def at(self, game: str, frames: int) -> Floats:
        """The scores after `frames` emulator frames of training: (seeds,) float64, or (1,), the mean over seeds.

        Scores of single seeds are kept at some frames only: 1, 2.5, 5, 10, 20, 50, 100 million and the end. Elsewhere
        this is the mean of the interval of the curve that contains `frames` (`interval`); (0,) if no game ended in it.
        Nothing is extrapolated: the games of the first interval were played with budgets from none to its end, so its
        mean is a score at its end, and there is none before it.

        Raises:
            ValueError: there is no such game, or no score at that number of frames.
        """
        data = self._game(game)
        _, last = self.interval(frames)
        marks = self._entry.get("marks", [])
        if frames in marks and data.get("marks"):
            values = _floats(data["marks"][marks.index(frames)])
        elif frames == self.final_frames:
            return self.final(game)
        else:
            values = _floats([data["mean"][self._entry["frames"].index(last)]])
        return values[~np.isnan(values)]


def published_names(pattern: str = "") -> tuple[str, ...]:
    """The names of all published agents, or of those that contain a text.

    Example:
        >>> from atari.learning import published_names
        >>> published_names("rainbow")[:2]
        ('cleanrl/rainbow_atari', 'dopamine/rainbow')
    """
    agents = read_table("index")["agents"]
    names = (f"{source}/{agent}" for source in agents for agent in agents[source])
    return tuple(name for name in names if pattern in name)


def published(name: str) -> Published:
    """The published results of an agent, by a name of `published_names`, or by a short one such as "cleanrl/ppo".

    Raises:
        TypeError: the name is no string.
        ValueError: there is no such agent; the nearest is suggested.

    Example:
        >>> from atari.learning import published
        >>> rainbow = published("dopamine/rainbow")
        >>> rainbow.at("pong", 10_000_000).shape, rainbow.budgets[0]
        ((5,), 1000000)
    """
    aliases = read_table("index")["aliases"]
    name = aliases.get(name, name) if isinstance(name, str) else name
    check_known_name("published agent", name, published_names(), "atari.learning.published_names() has all")
    entry, source = _entry(name), name.partition("/")[0]
    sources = read_table("sources")
    provenance = sources.get("/".join(name.split("/")[:2])) or sources[source]
    frames = entry["frames"][-1] if "frames" in entry else entry["final_frames"]
    return Published(name, entry["title"], entry["protocol"], provenance, tuple(entry["games"]), frames)


def human_scores(table: str = "noop57") -> dict[str, tuple[float, float]]:
    """Scores of random play and of a human by game, of one table; docs/evaluation.md says where they differ.

    Raises:
        TypeError: the name is no string.
        ValueError: there is no such table; the nearest is suggested.

    Example:
        >>> from atari.learning import human_scores
        >>> human_scores()["breakout"]  # of random play, and of a human
        (1.7, 30.5)
    """
    tables = read_table("human")["tables"]
    entries = tables[check_known_name("human table", table, _human_tables())]["games"]
    return {game: (random, human) for game, (random, human) in entries.items()}


def _human_tables() -> list[str]:
    """The tables that have human scores, not only random ones."""
    tables = read_table("human")["tables"]
    return [name for name, table in tables.items() if all(None not in pair for pair in table["games"].values())]


def _entry(name: str) -> dict[str, Any]:
    source, _, agent = name.partition("/")
    entry: dict[str, Any] = read_table(source)[agent]
    return entry


def _floats(values: list[float | None]) -> Floats:
    return np.array([np.nan if value is None else value for value in values], np.float64)
