"""Findings from a policy's answers to changed observations: when it reacts, and which objects it does not see."""

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.games.objects import positions
from atari.learning.diagnosis.findings import Finding, Step, losses, percent, spread
from atari.learning.diagnosis.plays import Plays
from atari.learning.diagnosis.reach import player_axes

_GAMES, _STEPS, _IMPULSES = 6, 80, 32
_LEAST_ANSWERS, _LEAST_PART = 4, 0.02
_BEFORE_LOSS, _NEAR = 16, 48
_LEAST_NEAR, _LEAST_MOMENTS, _MOST_OBSERVATIONS = 0.15, 5, 400
_LEAST_OBSERVATIONS, _LEAST_SEEN = 100, 0.02
_ROUNDING = 1e-5
_SIZE, _MARGIN = (8, 10), 2
"""Pixels of an object whose size is not known, and pixels around an object that are painted, too."""

Array = npt.NDArray[Any]
Bools = npt.NDArray[np.bool_]


def delayed_actions(plays: Plays) -> Finding | None:
    """The number of steps after which the policy reacts to an observation, if it is not 0, or the task delays actions.

    Stretches of observations are given to the policy again, in several lanes with the same seeds; in each lane but the
    first another observation takes the place of one of them. The delay is the smallest number of steps after which the
    actions of at least 2 % of the lanes, and of 4, differ for the first time.

    Args:
        plays: the games, see `play_games`.

    Example:
        >>> from atari import Task
        >>> from atari.learning import load_policy
        >>> from atari.learning.diagnosis.plays import play_games
        >>> from atari.learning.diagnosis.senses import delayed_actions
        >>> task = Task.of("breakout", action_delay=8)
        >>> print(delayed_actions(play_games(load_policy("random"), task, games=1, seed=0)))
        The task delays each action by 8 frames (action_delay).
    """
    given = plays.task.action_delay
    if given not in (0, (0, 0)):
        frames = f"{given} frames" if isinstance(given, int) else f"{given[0]} to {given[1]} frames, drawn in each game"
        number = given if isinstance(given, int) else given[1]
        text = f"The task delays each action by {frames} (action_delay)."
        return Finding("delayed actions", f"{number} frames", number, 1.0, text, ("--action-delay 0", "--stack-num 4"))
    answers = _answers(plays)
    lags, counts = np.unique(answers[answers >= 0], return_counts=True)
    clear = lags[counts >= max(_LEAST_ANSWERS, _LEAST_PART * len(answers))]
    if not len(clear) or clear[0] == 0:
        return None
    delay, answered = int(clear[0]), int(counts[lags == clear[0]][0])
    text = (
        f"The policy answers {delay} steps late: of {len(answers):,} observations that were replaced by another one, "
        f"{answered:,} changed its action {delay} steps later, and {int((answers == 0).sum()):,} at once."
    )
    options = ("--stack-num 4",)
    return Finding("delayed actions", f"{delay} step{'s' * (delay > 1)}", delay, answered / len(answers), text, options)


def _answers(plays: Plays) -> npt.NDArray[np.int64]:
    """For each impulse, the steps until the first other action; -1 if there is none, or one before the impulse."""
    rng = np.random.default_rng(plays.seed)
    games = [number for number, play in enumerate(plays) if len(play) >= 16][:_GAMES]
    if not games:
        return np.empty(0, np.int64)
    length = min(_STEPS, min(len(plays[number]) for number in games))
    streams = [_first_observations(plays, number, length) for number in games]
    found: list[int] = []
    for number, stream in zip(games, streams, strict=True):
        lanes = np.arange(_IMPULSES + 1)
        # Impulses are early enough for a late answer to be seen.
        when = np.append(-1, rng.integers(length // 2, size=_IMPULSES))
        _begin(plays, lanes, plays[number].seed)
        chosen = np.empty((length, len(lanes)), np.int64)
        for step in range(length):
            batch = np.repeat(stream[step : step + 1], len(lanes), 0)
            for lane in np.flatnonzero(when == step).tolist():
                other = streams[rng.integers(len(streams))]
                batch[lane] = _far_from(stream[step], other, rng)
            if step and step - 1 in plays[number].resets:
                plays.player.begin_episodes(lanes)
            chosen[step] = plays.policy(batch, lanes)
        changed = chosen[:, 1:] != chosen[:, :1]
        first = np.where(changed.any(0), changed.argmax(0), -1)
        lag = np.where(first >= 0, first - when[1:], -1)
        found += np.maximum(lag, -1).tolist()
    return np.array(found, np.int64)


def _far_from(observation: Array, others: Array, rng: np.random.Generator) -> Array:
    """Of three drawn observations and a reversed one, one that differs from an observation in most numbers."""
    drawn = [*others[rng.integers(len(others), size=3)], observation.ravel()[::-1].reshape(observation.shape)]
    return np.asarray(max(drawn, key=lambda other: int((other != observation).sum()) * rng.random()))


def _begin(plays: Plays, lanes: npt.NDArray[np.int64], seed: int) -> None:
    """Begin games of the policy, all with the same draws."""
    plays.player.begin(lanes, np.full(len(lanes), seed, np.int64))


def _first_observations(plays: Plays, number: int, length: int) -> Array:
    """The observations before the first steps of a game, (length, ...)."""
    play = plays[number]
    with closing(plays.player.make(1)) as envs:
        observations, _ = envs.reset(seed=np.array([play.seed]), options={"new_game": True})
        found = [np.array(observations[0])]
        for step in range(length - 1):
            observations = envs.step(play.actions[step : step + 1].astype(np.int64))[0]
            if step in play.resets:
                observations, _ = envs.reset(seed=np.array([-1]), options={"reset_mask": np.ones(1, np.bool_)})
            found.append(np.array(observations[0]))
    return np.stack(found)


@dataclass(frozen=True)
class _Kind:
    """Objects that are alike: the names of the labels of each, x and y."""

    name: str
    objects: tuple[tuple[str, str], ...]

    def bytes_of(self, plays: Plays) -> list[int]:
        """The bytes of all positions, by index."""
        labels = plays.labels.game.ram_labels
        return sorted({labels[name].index for names in self.objects for name in names if name})


def unseen_objects(plays: Plays) -> tuple[Finding, ...]:
    """The kinds of objects near lost lives that change nothing of what the policy does.

    Objects are known by the labels of their positions. They are near if in at least 15 % of the lost lives (of the
    points in games without lives), one was within 48 pixels of the player in the last 16 steps. In 400 observations at
    most, of these steps and of others, the object is covered: its box with what is around it in images; in RAM its
    bytes with values of other steps. A finding is an object that changes neither an action nor a score beyond rounding
    in any of at least 100 observations. Nothing is said if another observation as a whole changes nothing in 98 %.

    Args:
        plays: the games, see `play_games`.

    Example:
        >>> from atari import Task
        >>> from atari.learning import load_policy
        >>> from atari.learning.diagnosis.plays import play_games
        >>> from atari.learning.diagnosis.senses import unseen_objects
        >>> unseen_objects(play_games(load_policy("noop"), Task.of("pong", obs_type="ram"), games=1, seed=0))
        ()
    """
    near = _near(plays)
    tested = [kind for kind in _kinds(plays) if near.get(kind.name, 0.0) >= _LEAST_NEAR]
    if not tested:
        return ()
    where = _observed(plays)
    states = plays.states(where)
    with closing(plays.player.make(len(states))) as envs:
        envs.reset(seed=0)
        envs.restore(None, states)
        observations = np.array(envs.observe()[0])
    seen = {kind.name: _changes(plays, kind, where, observations) for kind in tested}
    if _changed(plays, observations, observations[::-1]).mean() < _LEAST_SEEN:
        return ()
    found = []
    for kind in tested:
        part, count = seen[kind.name]
        if part == 0 and count >= _LEAST_OBSERVATIONS:
            text = (
                f"The policy does not see {_plain(kind.name)}: covering it in {count:,} observations changed no "
                f"action, though it was near the player at {percent(near[kind.name])} of the {_what(plays)}."
            )
            options = ("--img-height 84 --img-width 84", "--stack-num 4", "--network nature")
            found.append(Finding("unseen object", kind.name, None, near[kind.name], text, options))
    return tuple(sorted(found, key=lambda finding: -finding.share))


def _plain(name: str) -> str:
    return name.replace("_", " ")


def _what(plays: Plays) -> str:
    return "lost lives" if any((play.lives < play.lives_before).any() for play in plays) else "points"


def _kinds(plays: Plays) -> tuple[_Kind, ...]:
    """The kinds of objects but the player and what belongs to it."""
    own = {axis.label for axis in player_axes(plays)}
    grouped: defaultdict[str, list[tuple[str, str]]] = defaultdict(list)
    for name, axes in positions(plays.labels.game.ram_labels).items():
        names = tuple(axes[axis].name if axis in axes else "" for axis in ("x", "y"))
        grouped[re.sub(r"_?\d+", "", name) or name].append((names[0], names[1]))
    # A second player's object, which stands still, has the name of the player's; its shots do no harm.
    mine = [name for name, objects in grouped.items() if any(own.intersection(names) for names in objects)]
    return tuple(
        _Kind(name, tuple(objects))
        for name, objects in grouped.items()
        if not any(name == one or name.startswith(f"{one}_") for one in mine)
    )


def _near(plays: Plays) -> dict[str, float]:
    """For each kind of objects, the part of the lost lives or points before which one was near the player."""
    axes = {axis.low: axis.label for axis in player_axes(plays)}
    own = axes.get("left", ""), axes.get("top", "")
    kinds = _kinds(plays)
    if not any(own):
        return {}
    total, counts = 0, dict.fromkeys((kind.name for kind in kinds), 0)
    for play in plays:
        moments = losses(play)
        if not len(moments):
            continue
        around = np.clip(moments[:, None] - np.arange(_BEFORE_LOSS), 0, None)
        values = _values(plays, play.rams[around.ravel()])
        total += len(moments)
        for kind in kinds:
            near = np.zeros(around.size, np.bool_)
            for names in kind.objects:
                near |= _is_near(values, own, names)
            counts[kind.name] += int(near.reshape(around.shape).any(1).sum())
    if total < _LEAST_MOMENTS:
        return {}
    return {name: count / total for name, count in counts.items()}


_Values = Mapping[str, tuple[npt.NDArray[np.int32], Bools]]


def _values(plays: Plays, rams: npt.NDArray[np.uint8]) -> _Values:
    """The values of all labels, and where they are visible, by name."""
    values, visible = plays.labels.evaluate(rams)
    return {name: (values[number], visible[number]) for number, name in enumerate(plays.labels.names)}


def _is_near(values: _Values, own: tuple[str, str], names: tuple[str, str]) -> Bools:
    """Where an object is visible and near the player, on the axes that both have."""
    visible = [values[name][1] for name in names if name]
    near: Bools = np.logical_and.reduce(visible)
    both = [(mine, other) for mine, other in zip(own, names, strict=True) if mine and other]
    for mine, other in both:
        near = near & (np.abs(values[mine][0] - values[other][0]) <= _NEAR)
    return near if both else np.zeros_like(near)


def _observed(plays: Plays) -> list[Step]:
    """The steps whose observations are tried: half of them before lost lives or points, half of all others."""
    rng = np.random.default_rng(plays.seed)
    before = sorted(
        {
            Step(number, int(step) - back)
            for number, play in enumerate(plays)
            for step in losses(play)
            for back in range(1, _BEFORE_LOSS)
            if int(step) - back >= 4 and int(step) - back not in play.resets
        }
    )
    half = _MOST_OBSERVATIONS // 2
    chosen = [before[index] for index in rng.permutation(len(before))[:half].tolist()]
    others = [one for one in spread(plays, half, plays.seed) if one.step not in plays[one.play].resets]
    return sorted({*chosen, *others})


def _changes(plays: Plays, kind: _Kind, where: Sequence[Step], observations: Array) -> tuple[float, int]:
    """The part of the observations in which covering all objects of a kind changes an answer, and their number."""
    seen = plays.task.kind
    if not seen.image:
        covered = _other_bytes(plays, kind, observations)
    elif not seen.colours and not seen.is_dict and observations.ndim == 4:
        covered = _painted(plays, kind, where, observations)
    else:
        return 0.0, 0
    rows = np.flatnonzero((covered != observations).reshape(len(covered), -1).any(1))
    if not len(rows):
        return 0.0, 0
    return float(_changed(plays, observations[rows], covered[rows]).mean()), len(rows)


def _changed(plays: Plays, observations: Array, others: Array) -> Bools:
    """Where an action, or a score beyond rounding, differs between observations, (n,)."""
    first, scores = _asked(plays, observations)
    second, other_scores = _asked(plays, others)
    changed: Bools = first != second
    if scores is not None and other_scores is not None:
        with np.errstate(invalid="ignore"):
            off = np.abs(scores - other_scores) > _ROUNDING * np.maximum(1, np.abs(scores))
        changed |= (off & np.isfinite(scores) & np.isfinite(other_scores)).any(1)
    return changed


def _asked(plays: Plays, observations: Array) -> tuple[Array, Array | None]:
    """The actions and the scores for observations, each as the first one of a game with the same draws."""
    lanes = np.arange(len(observations))
    _begin(plays, lanes, plays.seed)
    actions = plays.policy(np.ascontiguousarray(observations), lanes)
    scores = plays.policy.last_scores
    return actions, None if scores is None else np.array(scores)


def _other_bytes(plays: Plays, kind: _Kind, observations: Array) -> Array:
    """RAM observations (n, ..., 128) in which the bytes of a kind's positions have the values of another observation.

    A byte that is the same in all observations gets another value.
    """
    rng = np.random.default_rng(plays.seed)
    covered = observations.copy()
    other = observations[rng.permutation(len(observations))]
    for index in kind.bytes_of(plays):
        covered[..., index] = np.where(
            other[..., index] != observations[..., index], other[..., index], observations[..., index] ^ 0x28
        )
    return covered


def _painted(plays: Plays, kind: _Kind, where: Sequence[Step], observations: Array) -> Array:
    """Images (n, stack, height, width) in which the boxes of a kind's objects are painted with what is around them.

    An image stays as it is if the box has a part of another object, because the policy could answer to that object.
    """
    covered = observations.copy()
    stack = observations.shape[1]
    alone = np.ones(len(observations), np.bool_)
    for back in range(stack):
        # Screens overlap: an image may be the maximum of the last two frames of a step.
        rams = np.stack([plays[one.play].rams[max(one.step - back, 0)] for one in where])
        values = _values(plays, rams)
        for names in kind.objects:
            if not all(names):
                continue
            shown = np.logical_and(values[names[0]][1], values[names[1]][1])
            alone &= ~(shown & _is_beside_others(plays, kind, values, names))
            for row in np.flatnonzero(shown).tolist():
                place = int(values[names[0]][0][row]), int(values[names[1]][0][row])
                _paint(covered[row, stack - 1 - back], place, _size(plays, names), plays.task.definition.screen.height)
    covered[~alone] = observations[~alone]
    return covered


def _is_beside_others(plays: Plays, kind: _Kind, values: _Values, names: tuple[str, str]) -> Bools:
    """Where an object of a kind is so near another object that painting it could touch that one.

    An object with one known axis can be anywhere on the other axis.
    """
    beside = np.zeros(len(values[names[0]][0]), np.bool_)
    for axes in positions(plays.labels.game.ram_labels).values():
        others = (axes["x"].name if "x" in axes else "", axes["y"].name if "y" in axes else "")
        if others in kind.objects:
            continue
        near = np.logical_and.reduce([values[name][1] for name in others if name])
        for own, other, size, other_size in zip(names, others, _size(plays, names), _size(plays, others), strict=True):
            if other:
                way = values[other][0] - values[own][0]
                near &= (way <= size + 2 * _MARGIN) & (way >= -other_size - 2 * _MARGIN)
        beside |= near
    return beside


def _size(plays: Plays, names: tuple[str, str]) -> tuple[int, int]:
    labels = [plays.labels.game.ram_labels[name] for name in names if name]
    width = next((label.width for label in labels if label.width), _SIZE[0])
    height = next((label.height for label in labels if label.height), _SIZE[1])
    return width, height


def _paint(image: Array, place: tuple[int, int], size: tuple[int, int], screen_height: int) -> None:
    """Paint the box of an object, and some pixels around it, with the median of its frame."""
    height, width = image.shape
    (x, y), (wide, high) = place, size
    left, right = np.clip([(x - _MARGIN) * width // 160, -(-(x + wide + _MARGIN) * width // 160)], 0, width)
    top, bottom = np.clip(
        [(y - _MARGIN) * height // screen_height, -(-(y + high + _MARGIN) * height // screen_height)], 0, height
    )
    if left >= right or top >= bottom:
        return
    around = image[max(top - 1, 0) : bottom + 1, max(left - 1, 0) : right + 1].astype(np.int16)
    inside = np.zeros(around.shape, np.bool_)
    inside[min(top, 1) : min(top, 1) + bottom - top, min(left, 1) : min(left, 1) + right - left] = True
    frame = around[~inside]
    if len(frame):
        image[top:bottom, left:right] = np.uint8(np.median(frame))
