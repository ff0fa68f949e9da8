"""`groups`: what is common in the moments at which games end, lose a life or stop to score, in numbers and words."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from atari.games.game import Game
from atari.learning.diagnosis.facts import Comparison, Fact
from atari.learning.diagnosis.moments import Kind, Moment, last_chance, lost_lives, moments_of, stretches, unusual_steps
from atari.learning.diagnosis.plays import Play, Plays

_ENDS = ("spare", "end", "limit")
_MOST_CLUSTERS, _LEAST_CLUSTER = 3, 0.15
"""The most groups of moments of one kind, and the least part of these moments in each."""


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
        >>> from atari.learning.diagnosis.groups import groups, words
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
        lost = [*lost_lives(play), len(play) - 1]
        score = int(play.totals[lost[0]])
        steps, gained = len(play) - 1 - lost[0], int(play.totals[-1]) - score
        if len(lost) > 1 and 3 * steps <= len(play) and gained <= 0.1 * abs(score):
            rows.append((len(lost), steps, score, gained))
    if 2 * len(rows) < len(moments):
        return None
    lives, *columns = zip(*rows, strict=True)
    steps_, scores, gains = (_range_of_most(column) for column in columns)
    return Losses(len(rows), max(lives), steps_, scores, gains)


def _score_at(play: Play, moment: Moment) -> float:
    return play.score if moment.kind in _ENDS else float(play.totals[moment.step])


def _lives_left(plays: Plays, moments: Sequence[Moment]) -> tuple[tuple[int, int], ...]:
    count = Counter(int(plays[moment.play].lives_before[-1]) for moment in moments)
    return tuple(sorted(count.items(), reverse=True))


def _lengths(plays: Plays, moments: Sequence[Moment], longest: int) -> tuple[int, int]:
    chosen = {(moment.play, moment.step - longest) for moment in moments}
    lengths = [
        end - start for number, play in enumerate(plays) for start, end in stretches(play) if (number, start) in chosen
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
        >>> from atari.learning.diagnosis.groups import Group, words
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
