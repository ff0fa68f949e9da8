"""`Comparison.facts`: the values that are frequent at some steps of play and rare elsewhere, as ranges of labels."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.games.game import RamLabel
from atari.games.objects import Positions, positions
from atari.lab.labels import Labels
from atari.learning.diagnosis.findings import percent
from atari.learning.diagnosis.plays import Place, Play, Plays

_MOST_FACTS = 3
_MOST_ELSEWHERE = 50_000
"""The most steps of play with which places are compared; of more, every n-th."""
_MOST_BOUNDS = 48
"""The most values among which the bounds of a range are chosen."""
_LEAST_EVIDENCE, _OF_COUNT, _OF_RANGE = 6.0, 1.0, 4.0
"""The nats of evidence over all games that a fact needs, and how many more for a range, which is the best of many: few
labels are counts."""
_LEAST_PART, _LEAST_RATIO = 0.5, 2.0
"""A fact holds in this part of the places, and is there this many times as frequent as elsewhere."""
_LEAST_NEW, _MOST_ALIKE = 1.5, 0.5
"""The same ratio where the earlier facts hold, which else imply it; the most that two facts may coincide elsewhere."""
_NEARLY = 0.9
"""A range needs this part of the greatest divergence; of such ranges the rarest elsewhere is chosen."""
_LEAST_SPLIT, _MOST_SPLIT, _LEAST_PLACES = 0.25, 0.75, 8
"""A fact that holds in this part of the places makes a cluster of them, if it and the rest have this many places."""
_PLAIN_KINDS = ("position_x", "position_y", "count", "direction", "flag", "timer")
_DOUBTFUL = ("no effect seen", "not confirmed", "not met")

Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]
Array = npt.NDArray[Any]


@dataclass(frozen=True)
class Fact:
    """A range of a value that is frequent at some places and rare elsewhere in play.

    Attributes:
        name: the name of a label; "ball_x - player_x", the difference of two; "byte 17" in a game without labels;
            "steps since a reward"; or "action LEFT", the action that follows.
        low, high: the range, both included; None if the fact is that a thing is visible, or not.
        there: the part of the places at which it holds.
        elsewhere: the part of the other steps of play at which it holds.
        visible: False for the fact that a thing is not visible.

    Example:
        >>> from atari.learning.diagnosis.facts import Fact
        >>> str(Fact("invaders_left_count", 1, 3, there=0.75, elsewhere=0.175))
        'invaders_left_count is 1 to 3 in 75 % (elsewhere in 18 %)'
    """

    name: str
    low: int | None
    high: int | None
    there: float
    elsewhere: float
    visible: bool = True

    def __str__(self) -> str:
        return f"{self.text} in {percent(self.there)} (elsewhere in {percent(self.elsewhere)})"

    @property
    def text(self) -> str:
        """The fact in words, without its shares."""
        if self.name.startswith("action "):
            return f"the next action is {self.name.removeprefix('action ')}"
        if self.low is None or self.high is None:
            return f"{self.name} is {'' if self.visible else 'not '}visible"
        numbers = f"{self.low:,}" if self.low == self.high else f"{self.low:,} to {self.high:,}"
        if self.name == _WAIT:
            return f"the last reward is {numbers} steps ago"
        return f"{self.name} is {numbers}"


_WAIT = "steps since a reward"


@dataclass(frozen=True)
class _Column:
    """A value at some steps: numbers, and whether each is visible.

    `weight` prefers plain values. Without `hides`, it is no fact that the value is not visible. With `alone`, it may be
    a fact even if earlier ones imply it: invaders stand low because few are left, and their number says more.
    """

    values: Ints
    visible: Bools
    weight: float = 1.0
    hides: bool = True
    alone: bool = False


class Comparison:
    """All steps of play, with which the facts of some places are found.

    Args:
        plays: the games.
        longest: the steps without a reward after which steps are left out: a game that stands still for long would
            else outnumber all others.

    Example:
        >>> from atari import Task
        >>> from atari.learning import load_policy
        >>> from atari.learning.diagnosis.facts import Comparison
        >>> from atari.learning.diagnosis.moments import Moment
        >>> from atari.learning.diagnosis.plays import play_games
        >>> plays = play_games(load_policy("random"), Task.of("breakout"), games=12, seed=0)
        >>> losses = [Moment(number, len(play) - 1, "end") for number, play in enumerate(plays)]
        >>> for fact in Comparison(plays, longest=250).facts(losses, low_score=0):
        ...     print(fact)
        ball_x is not visible in 100 % (elsewhere in 26 %)
    """

    def __init__(self, plays: Plays, longest: int) -> None:
        self._plays = plays
        waits = [_waits(play) for play in plays]
        every = max(1, -(-sum(map(len, waits)) // _MOST_ELSEWHERE))
        self._steps = [np.flatnonzero(own <= longest)[::every] for own in waits]
        self._scores = np.concatenate([play.totals[own] for play, own in zip(plays, self._steps, strict=True)])

    def facts(self, places: Sequence[Place], low_score: float, *, waits: bool = True) -> tuple[Fact, ...]:
        """The facts about the states of some places, at most three, the most telling first.

        Each fact is compared where the earlier ones hold, so one that an earlier one implies is not found, unless it is
        a count. All are compared with steps at scores from `low_score` on, unless these are rare: bytes that only show
        that the game is advanced make no facts.

        Args:
            places: the steps.
            low_score: the score that most of the places have.
            waits: whether the steps since the last reward may be a fact.
        """
        columns = self._columns_at(places)
        if not waits:
            columns.pop(_WAIT)
        games = len({place.play for place in places})
        late = self._late(low_score)
        there, elsewhere = np.ones(len(places), np.bool_), late
        found: list[_Found] = []
        while len(found) < _MOST_FACTS and there.mean() >= _LEAST_PART:
            new = self._facts(columns, there, elsewhere, _LEAST_PART) if elsewhere.sum() >= 20 else []
            new = [one for one in new if one.evidence * games * there.mean() >= one.needed]
            lone = {name: column for name, column in columns.items() if column.alone}
            new += [
                one
                for one in self._facts(lone, np.ones_like(there), late, _LEAST_PART)
                if one.evidence * games >= one.needed
            ]
            new = [one for one in new if not any(_alike(one.elsewhere, other.elsewhere) for other in found)]
            if not new:
                break
            best = max(new, key=lambda one: one.evidence)
            found.append(best)
            there, elsewhere = there & best.there, elsewhere & best.elsewhere
            columns.pop(best.fact.name)
        return tuple(one.fact for one in found)

    def cluster(self, places: Sequence[Place], low_score: float) -> Bools | None:
        """Where a fact holds that divides the places, (n,) bool; None if no fact does, or one holds at nearly all."""
        games = len({place.play for place in places})
        columns, everywhere = self._columns_at(places), np.ones(len(places), np.bool_)
        columns.pop(_WAIT)
        facts = self._facts(columns, everywhere, self._late(low_score), _LEAST_SPLIT)
        best = max(facts, key=lambda one: one.evidence, default=None)
        if best is None or best.evidence * games < 2 * best.needed or best.there.mean() > _MOST_SPLIT:
            return None
        few = min(best.there.sum(), (~best.there).sum()) < _LEAST_PLACES
        return None if few else best.there

    def _late(self, low_score: float) -> Bools:
        late: Bools = self._scores >= low_score
        return late if late.mean() >= 0.1 else np.ones_like(late)

    def _columns_at(self, places: Sequence[Place]) -> dict[str, _Column]:
        order = np.argsort([place.play for place in places], kind="stable")
        steps: list[list[int]] = [[] for _ in self._plays]
        for row in order.tolist():
            steps[places[row].play].append(max(0, places[row].step))
        back = np.argsort(order)
        columns = _columns(self._plays, [np.array(own, np.int64) for own in steps])
        return {name: replace(one, values=one.values[back], visible=one.visible[back]) for name, one in columns.items()}

    @cached_property
    def _elsewhere(self) -> dict[str, _Column]:
        return _columns(self._plays, self._steps)

    def _facts(
        self, columns: Mapping[str, _Column], there: Bools, elsewhere: Bools, least_part: float
    ) -> "list[_Found]":
        """The facts that stand out about the places `there`, against the steps `elsewhere`."""
        return [
            one
            for name, column in columns.items()
            for one in _facts_of(name, column, self._elsewhere[name], there, elsewhere, least_part)
        ]


def _alike(one: Bools, other: Bools) -> bool:
    """Whether two facts hold at about the same steps of play."""
    return bool((one & other).sum() > _MOST_ALIKE * (one | other).sum())


def _waits(play: Play) -> Ints:
    """The steps since a reward, or since the beginning, after each step, (T,) int64."""
    steps = np.arange(len(play))
    return steps - np.maximum.accumulate(np.where(play.rewards != 0, steps, -1))


def _columns(plays: Plays, steps: Sequence[Ints]) -> dict[str, _Column]:
    """The values at some steps of each game, by their names, in the order of the games."""

    def chosen(arrays: Sequence[Array]) -> Array:
        return np.concatenate([array[own] for array, own in zip(arrays, steps, strict=True)])

    rams = chosen([play.rams for play in plays])
    columns = _of_labels(plays.labels, rams) if plays.labels.names else _of_bytes(plays, rams)
    columns[_WAIT] = replace(_always(chosen([_waits(play) for play in plays])), weight=0.5)
    following = chosen([np.append(play.actions[1:].astype(np.int64), -1) for play in plays])
    for index, name in enumerate(plays.actions):
        columns[f"action {name}"] = _Column(np.zeros_like(following), following == index, hides=False)
    return columns


def _always(values: Array) -> _Column:
    """A column of a value that is always visible."""
    return _Column(values.astype(np.int64), np.ones(len(values), np.bool_))


def _of_labels(labels: Labels, rams: Array) -> dict[str, _Column]:
    """Columns of labels and distances, without doubtful ones, and without score and lives, which groups have anyway."""
    known = labels.game.ram_labels
    counted = {known[name].index for name in labels.names if known[name].kind in ("score", "lives")}
    values, visible = labels.evaluate(rams)
    columns = {
        name: _Column(
            own.astype(np.int64),
            seen,
            weight=1.0 if known[name].kind in _PLAIN_KINDS else 0.5,
            alone=known[name].kind == "count",
        )
        for name, own, seen in zip(labels.names, values, visible, strict=True)
        if known[name].index not in counted and known[name].evidence not in _DOUBTFUL and not _is_second(known, name)
    }
    return {**columns, **_distances(positions({name: known[name] for name in columns}), columns)}


def _is_second(known: Mapping[str, RamLabel], name: str) -> bool:
    """Whether a label is a second reading of the label that has a part of its name, such as `enemies_y_ari`."""
    owner, _, last = name.rpartition("_")
    return not last.isdigit() and owner in known and known[owner].kind == known[name].kind


def _distances(found: Positions, columns: Mapping[str, _Column]) -> dict[str, _Column]:
    """Columns of the distances of things from the player, where both are visible."""
    player = found.get("player", {})
    distances: dict[str, _Column] = {}
    for owner, axes in found.items():
        for axis in sorted(axes.keys() & player.keys()) if owner != "player" else ():
            one, own = columns[axes[axis].name], columns[player[axis].name]
            name = f"{axes[axis].name} - {player[axis].name}"
            distances[name] = _Column(one.values - own.values, one.visible & own.visible, hides=False)
    return distances


def _of_bytes(plays: Plays, rams: Array) -> dict[str, _Column]:
    """Columns of the bytes that change, without those that change with the score or the lives alone."""
    changes, counted = np.zeros(128), np.zeros(128)
    for play in plays:
        changed = play.rams[1:] != play.rams[:-1]
        changes += changed.sum(0)
        counted += changed[(play.rewards != 0)[1:] | (play.lives != play.lives_before)[1:]].sum(0)
    chosen = np.flatnonzero((changes > 0) & (counted < 0.8 * changes))
    return {f"byte {index}": _always(rams[:, index]) for index in chosen.tolist()}


@dataclass(frozen=True)
class _Found:
    """A fact, its evidence in nats a place, the nats that it needs, and where it holds."""

    evidence: float
    needed: float
    fact: Fact
    there: Bools
    elsewhere: Bools


def _facts_of(
    name: str, one: _Column, other: _Column, there: Bools, elsewhere: Bools, least_part: float
) -> list[_Found]:
    """The facts of a value that stand out: that it is in its most telling range, and that it is not visible."""
    holding: list[tuple[int | None, int | None, Bools, Bools]] = []
    if one.hides:
        holding.append((None, None, ~one.visible, ~other.visible))
    if (bounds := _range(one, other, there, elsewhere)) is not None:
        low, high = bounds
        within, others = (own.visible & (own.values >= low) & (own.values <= high) for own in (one, other))
        all_seen = bool((others == other.visible).all()) and not other.visible.all()
        holding.append((None, None, within, others) if all_seen else (low, high, within, others))
    found = []
    for number, (first, last, within, others) in enumerate(holding):
        part, other_part = within[there].mean(), others[elsewhere].mean()
        whole = float(within.mean()), float(others.mean())
        if whole[0] >= max(least_part, _LEAST_RATIO * whole[1]) and part >= _LEAST_NEW * other_part:
            fact = Fact(name, first, last, *whole, visible=not (one.hides and number == 0))
            needed = _LEAST_EVIDENCE + (0.0 if first is None else _OF_COUNT if one.alone else _OF_RANGE)
            evidence = one.weight * float(_divergence(part, other_part))
            found.append(_Found(evidence, needed, fact, within, others))
    return found


def _range(one: _Column, other: _Column, there: Bools, elsewhere: Bools) -> tuple[int, int] | None:
    """The range of values that is usual at the places and rare elsewhere; None if none is visible."""
    inside, outside = np.sort(one.values[there & one.visible]), np.sort(other.values[elsewhere & other.visible])
    if not len(inside):
        return None
    bounds = np.unique(inside)
    if len(bounds) > _MOST_BOUNDS:
        bounds = np.unique(np.quantile(inside, np.linspace(0, 1, _MOST_BOUNDS), method="nearest"))
    part, other_part = _in_ranges(inside, bounds) / there.sum(), _in_ranges(outside, bounds) / elsewhere.sum()
    divergence = _divergence(part, other_part)
    rarest = np.where((divergence >= _NEARLY * divergence.max()) & (part > 0), other_part, np.inf)
    low, high = np.unravel_index(int(rarest.argmin()), divergence.shape)
    return int(bounds[low]), int(bounds[high])


def _in_ranges(ordered: Array, bounds: Array) -> Array:
    """The number of sorted values within bounds[i]..bounds[j], (i, j); 0 for j < i."""
    first, last = np.searchsorted(ordered, bounds, "left"), np.searchsorted(ordered, bounds, "right")
    return np.triu(last[None, :] - first[:, None])


def _divergence(there: Any, elsewhere: Any) -> Any:
    """The Kullback-Leibler divergence of two shares, in nats; 0 where the first is not the greater one."""
    one, other = np.clip(there, 1e-9, 1 - 1e-9), np.clip(elsewhere, 1e-4, 1 - 1e-4)
    nats = one * np.log(one / other) + (1 - one) * np.log((1 - one) / (1 - other))
    return np.where(one > other, nats, 0.0)
