"""`groups`: the moments at which games end, lose a life or stop to score, and what is common in them, in numbers."""

from collections import Counter
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from atari.env.lane_snapshot import LaneSnapshot
from atari.games.game import Game
from atari.lab.labels import Labels
from atari.learning.diagnosis.facts import Comparison, Fact
from atari.learning.diagnosis.plays import Play, Plays
from atari.vector import AtariVectorEnv

Kind = Literal["life", "end", "spare", "limit", "plateau"]

_ENDS = ("spare", "end", "limit")
_MOST_BEFORE, _SAMPLED, _HELD = 64, 12, 6
"""The most steps before a moment from which forks are played, the most moments of a kind that have forks, and the most
actions that are held in them."""
_MOST_CLUSTERS, _LEAST_CLUSTER = 3, 0.15
"""The most groups of moments of one kind, and the least part of these moments in each."""

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


@dataclass(frozen=True)
class Losses:
    """Games that lose all their lives in a short part of their length, and almost without points.

    Attributes:
        games: the number of these games.
        lives: the most lives that one of them loses.
        steps: the steps from before the first lost life to the end, as (low, high) of 80 % of these games.
        scores: the score at the first lost life, likewise.
        gained: the points after the first lost life, likewise.
    """

    games: int
    lives: int
    steps: tuple[int, int]
    scores: tuple[int, int]
    gained: tuple[int, int]


@dataclass(frozen=True)
class Group:
    """The moments of one kind, and what is common in them.

    Attributes:
        kind: the kind of the moments, see `Moment`.
        moments: the moments, by game and step.
        of_moments: the number of all moments of this kind: several groups of a kind have different facts.
        games: the number of games that have such a moment.
        of_games: the number of all games.
        median: the median of the score at the moments, of the whole games at their ends.
        low, high: the shortest range that has 80 % of these scores.
        before: the steps before the moments at which the facts hold, when actions could last change the moments.
        facts: what is common, the most telling first; a fact that another one implies is left out.
        losses: for ends, the games that lose all lives at once; None if they are less than half of the group.
        lives: for "spare", the number of games by the lives that are left, the most lives first.
        steps: for "plateau", the lengths of the shortest and the longest stretch without a reward, in steps.
    """

    kind: Kind
    moments: tuple[Moment, ...]
    of_moments: int
    games: int
    of_games: int
    median: float
    low: float
    high: float
    before: int = 0
    facts: tuple[Fact, ...] = ()
    losses: Losses | None = None
    lives: tuple[tuple[int, int], ...] = ()
    steps: tuple[int, int] | None = None

    @property
    def share(self) -> float:
        """The part of all games that has such a moment."""
        return self.games / self.of_games


def groups(plays: Plays) -> tuple[Group, ...]:
    """The moments of some games by kind: first the ends of games, by their number, then lost lives, then plateaus.

    A fact about a label is found by comparison of the states before the moments with all other steps of play. A life is
    often lost long after the fault, while an explosion is shown and a thing that has gone is hidden. So forks of some
    moments are played, each with an action held: facts hold at the last steps at which an action changes anything.

    Args:
        plays: the games, see `play_games`.

    Example:
        >>> from atari import Task
        >>> from atari.learning import load_policy
        >>> from atari.learning.diagnosis.moments import groups, words
        >>> from atari.learning.diagnosis.plays import play_games
        >>> task = Task.of("breakout", max_num_frames_per_episode=400)
        >>> for group in groups(play_games(load_policy("noop"), task, games=2, seed=0)):
        ...     print(words(group, task.definition))
        2 of 2 games reach the limit of frames, most at 0 points.
    """
    longest = unusual_steps(plays)
    moments, comparison = moments_of(plays, longest), Comparison(plays, longest)
    found: list[Group] = []
    for kind in ("spare", "end", "limit", "life", "plateau"):
        own = [moment for moment in moments if moment.kind == kind]
        before = last_chance(plays, own) if own and kind in ("life", "end", "spare") else 0
        clusters = _clusters(plays, own, before, comparison) if own else []
        parts = [_group(plays, one, len(own), before, comparison, longest) for one in clusters]
        found += sorted(parts, key=lambda group: (not group.facts, -len(group.moments)))
    ends = sorted((one for one in found if one.kind in _ENDS), key=lambda group: -group.games)
    return (*ends, *(one for one in found if one.kind not in _ENDS))


def _clusters(plays: Plays, moments: Sequence[Moment], before: int, comparison: Comparison) -> list[Sequence[Moment]]:
    """Moments of one kind in at most three parts, each with a fact that the next ones lack; the last is the rest."""
    parts: list[Sequence[Moment]] = []
    rest = moments
    while len(parts) < _MOST_CLUSTERS - 1:
        holds = comparison.cluster(_earlier(rest, before), _low_score(plays, rest))
        if holds is None:
            break
        within, without = (
            [one for one, so in zip(rest, holds, strict=True) if so == wanted] for wanted in (True, False)
        )
        if min(len(within), len(without)) < _LEAST_CLUSTER * len(moments):
            break
        parts.append(within)
        rest = without
    return [*parts, rest]


def _earlier(moments: Sequence[Moment], steps: int) -> list[Moment]:
    return [Moment(one.play, one.step - steps, one.kind) for one in moments]


def _low_score(plays: Plays, moments: Sequence[Moment]) -> float:
    low, _ = _range_of_most([_score_at(plays[one.play], one) for one in moments], 0.9)
    return float(low)


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
        own: list[tuple[int, Kind]] = [(step, "life") for step in _lost_lives(play)]
        own += [(start + threshold, "plateau") for start, end in _stretches(play) if end - start > threshold]
        own.append((len(play) - 1, "limit" if play.truncated else "spare" if spare else "end"))
        found += [Moment(number, step, kind) for step, kind in sorted(own)]
    return tuple(found)


def unusual_steps(plays: Plays) -> int:
    """The number of steps from which on a stretch without a reward and a lost life is unusual in these games.

    It is five times what 95 % of the stretches between two such events do not exceed, at least 100, and 250 steps in
    games with few rewards.
    """
    # The stretches at the ends of games are cut short, or those that are to be found.
    lengths = [end - start for play in plays for start, end in _stretches(play)[:-1]]
    return max(100, round(5 * float(np.quantile(lengths, 0.95)))) if len(lengths) >= 20 else 250


def _stretches(play: Play) -> list[tuple[int, int]]:
    """The steps of the events of a game, which are rewards and lost lives, in pairs of one and the next.

    The beginning counts as step -1, the end as one more than the last step.
    """
    events = np.flatnonzero((play.rewards != 0) | (play.lives < play.lives_before)).tolist()
    return list(zip([-1, *events], [*events, len(play)], strict=True))


def _lost_lives(play: Play) -> list[int]:
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
    if len(before) == 1 and all(len(_lost_lives(plays[index])) >= 2 for index in ended):
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


def _group(
    plays: Plays, moments: Sequence[Moment], of_moments: int, before: int, comparison: Comparison, longest: int
) -> Group:
    kind = moments[0].kind
    scores = [_score_at(plays[moment.play], moment) for moment in moments]
    low, high = _range_of_most(scores)
    losses = _losses(plays, moments) if kind == "end" else None
    waits = kind not in ("plateau", "limit") and losses is None  # the others say for how long there is no reward
    return Group(
        kind,
        tuple(moments),
        of_moments,
        len({moment.play for moment in moments}),
        len(plays),
        float(np.median(scores)),
        low,
        high,
        before,
        facts=comparison.facts(_earlier(moments, before), _low_score(plays, moments), waits=waits),
        losses=losses,
        lives=_lives_left(plays, moments) if kind == "spare" else (),
        steps=_lengths(plays, moments, longest) if kind == "plateau" else None,
    )


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
    lost = [one for one in _lost_lives(play) if one < step]
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


def _score_at(play: Play, moment: Moment) -> float:
    return play.score if moment.kind in _ENDS else float(play.totals[moment.step])


def _range_of_most(values: Sequence[float], part: float = 0.8) -> tuple[Any, Any]:
    """The shortest range that has at least this part of the values."""
    ordered = np.sort(np.asarray(values))
    within = int(np.ceil(part * len(ordered)))
    first = int((ordered[within - 1 :] - ordered[: len(ordered) - within + 1]).argmin())
    return ordered[first].item(), ordered[first + within - 1].item()


def _losses(plays: Plays, moments: Sequence[Moment]) -> Losses | None:
    rows = []
    for moment in moments:
        play = plays[moment.play]
        lost = [*_lost_lives(play), len(play) - 1]
        score = int(play.totals[lost[0]])
        steps, gained = len(play) - 1 - lost[0], int(play.totals[-1]) - score
        if len(lost) > 1 and 3 * steps <= len(play) and gained <= 0.1 * abs(score):
            rows.append((len(lost), steps, score, gained))
    if 2 * len(rows) < len(moments):
        return None
    lives, *columns = zip(*rows, strict=True)
    steps_, scores, gains = (_range_of_most(column) for column in columns)
    return Losses(len(rows), max(lives), steps_, scores, gains)


def _lives_left(plays: Plays, moments: Sequence[Moment]) -> tuple[tuple[int, int], ...]:
    count = Counter(int(plays[moment.play].lives_before[-1]) for moment in moments)
    return tuple(sorted(count.items(), reverse=True))


def _lengths(plays: Plays, moments: Sequence[Moment], longest: int) -> tuple[int, int]:
    chosen = {(moment.play, moment.step - longest) for moment in moments}
    lengths = [
        end - start for number, play in enumerate(plays) for start, end in _stretches(play) if (number, start) in chosen
    ]
    return min(lengths), max(lengths)


def words(group: Group, game: Game) -> str:
    """A group in one sentence.

    Args:
        group: the group, see `groups`.
        game: the game's definition, whose labels the facts name.

    Example:
        >>> import atari
        >>> from atari.learning.diagnosis.facts import Fact
        >>> from atari.learning.diagnosis.moments import Group, words
        >>> facts = (Fact("invaders_left_count", 1, 3, there=0.75, elsewhere=0.175),)
        >>> group = Group("end", (), 62, 62, 100, 1175, 570, 1435, before=28, facts=facts)
        >>> for part in words(group, atari.games["space_invaders"]).split("; 28"):
        ...     print(part)
        62 of 100 games end with the last life, at 1,175 points (median; 80 % of them at 570 to 1,435)
         steps before, invaders_left_count is 1 to 3 in 75 % (elsewhere in 18 %).
    """
    parts = [f"{_subject(group, game)}{_scores(group)}"]
    if group.losses is not None:
        parts.append(_in_words(group.losses))
    if group.facts:
        when = f"{group.before} step{'s' * (group.before > 1)} before, " if group.before else "then, "
        parts.append(when + ", ".join(_explained(fact, game) for fact in group.facts))
    return "; ".join(parts) + "."


def _subject(group: Group, game: Game) -> str:
    games = f"{group.games} of {group.of_games} games"
    count = len(group.moments)
    if group.kind == "limit":
        return f"{games} reach the limit of frames"
    if group.kind == "plateau":
        low, high = group.steps or (0, 0)
        times = f", {count} times in all" if count > group.games else ""
        return f"{games} have no reward for {_numbers(low, high)} steps{times}"
    if group.kind == "life":
        if count == group.of_moments:
            return f"{count} lives before the last one are lost, in {games}"
        how = "like this" if group.facts else "otherwise"
        return f"{count} of {group.of_moments} lives before the last one are lost {how}, in {games}"
    if group.kind == "spare":
        lives = [f"{count} with {lives} {'lives' if lives != 1 else 'life'}" for lives, count in group.lives]
        return f"{games} end although the last life is not lost ({', '.join(lives)})"
    return f"{games} end" + (" with the last life" if game.rules and game.rules.lives_initial else "")


def _scores(group: Group) -> str:
    """The scores of a group's moments in words."""
    if group.low == group.high == group.median:
        return f", most at {_number(group.median)} points"
    return f", at {_number(group.median)} points (median; 80 % of them at {_numbers(group.low, group.high)})"


def _in_words(losses: Losses) -> str:
    return (
        f"in {losses.games} of them no life is lost before {_numbers(*losses.scores)} points, and then all "
        f"{losses.lives} within {_numbers(*losses.steps)} steps, for {_numbers(*losses.gained)} points"
    )


def _explained(fact: Fact, game: Game) -> str:
    """A fact in words, with the note that the game's definition has for a label."""
    label = game.ram_labels.get(fact.name)
    note = label.note if label is not None else None
    if not note or any(source in note for source in ("OCAtari", "AtariARI", "byte")):
        return str(fact)
    return str(fact).replace(fact.name, f"{fact.name} ({note})", 1)


def _numbers(low: float, high: float) -> str:
    return _number(low) if low == high else f"{_number(low)} to {_number(high)}"


def _number(value: float) -> str:
    return f"{value:,.0f}" if value == round(value) else f"{value:,.1f}"
