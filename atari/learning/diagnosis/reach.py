"""Findings from forks: presses that the agent does not use though they matter, and sides to which it never goes."""

from collections.abc import Callable, Sequence
from contextlib import closing
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from atari.env.lane_snapshot import LaneSnapshot
from atari.games.actions import Action
from atari.games.objects import positions
from atari.learning.diagnosis.findings import RESTARTS, Finding, Step, percent, spread
from atari.learning.diagnosis.plays import Plays
from atari.vector import AtariVectorEnv

_LEAST_USE = 0.001
_STATES, _HELD = 40, 4
_LEAST_EFFECT = 0.25
_REACHING, _REACHING_STEPS = 24, 40
_LEAST_UNSEEN = 0.35
_MOST_BEYOND = 0.002
"""The part of all steps that may be on a side that counts as not visited."""

Presses: dict[str, Callable[[Action], bool]] = {
    "UP": lambda action: action.vertical > 0,
    "DOWN": lambda action: action.vertical < 0,
    "RIGHT": lambda action: action.horizontal > 0,
    "LEFT": lambda action: action.horizontal < 0,
    "FIRE": lambda action: action.fire,
}
"""By the name of a press, whether an action has it."""

Side = Literal["left", "right", "top", "bottom"]
_PRESS_TOWARDS: dict[Side, str] = {"left": "LEFT", "right": "RIGHT", "top": "UP", "bottom": "DOWN"}
_PLAYERS = ("player", "player_0", "figure_0", "agent", "ship", "paddle", "hero", "cannon")

Ints = npt.NDArray[np.int64]


def unused_presses(plays: Plays) -> tuple[Finding, ...]:
    """The presses that no used action has, though they do what no used action does.

    An action is used if it is at least 0.1 % of all steps. From 40 states of the plays, an action with the press and
    each used action are held for 4 steps in forks, with the same draws of sticky actions. The press matters if in a
    quarter of the states the screen then differs from the screens of all used actions.

    Args:
        plays: the games, see `play_games`.

    Example:
        >>> from atari import Task
        >>> from atari.learning import load_policy
        >>> from atari.learning.diagnosis.plays import play_games
        >>> from atari.learning.diagnosis.reach import unused_presses
        >>> task = Task.of("breakout", max_num_frames_per_episode=4000, fire="after_noops")
        >>> [finding.place for finding in unused_presses(play_games(load_policy("noop"), task, games=1, seed=0))]
        ['RIGHT', 'LEFT', 'FIRE']
    """
    if not all(isinstance(action, Action) for action in plays.task.action_set):
        return ()
    used = used_actions(plays)
    actions = plays.task.action_set
    missing = {
        press: [index for index, action in enumerate(actions) if has(action)]
        for press, has in Presses.items()
        if not any(has(actions[index]) for index in used) and any(map(has, actions))
    }
    if not missing or not used:
        return ()
    # The simplest action with the press: of the fewest other presses.
    tried = [min(own, key=lambda index: len(plays.actions[index])) for own in missing.values()]
    states = plays.states(spread(plays, _STATES, plays.seed))
    different = _different(plays, states, used, tried)
    steps = sum(map(len, plays))
    found = []
    for press, part in zip(missing, different, strict=True):
        if part < _LEAST_EFFECT:
            continue
        takes = sum(int(np.isin(play.actions, missing[press]).sum()) for play in plays)
        text = (
            f"The agent does not use {press}: {takes:,} of {steps:,} steps press it. In {percent(part)} of "
            f"{len(states)} states, holding it for {_HELD} steps leads to a screen that no action it uses leads to."
        )
        found.append(Finding("unused action", press, None, part, text, ("--entropy 0.02", "--exploration 0.2")))
    return tuple(found)


def used_actions(plays: Plays) -> list[int]:
    """The indices of the actions that are at least 0.1 % of all steps."""
    counts = np.bincount(np.concatenate([play.actions for play in plays]), minlength=len(plays.actions))
    return np.flatnonzero(counts >= max(1, _LEAST_USE * counts.sum())).tolist()


def _different(plays: Plays, states: Sequence[LaneSnapshot], used: Sequence[int], tried: Sequence[int]) -> list[float]:
    """For each tried action, the part of the states in which holding it gives a screen that no used action gives."""
    actions = np.array([*used, *tried])
    count = len(used)
    different = np.zeros((len(states), len(tried)), np.bool_)
    with closing(plays.player.make(len(actions))) as envs:
        envs.reset(seed=0)
        for row, state in enumerate(states):
            screens = _held(envs, state, actions)
            different[row] = [
                all(not np.array_equal(screens[count + index], screen) for screen in screens[:count])
                for index in range(len(tried))
            ]
    return different.mean(0).tolist()


def _held(envs: AtariVectorEnv, state: LaneSnapshot, actions: Ints) -> list[npt.NDArray[np.uint8]]:
    """The screens after each action is held from a state, with the same draws."""
    envs.restore(None, [state] * len(actions))
    for _ in range(_HELD):
        envs.step(actions)
    return [lane.screen_rgb() for lane in envs.lanes]


class Axis(NamedTuple):
    """A coordinate of the player's object: its label, and the sides to which it goes down and up."""

    label: str
    low: Side
    high: Side


def player_axes(plays: Plays) -> tuple[Axis, ...]:
    """The coordinates of the player's object; none if no object has a name such as "player"."""
    found = positions(plays.labels.game.ram_labels)
    name = next((name for name in _PLAYERS if name in found), None)
    if name is None:
        return ()
    sides: dict[str, tuple[Side, Side]] = {"x": ("left", "right"), "y": ("top", "bottom")}
    return tuple(Axis(label.name, *sides[axis]) for axis, label in sorted(found[name].items()))


def sides_not_visited(plays: Plays) -> tuple[Finding, ...]:
    """The sides of the screen to which the player's object never goes though it can.

    From the visited states that are nearest to a side, forks hold the direction to it for 40 steps, half of them with
    other directions between. A finding is a side where at least 35 % of the range of visited and reached positions is
    not visited (in at most 0.2 % of the steps).

    Args:
        plays: the games, see `play_games`.

    Example:
        >>> from atari import Task
        >>> from atari.learning import load_policy
        >>> from atari.learning.diagnosis.plays import play_games
        >>> from atari.learning.diagnosis.reach import sides_not_visited
        >>> plays = play_games(load_policy(lambda observations: [3] * len(observations)), Task.of("breakout"), 1, 0)
        >>> [finding.place for finding in sides_not_visited(plays)]
        ['right']
    """
    found = []
    for axis in player_axes(plays):
        values, where = _visited(plays, axis)
        if len(values) < 100:
            continue
        low, high = np.quantile(values, [_MOST_BEYOND, 1 - _MOST_BEYOND], method="nearest").tolist()
        reached = {
            axis.low: low - min(low, _reached(plays, axis.label, values, where, axis.low)),
            axis.high: max(high, _reached(plays, axis.label, values, where, axis.high)) - high,
        }
        whole = high - low + sum(reached.values())
        for side, beyond in reached.items():
            if whole >= 16 and beyond >= _LEAST_UNSEEN * whole:
                end = low - beyond if side == axis.low else high + beyond
                text = (
                    f"The agent never goes to the {side}: {axis.label} is {low} to {high} in its games, and "
                    f"{end} can be reached, so {percent(beyond / whole)} of the range is not visited."
                )
                options = ("--entropy 0.02", "--exploration 0.2", RESTARTS)
                found.append(Finding("side not visited", side, None, beyond / whole, text, options))
    return tuple(sorted(found, key=lambda finding: -finding.share))


def _visited(plays: Plays, axis: Axis) -> tuple[Ints, list[Step]]:
    """The values of a label in all steps where it is visible, and these steps."""
    values: list[Ints] = []
    where: list[Step] = []
    number = plays.labels.names.index(axis.label)
    for game, play in enumerate(plays):
        own, visible = plays.labels.evaluate(play.rams)
        steps = np.flatnonzero(visible[number])
        values.append(own[number, steps].astype(np.int64))
        where += [Step(game, step) for step in steps.tolist()]
    return np.concatenate(values), where


def _reached(plays: Plays, label: str, values: Ints, where: Sequence[Step], side: Side) -> int:
    """The farthest position to a side that at least a twelfth of the forks reach."""
    sign = -1 if side in ("left", "top") else 1
    chosen = _nearest(values * sign, where)
    has = Presses[_PRESS_TOWARDS[side]]
    towards = [index for index, action in enumerate(plays.task.action_set) if has(action)]
    if not towards or not chosen:
        return int(values.min() if sign < 0 else values.max())
    held = min(towards, key=lambda index: len(plays.actions[index]))
    lanes = np.repeat(np.arange(len(chosen)), 2)
    number = plays.labels.names.index(label)
    rng = np.random.default_rng(plays.seed)
    far = np.full(len(lanes), -(10**6))
    states = plays.states(chosen)
    with closing(plays.player.make(len(lanes))) as envs:
        envs.reset(seed=0)
        envs.restore(None, [states[lane] for lane in lanes])
        lives = envs.observe()[1]["lives"]
        alive = np.ones(len(lanes), np.bool_)
        actions = np.full(len(lanes), held)
        for step in range(_REACHING_STEPS):
            if step % 4 == 0:  # every second lane plays another action at times, to get around things in the way
                actions[1::2] = np.where(
                    rng.random(len(chosen)) < 0.6, held, rng.integers(len(plays.actions), size=len(chosen))
                )
            _, _, terminated, truncated, info = envs.step(actions)
            alive &= ~(terminated | truncated) & (info["lives"] == lives)
            own, visible = plays.labels.evaluate(envs.ram())
            seen = alive & visible[number]
            far[seen] = np.maximum(far[seen], own[number, seen] * sign)
    return int(np.sort(far)[-max(2, len(far) // 12)]) * sign


def _nearest(values: Ints, where: Sequence[Step]) -> list[Step]:
    """The steps with the highest values, at most 24, at least 30 steps apart."""
    chosen: list[Step] = []
    for index in np.argsort(-values, kind="stable")[: len(values) // 4 + 1].tolist():
        one = where[index]
        if all(one.play != other.play or abs(one.step - other.step) >= 30 for other in chosen):
            chosen.append(one)
            if len(chosen) == _REACHING:
                break
    return chosen
