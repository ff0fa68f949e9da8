"""`moments_of`: the steps at which games end, lose a life or stop to score."""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from atari.env.lane_snapshot import LaneSnapshot
from atari.lab.labels import Labels
from atari.learning.diagnosis.plays import Play, Plays
from atari.vector import AtariVectorEnv

Kind = Literal["life", "end", "spare", "limit", "plateau"]

_MOST_BEFORE, _SAMPLED, _HELD = 64, 12, 6
"""The most steps before a moment from which forks are played, the most moments of a kind that have forks, and the most
actions that are held in them."""

Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Moment:
    """A step of a game.

    Attributes:
        play: the number of the game.
        step: the number of the step.
        kind: "life": the step lost a life, and the game went on. "end": it ended the game, by the last life in games
            with lives. "spare": it ended the game although the last life was not lost. "limit": the limit of frames
            stopped the game. "plateau": until this step there was no reward for so long as is unusual.

    Example:
        >>> from atari.learning.diagnosis.moments import Moment
        >>> Moment(play=0, step=20, kind="life").step
        20
    """

    play: int
    step: int
    kind: Kind


def moments_of(plays: Plays, threshold: int | None = None) -> tuple[Moment, ...]:
    """All moments of some games, by game and step.

    Args:
        plays: the games, see `play_games`.
        threshold: the steps without a reward from which on there is a plateau; None is `unusual_steps(plays)`.

    Example:
        >>> from atari import Task
        >>> from atari.learning import load_policy
        >>> from atari.learning.diagnosis.moments import moments_of
        >>> from atari.learning.diagnosis.plays import play_games
        >>> task = Task.of("breakout", max_num_frames_per_episode=400)
        >>> [moment.kind for moment in moments_of(play_games(load_policy("noop"), task, games=2, seed=0))]
        ['limit', 'limit']
    """
    threshold = unusual_steps(plays) if threshold is None else threshold
    found: list[Moment] = []
    for number, (play, spare) in enumerate(zip(plays, _spared(plays), strict=True)):
        own: list[tuple[int, Kind]] = [(step, "life") for step in lost_lives(play)]
        own += [(start + threshold, "plateau") for start, end in stretches(play) if end - start > threshold]
        own.append((len(play) - 1, "limit" if play.truncated else "spare" if spare else "end"))
        found += [Moment(number, step, kind) for step, kind in sorted(own)]
    return tuple(found)


def unusual_steps(plays: Plays) -> int:
    """The number of steps from which on a stretch without a reward and a lost life is unusual in these games.

    It is five times what 95 % of the stretches between two such events do not exceed, at least 100, and 250 steps in
    games with few rewards.
    """
    # The stretches at the ends of games are cut short, or those that are to be found.
    lengths = [end - start for play in plays for start, end in stretches(play)[:-1]]
    return max(100, round(5 * float(np.quantile(lengths, 0.95)))) if len(lengths) >= 20 else 250


def stretches(play: Play) -> list[tuple[int, int]]:
    """The steps of the events of a game, which are rewards and lost lives, in pairs of one and the next.

    The beginning counts as step -1, the end as one more than the last step.
    """
    events = np.flatnonzero((play.rewards != 0) | (play.lives < play.lives_before)).tolist()
    return list(zip([-1, *events], [*events, len(play)], strict=True))


def lost_lives(play: Play) -> list[int]:
    """The steps that lose a life after which the game goes on."""
    return np.flatnonzero(play.lives[:-1] < play.lives_before[:-1]).tolist()


def _spared(plays: Plays) -> list[bool]:
    """Whether each game has ended although its last life was not lost.

    So it is if more lives are left before the end than the last one. On the last one, the game's own byte of the lives
    says so, if it changes at the ends of some of these games and not of others. In Q*bert it goes down, or up where a
    press of FIRE has begun the next game.
    """
    ended = [index for index, play in enumerate(plays) if not play.truncated]
    last = _last_life(plays, ended)
    changed = {index: _changes_lives(plays.labels, plays[index]) for index in ended}
    on_last = {index for index in ended if plays[index].lives_before[-1] == last}
    is_sign = {changed[index] for index in on_last} == {True, False}
    return [
        index in changed and (play.lives_before[-1] > last or (index in on_last and is_sign and not changed[index]))
        for index, play in enumerate(plays)
    ]


def _last_life(plays: Plays, ended: Sequence[int]) -> int:
    """The number of lives with which the last one is played: 1, or 0 in games that count the others.

    Some games count from another number on: there, all games lose several lives and end at the same number.
    """
    before = {int(plays[index].lives_before[-1]) for index in ended}
    if len(before) == 1 and all(len(lost_lives(plays[index])) >= 2 for index in ended):
        return before.pop()
    return min([1, *(int(play.lives[:-1].min()) for play in plays if len(play) > 1)])


def _changes_lives(labels: Labels, play: Play) -> bool | None:
    """Whether the last step changes the game's own byte of the lives; None if the game has no such label."""
    names = [name for name in labels.names if labels.game.ram_labels[name].kind == "lives"]
    if len(names) != 1 or len(play) < 2:
        return None
    values, _ = labels.evaluate(play.rams[-2:])
    before, after = values[labels.names.index(names[0])].tolist()
    return bool(after != before)


def last_chance(plays: Plays, moments: Sequence[Moment]) -> int:
    """The steps before lost lives or ends at which a fork could last change them, in three of four moments.

    From a step before a moment, up to six actions are held in forks, with the draws of sticky actions of the game. The
    last chance is the last step from which a fork loses its life, or ends, at another step than the game: a bisection
    finds it, at most 64 steps before the moment. The forks are of at most 12 moments.

    Args:
        plays: the games, see `play_games`.
        moments: moments of the kinds "life", "end" and "spare".

    Example:
        >>> from atari import Task
        >>> from atari.learning import load_policy
        >>> from atari.learning.diagnosis.moments import last_chance, moments_of
        >>> from atari.learning.diagnosis.plays import play_games
        >>> plays = play_games(load_policy("random"), Task.of("breakout"), games=1, seed=0)
        >>> 1 <= last_chance(plays, moments_of(plays)) <= 64
        True
    """
    if len(moments) > _SAMPLED:  # drawn: every n-th lost life may be the first one of each game
        drawn = np.random.default_rng(plays.seed).choice(len(moments), _SAMPLED, replace=False)
        moments = [moments[number] for number in sorted(drawn.tolist())]
    # A fork begins after the last reset: what happens before it has another place.
    most = [min(_MOST_BEFORE, _steps_of_life(plays[moment.play], moment.step)) for moment in moments]
    places = [
        Moment(moment.play, moment.step - steps, moment.kind)
        for moment, limit in zip(moments, most, strict=True)
        for steps in range(1, limit + 1)
    ]
    states = dict(zip(places, plays.states(places), strict=True))
    low, high = np.ones(len(moments), np.int64), np.maximum(1, most)
    held = np.unique(np.linspace(0, len(plays.actions) - 1, _HELD).round().astype(np.int64))
    with closing(plays.player.make(len(moments) * len(held))) as envs:
        envs.reset(seed=0)
        while (low < high).any():
            rows, middle = np.flatnonzero(low < high), (low + high) // 2
            own = [(moments[row], int(middle[row])) for row in rows.tolist()]
            begins = [states[Moment(one.play, one.step - steps, one.kind)] for one, steps in own]
            changed = _forks_change(envs, begins, held, middle[rows])
            high[rows[changed]] = middle[rows[changed]]
            low[rows[~changed]] = middle[rows[~changed]] + 1
    return int(np.quantile(high, 0.75, method="nearest"))


def _steps_of_life(play: Play, step: int) -> int:
    """The steps from the last lost life before a step, or from the beginning, to the step."""
    lost = [one for one in lost_lives(play) if one < step]
    return step - (lost[-1] if lost else -1) - 1


def _forks_change(envs: AtariVectorEnv, states: Sequence[LaneSnapshot], held: Ints, steps: Ints) -> Bools:
    """Whether, from each state, a held action loses the life at another step than the game, `steps` later."""
    actions, after = np.tile(held, len(states)), steps.repeat(len(held))
    lanes = np.arange(len(actions))
    envs.restore(lanes.tolist(), [state for state in states for _ in held])
    before = envs.observe()[1]["lives"]
    lost = after + 1
    for step in range(1, int(after.max()) + 1):
        lanes = lanes[(lost[lanes] > after[lanes]) & (step <= after[lanes])]
        if not len(lanes):
            break
        _, _, terminated, truncated, info = envs.step(actions[lanes], env_id=lanes)
        lost[lanes[terminated | truncated | (info["lives"] < before[lanes])]] = step
    changed: Bools = (lost != after).reshape(len(states), -1).any(1)
    return changed
