"""Findings from the actions of plays alone: actions that are random from some score on, and loops of actions."""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from atari.learning.diagnosis.findings import Finding, percent, scores_before
from atari.learning.diagnosis.plays import Play, Plays

_MOST_PLACES = 1000
_LEAST_RANDOM_STEPS = 100
_LEAST_GAIN = 25.0
"""Nats by which the steps must be more probable with random actions from a place on than without."""
_TIE = 10.0
"""Nats by which a later place must be better than random actions from the first step on."""
_MOST_SURPRISE = 4.0
"""Standard deviations that a statistic of random actions may be above its mean."""
_LONGEST_PERIOD = 32
_LEAST_LOOP, _LEAST_HELD = 100, 400
"""Steps of a loop of several actions, and of one action that is held."""
_LEAST_BARREN = 0.5
"""The part of a loop that must be in a row without a reward: what repeats and gets rewards is no loop."""
_LEAST_LOOPING_GAMES, _MOST_OF = 0.25, 0.7

Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]


def random_from(plays: Plays) -> Finding | None:
    """The first score, or step, from which on the actions of all games are uniform and independent; None if there is
    no such place.

    Actions before the place are described by the probability of each action after each other one. The place is that
    with the highest likelihood. A policy that draws its actions uniformly from the first step on has the place 0.

    Args:
        plays: the games, see `play_games`.

    Example:
        >>> from atari import Task
        >>> from atari.learning import load_policy
        >>> from atari.learning.diagnosis.habits import random_from
        >>> from atari.learning.diagnosis.plays import play_games
        >>> print(random_from(play_games(load_policy("random"), Task.of("breakout"), games=4, seed=0)))
        The actions are uniformly random and independent of each other in all games, from the first step on.
    """
    if len(plays.actions) < 2:
        return None
    by_score = _random_from([scores_before(play) for play in plays], plays)
    by_step = _random_from([np.arange(len(play)) for play in plays], plays)
    gain, place, share = max(by_score, by_step)
    if gain < _LEAST_GAIN:
        return None
    options = ("--epsilon 0.001",)
    if share == 1:
        text = "The actions are uniformly random and independent of each other in all games, from the first step on."
        return Finding("random from", "step 0", 0, share, text, options)
    unit: Unit = "score" if by_score[0] >= by_step[0] else "step"
    text = (
        f"From {_words(unit, place)} on, the actions are uniformly random and independent of each other in all games "
        f"that get there, and not before: {percent(share)} of all steps."
    )
    return Finding("random from", _words(unit, place), place, share, text, options)


Unit = Literal["score", "step"]


def _words(unit: Unit, place: int) -> str:
    return f"{place:,} points" if unit == "score" else f"step {place:,}"


def _random_from(keys: Sequence[Ints], plays: Plays) -> tuple[float, int, float]:
    """The gain in nats, the place and the share of the steps, if actions are random from a value of `keys` on.

    A game's key does not always rise. Steps count as after the place from the first step on whose key reaches it.
    """
    count = len(plays.actions)
    reached = np.concatenate([np.maximum.accumulate(key)[1:] for key in keys])
    pairs = np.concatenate([play.actions[:-1].astype(np.int64) * count + play.actions[1:] for play in plays])
    values = np.unique(reached)
    if len(values) > _MOST_PLACES:
        values = np.unique(np.quantile(values, np.linspace(0, 1, _MOST_PLACES), method="nearest"))
    bins = np.searchsorted(values, reached, side="right") - 1  # bin i: from place i to the next one
    table = np.zeros((len(values), count * count))
    np.add.at(table, (np.maximum(bins, 0), pairs), 1)
    before = np.concatenate([np.zeros((1, count * count)), np.cumsum(table, 0)])  # row i: before place i
    after = (before[-1] - before[:-1]).reshape(-1, count, count)
    steps_after = after.sum((1, 2))
    # Adding two constant rows makes the place "never" the last one.
    likelihood = _markov(before.reshape(-1, count, count)) - np.append(steps_after, 0) * np.log(count)
    allowed = [
        steps >= _LEAST_RANDOM_STEPS and _is_uniform(pair_counts)
        for steps, pair_counts in zip(steps_after, after, strict=True)
    ]
    gains = np.where(allowed, likelihood[:-1] - likelihood[-1], -np.inf)
    best = int(gains.argmax()) if gains[0] < gains.max() - _TIE else 0
    return float(gains[best]), int(values[best]), float(steps_after[best] / len(pairs))


def _markov(counts: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The logarithm of the probability of pairs of actions, (places, A, A), whose probabilities are learnt on the way.

    It is the estimator of Krichevsky and Trofimov in its usual approximation: the best fit, less half a logarithm of
    the number of steps for each free probability of a row that occurs.
    """
    rows = counts.sum(2, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        fit = np.where(counts > 0, counts * np.log(counts / rows), 0.0).sum((1, 2))
    free = (counts.shape[2] - 1) / 2
    return np.asarray(fit - free * np.log(np.maximum(rows[:, :, 0], 1)).sum(1))


def _is_uniform(counts: npt.NDArray[np.float64]) -> bool:
    """Whether uniform and independent draws could have given these counts of pairs of actions, (A, A)."""
    expected = counts.sum() / counts.size
    if expected <= 0:
        return False
    statistic = float(((counts - expected) ** 2).sum() / expected)
    free = counts.size - 1
    return statistic < free + _MOST_SURPRISE * np.sqrt(2 * free)


class _Stretch(NamedTuple):
    """Steps start..end-1 of a game in which actions repeat with a period. `barren` of them in a row give nothing."""

    start: int
    end: int
    period: int
    barren: int = 0


def loop(plays: Plays) -> Finding | None:
    """The score, or step, from which a cycle of actions repeats without a reward; None if there is no such place.

    A loop is repeated until the game gets no reward any more. In a row it has at least 100 steps without a reward, more
    than half of its own steps, and more than each repetition that a game has left for a reward. One action that is held
    can be patience: it needs at least 400 steps, and more than half of the longest time without a reward from which a
    game went on. At least a quarter of the games must have a loop.

    Args:
        plays: the games, see `play_games`.

    Example:
        >>> from atari import Task
        >>> from atari.learning import load_policy
        >>> from atari.learning.diagnosis.habits import loop
        >>> from atari.learning.diagnosis.plays import play_games
        >>> task = Task.of("breakout", max_num_frames_per_episode=4000)
        >>> loop(play_games(load_policy("noop"), task, games=1, seed=0)).place
        '0 points'
    """
    found = [_loops(play) for play in plays]
    went_on = max((one.barren for _, left in found for one in left), default=0)
    gap = max((_longest_gap(play, last) for play, (last, _) in zip(plays, found, strict=True)), default=0)
    stuck = {
        number: last
        for number, (last, _) in enumerate(found)
        if last is not None
        and last.barren > max(went_on, *((_LEAST_HELD, gap / 2) if last.period == 1 else (_LEAST_LOOP,)))
        and last.barren > _LEAST_BARREN * (last.end - last.start)
    }
    if len(stuck) < max(1, _LEAST_LOOPING_GAMES * len(plays)):
        return None
    unit, place = _beginning(plays, stuck)
    lengths = [one.end - one.start for one in stuck.values()]
    period = int(np.median([one.period for one in stuck.values()]))
    share = sum(lengths) / sum(map(len, plays))
    what = "one action is held" if period == 1 else f"a cycle of {period} actions repeats"
    text = (
        f"From {_words(unit, place)} on, {what} in {len(stuck)} of {len(plays)} games, for {min(lengths):,} to "
        f"{max(lengths):,} steps, without a way out to a reward; no game that left a repetition for a reward had "
        f"repeated more than {went_on:,} steps without one."
    )
    return Finding(
        "loop", _words(unit, place), place, share, text, ("--epsilon 0.01", "--sticky 0.25", "--gamma 0.997")
    )


def _longest_gap(play: Play, last: _Stretch | None) -> int:
    """The most steps without a reward after which a reward came, before the last stretch."""
    rewarded = np.flatnonzero(play.rewards[: None if last is None else last.start] > 0)
    return int(np.diff(rewarded, prepend=-1).max()) if len(rewarded) else 0


def _loops(play: Play) -> tuple[_Stretch | None, list[_Stretch]]:
    """The longest stretch of repeated actions after whose end no reward comes, and the stretches left for a reward."""
    rewarded = np.flatnonzero(play.rewards > 0)
    stuck: list[_Stretch] = []
    left: list[_Stretch] = []
    for one in _repetitions(play.actions):
        inside = rewarded[(rewarded >= one.start) & (rewarded < one.end)]
        barren = int(np.diff(inside, prepend=one.start - 1, append=one.end).max())
        (left if len(rewarded) and rewarded[-1] >= one.end else stuck).append(one._replace(barren=barren))
    return max(stuck, key=lambda one: one.barren, default=None), left


def _repetitions(actions: npt.NDArray[np.uint8]) -> list[_Stretch]:
    """The stretches of at least 40 steps in which actions repeat with a period, each with its shortest period."""
    found: list[_Stretch] = []
    taken = np.zeros(len(actions), np.bool_)
    for period in range(1, min(_LONGEST_PERIOD, len(actions) - 1) + 1):
        for start, end in _runs(actions, period):
            if end - start >= max(40, 4 * period) and taken[start:end].mean() < 0.5:
                found.append(_Stretch(start, end, period))
                taken[start:end] = True
    return sorted(found)


def _runs(actions: npt.NDArray[np.uint8], period: int) -> list[tuple[int, int]]:
    """The steps start..end-1 in which actions repeat with a period.

    One other action, such as a random one, does not end a run if the cycle goes on after it as if nothing were.
    """
    same = np.concatenate(([False], actions[period:] == actions[:-period], [False]))
    edges = np.flatnonzero(same[1:] != same[:-1]).reshape(-1, 2)
    runs: list[tuple[int, int]] = []
    if not len(edges) or (edges[:, 1] - edges[:, 0]).max() < 3 * period:
        return runs
    edges[:, 1] += period
    for start, end in edges.tolist():
        if runs and start <= runs[-1][1] + 1 and runs[-1][1] - runs[-1][0] >= 4 * period:
            first = runs[-1][0]
            expected = actions[first + (np.arange(start, end) - first) % period]
            if (actions[start:end] != expected).sum() <= 1:
                runs[-1] = (first, end)
                continue
        runs.append((start, end))
    return runs


def _beginning(plays: Plays, loops: dict[int, _Stretch]) -> tuple[Unit, int]:
    """The score or step from which games loop.

    It is a score if most loops begin beside a reward, and one score lies between the scores before and after it in most
    games. Else it is a step if most loops begin at about the same step; else the score, too.
    """
    starts = np.array([one.start for one in loops.values()])
    gains = [np.flatnonzero(plays[number].rewards > 0) for number in loops]
    # By chance, the last actions before a cycle may equal the cycle's.
    beside = [own[(own >= start - 2) & (own < start + 4)] for own, start in zip(gains, starts.tolist(), strict=True)]
    near = {number: int(own[-1]) for number, own in zip(loops, beside, strict=True) if len(own)}
    middle = int(np.median(starts))
    if len(near) >= _MOST_OF * len(loops):
        totals = {number: plays[number].totals for number in near}
        before = np.array([totals[number][step] - plays[number].rewards[step] for number, step in near.items()])
        after = np.array([totals[number][step] for number, step in near.items()])
        fits = [int(((before < score) & (after >= score)).sum()) for score in after]
        if max(fits) >= _MOST_OF * len(loops):
            return "score", int(min(score for score, fit in zip(after, fits, strict=True) if fit == max(fits)))
    if len(loops) > 1 and (np.abs(starts - middle) <= 4 + middle // 20).mean() >= _MOST_OF:
        return "step", middle
    return "score", int(np.median([scores_before(plays[number])[one.start] for number, one in loops.items()]))
