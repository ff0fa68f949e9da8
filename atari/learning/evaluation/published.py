"""`Published`: learning curves and scores that other projects have published, and tables of human scores.

Their sources and licences are in `Published.source`, in docs/evaluation.md, and in `data/LICENSES.md`.
"""

import difflib
import json
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.base.frozen import FrozenDict
from atari.base.validation import check_integer

Floats = npt.NDArray[np.float64]

_FOLDER = Path(__file__).parent / "data"


@dataclass(frozen=True, eq=False)
class Curve:
    """A learning curve of one game, see `Published.curve`."""

    frames: npt.NDArray[np.int64]
    mean: Floats
    std: Floats


class Published:
    """The scores that a project has published about one agent: of whole games, not clipped.

    Args:
        name: one of `Published.names()`, or a short name such as "cleanrl/ppo".

    Attributes:
        name: the full name, such as "dopamine/rainbow".
        title: the agent's name in its source.
        protocol: facts about its environments: `repeat_action_probability`, `noop_max`, `full_action_space`,
            `frame_skip`, `max_frames` (None is not stated), and `phase`, when its scores were taken.
        source: `repo`, `commit`, `paths`, `licence`, `copyright` and `notes` of the source, and `score`, the meaning of
            its scores.
        games: the games that have scores.
        final_frames: emulator frames of the whole training; None is not stated.

    Raises:
        TypeError: the name is no string.
        ValueError: no agent has this name; the nearest is suggested.

    Example:
        >>> from atari.learning import Published
        >>> rainbow = Published("dopamine/rainbow")
        >>> rainbow.title, len(rainbow.games), rainbow.has_curves
        ('Rainbow', 60, True)
        >>> rainbow.at("pong", 10_000_000).shape, rainbow.budgets[0]
        ((5,), 1000000)
        >>> curve = rainbow.curve("pong")
        >>> int(curve.frames[-1]), round(float(curve.mean[-1]), 1)
        (199000000, 20.2)
        >>> Published.names("rainbow")[:2]
        ('cleanrl/rainbow_atari', 'dopamine/rainbow')
        >>> random, human = Published.human_scores()["breakout"]
        >>> random, human
        (1.7, 30.5)
    """

    def __init__(self, name: str) -> None:
        full = read_table("index")["aliases"].get(name, name) if isinstance(name, str) else name
        self.name = check_known_name(
            "published agent", full, self.names(), "`atari evaluate --list` and Published.names() have all"
        )
        source, _, agent = self.name.partition("/")
        self._entry: Mapping[str, Any] = read_table(source)[agent]
        self.title: str = self._entry["title"]
        self.protocol: Mapping[str, Any] = self._entry["protocol"]
        sources = read_table("sources")
        self.source: Mapping[str, Any] = sources.get("/".join(self.name.split("/")[:2])) or sources[source]
        self.games = tuple(self._entry["games"])
        self.final_frames: int | None = self._entry["frames"][-1] if self.has_curves else self._entry["final_frames"]

    @staticmethod
    def names(part: str = "") -> tuple[str, ...]:
        """The names of all published agents that contain a text."""
        agents = read_table("index")["agents"]
        names = (f"{source}/{agent}" for source in agents for agent in agents[source])
        return tuple(name for name in names if part in name)

    @staticmethod
    def human_scores(table: str = "noop57") -> dict[str, tuple[float, float]]:
        """The scores of random play and of a human by game; docs/evaluation.md says where the tables differ.

        Raises:
            TypeError: the name is no string.
            ValueError: no table has this name; the nearest is suggested.
        """
        tables = read_table("human")["tables"]
        # Some tables have random scores only.
        known = [name for name in tables if all(None not in pair for pair in tables[name]["games"].values())]
        games = tables[check_known_name("human table", table, known)]["games"]
        return {game: (random, human) for game, (random, human) in games.items()}

    def _game(self, game: str) -> dict[str, Any]:
        games: Mapping[str, dict[str, Any]] = self._entry["games"]
        return games[check_known_name(f"score of {self.name} in game", game, self.games)]

    @property
    def has_curves(self) -> bool:
        """Whether the source has learning curves, not only final scores."""
        return "frames" in self._entry

    @property
    def budgets(self) -> tuple[int, ...]:
        """The emulator frames of training at which scores were taken, in ascending order; () if they are not stated."""
        last = [] if self.final_frames is None else [self.final_frames]
        return tuple(sorted({*self._entry.get("marks", []), *self._entry.get("frames", []), *last}))

    def interval(self, frames: int) -> tuple[int, int]:
        """The interval of training, (first frame, last frame), over whose games the score at `frames` is the mean.

        Both are `frames` where the source has a score at exactly these frames. Frames at most 1 % beyond the last score
        stand for it (`are_alike`).

        Raises:
            TypeError, ValueError: `frames` is no integer, or the source has no score there.
        """
        frames = self._reached(check_integer("frames", frames, 1, 10**15))
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

    def _reached(self, frames: int) -> int:
        last = max(self.budgets, default=0)
        return last if frames > last and are_alike({last, frames}) else frames

    def curve(self, game: str) -> Curve:
        """The learning curve of a game, with three arrays.

        - `frames`: (n,) int64, emulator frames of the training at the right end of each interval;
        - `mean`: (n,) float64, mean score over seeds of the games that ended in the interval; NaN where none did;
        - `std`: (n,) float64, standard deviation over seeds (of the population); NaN where it is not known.

        Raises:
            ValueError: no score of the game was published, or the source has final scores only.
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
            ValueError: no score of the game was published.
        """
        data = self._game(game)
        values = _floats(data.get("final") or [data["score"]])
        return values[~np.isnan(values)]

    def at(self, game: str, frames: int) -> Floats:
        """The scores after `frames` emulator frames of training: (seeds,) float64, or (1,), the mean over seeds.

        Scores of single seeds are kept at 1, 2.5, 5, 10, 20, 50, 100 million frames and at the end. Elsewhere the
        score is the mean of the interval of the curve that contains `frames` (`interval`); (0,) if no game ended in it.
        Nothing is extrapolated: the first interval begins with an untrained network, so its mean is a score at its end,
        and no earlier frame has a score.

        Raises:
            ValueError: no score of the game was published, or none at these frames.
        """
        data, frames = self._game(game), self._reached(frames)
        _, last = self.interval(frames)
        marks = self._entry.get("marks", [])
        if frames in marks and data.get("marks"):
            values = _floats(data["marks"][marks.index(frames)])
        elif frames == self.final_frames:
            return self.final(game)
        else:
            values = _floats([data["mean"][self._entry["frames"].index(last)]])
        return values[~np.isnan(values)]


def are_alike(budgets: Collection[int]) -> bool:
    """Whether budgets of training differ by 1 % at most: a training ends with a whole update."""
    return max(budgets, default=0) <= 1.01 * min(budgets, default=0)


def _floats(values: list[float | None]) -> Floats:
    return np.array([np.nan if value is None else value for value in values], np.float64)


@cache
def read_table(name: str) -> Any:
    """The content of a file of `data`, read at its first use."""
    return json.loads((_FOLDER / f"{name}.json").read_text(encoding="utf-8"))


def check_known_name(
    kind: str, name: Any, known: Iterable[str], where: str = "", others: Mapping[str, str] = FrozenDict()
) -> str:
    """Check that `name` is one of `known`, and return it.

    Args:
        kind: the kind of thing that has the name, for the error.
        name: the user's name.
        known: the names that exist.
        where: the end of the error; "" lists the known names.
        others: words of other projects, with the known name that each means.

    Raises:
        TypeError: `name` is no string.
        ValueError: `name` is not known; the nearest known name is suggested, if one is near.
    """
    names = list(known)
    if not isinstance(name, str):
        raise TypeError(f"{kind} is named by a string such as {names[0]!r}, got {name!r}")
    if name not in names:
        wanted = name.lower()
        near = [known for known in names if wanted and known.startswith(wanted)]
        near = near or [known for word, known in others.items() if word in wanted and known in names]
        family = [known for known in names if "/" in wanted and known.startswith(wanted.partition("/")[0] + "/")]
        if family and not near:
            raise ValueError(f"there is no {kind} {name!r}; {wanted.partition('/')[0]} has {', '.join(family)}")
        near = near or sorted((known for known in names if len(wanted) > 2 and wanted in known), key=len)
        near = near or difflib.get_close_matches(wanted, names, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        raise ValueError(f"there is no {kind} {name!r}; {hint}{where or 'known are ' + ', '.join(names)}")
    return name
