"""`check` proves the effect of an intervention by playing the same frames with it and without it."""

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.cores import NativeCore
from atari.games.actions import Action
from atari.games.game import Game
from atari.games.interventions import Check, Intervention, resolve
from atari.games.interventions.file import CHECK_NAMES, split_calls
from atari.games.interventions.writes import parse_expression
from atari.lab.interventions.series import Series, evaluate_series
from atari.task import Task
from atari.task.task import GameLike, resolve_frames

_FRAMES_PER_ACTION = 4
"""Frames that a random action is held."""


@dataclass(frozen=True)
class CheckResult:
    """The evidence of a check.

    Attributes:
        task: the task that was played without the intervention.
        name: the intervention's name.
        passed: whether its effect was seen.
        kind: "holds", "more" or "less".
        expression: the expression that was measured.
        with_it, without: the share of the frames on which the expression is true, for "holds"; else its mean.
        first_failure: for "holds", the first frame on which the expression is false with the intervention, or None.
    """

    task: Task
    name: str
    passed: bool
    kind: str
    expression: str
    with_it: float
    without: float
    first_failure: int | None = None

    @property
    def game(self) -> str:
        """The id of the game."""
        return self.task.game

    def __bool__(self) -> bool:
        return self.passed

    def __str__(self) -> str:
        what = "true on" if self.kind == "holds" else "mean of"
        form = ".1%" if self.kind == "holds" else ".4g"
        failed = "" if self.first_failure is None else f"; first false at frame {self.first_failure}"
        return (
            f"{self.game} {self.name}: {'passed' if self.passed else 'FAILED'}: {what} {self.expression!r} "
            f"{self.with_it:{form}} with it, {self.without:{form}} without{failed}"
        )


def check(
    game: GameLike,
    name: str | Mapping[str, Any] | Intervention,
    *,
    mode: int | None = None,
    difficulty: int | None = None,
) -> CheckResult:
    """Play the check of an intervention.

    Args:
        game: an ID, a game's name, the path of a game file, a `Game` or an `atari.Task`. Only its mode and its
            difficulty count: frames are played one by one, without sticky actions.
        name: an intervention of the game, as an item of the option `interventions`.
        mode, difficulty: the game's mode and difficulty; None takes them from `game`.

    Returns:
        A `CheckResult`, which is true if the check has passed. It prints in one line, and has `task`, `name`, `passed`,
        `kind` ("holds", "more" or "less"), `expression`, `with_it` and `without`: for "holds" the share of frames on
        which the expression is true, else its mean. `first_failure` is the first frame on which "holds" failed, or
        None.

    Raises:
        TypeError, ValueError: there is no such intervention, or it has no check; as `Task.of`, or the task has another
            field that changes the game.

    Example:
        >>> from atari.lab.interventions import check
        >>> result = check("pong", "lazy_enemy")
        >>> result.passed, result.expression
        (True, 'enemy_y == first(enemy_y)')
    """
    task = resolve_frames(game, mode, difficulty, owner="check")
    found = task.definition
    (intervention,) = resolve(found, [name])
    if intervention.check is None:
        raise ValueError(f"the intervention {intervention.name!r} of {found.id} has no check")
    plan = intervention.check
    without = _play(task, (), plan)
    with_it = _play(task, (intervention,), plan, without.screens)
    values = [_values(found, run, plan)[plan.after :] for run in (with_it, without)]
    facts = (task, intervention.name)
    if plan.kind == "holds":
        held, held_without = (series != 0 for series in values)
        failures = np.flatnonzero(~held)
        passed = bool(held.all() and not held_without.all())
        first = int(failures[0]) + plan.after + 1 if failures.size else None
        shares = float(held.mean()), float(held_without.mean())
        return CheckResult(*facts, passed, plan.kind, plan.expression, *shares, first)
    mean, mean_without = (float(series.mean()) for series in values)
    low, high = (mean_without, mean) if plan.kind == "more" else (mean, mean_without)
    passed = high > low and high - low >= (plan.by - 1) * abs(low)
    return CheckResult(*facts, passed, plan.kind, plan.expression, mean, mean_without)


@dataclass(frozen=True)
class _Measurements:
    """The results of playing: (frames, 128) RAM, screens, and the series of reward, lives and pixels."""

    ram: npt.NDArray[np.uint8]
    screens: list[npt.NDArray[np.uint8]]
    numbers: dict[str, Series]


def _play(
    task: Task,
    interventions: tuple[Intervention, ...],
    plan: Check,
    others: list[npt.NDArray[np.uint8]] | None = None,
) -> _Measurements:
    """Play the frames of a check; `others` are the screens without the intervention. A game that ends begins again."""
    game = task.definition
    chosen: dict[str, Any] = {"mode": task.set_mode, "difficulty": task.set_difficulty}
    core = NativeCore(game, seed=0, repeat_action_probability=0.0, interventions=interventions, **chosen)
    core.reset()
    screens, rams, rewards, lives, pixels = [], [], [], [], []
    score = 0
    needs_pixels = "pixels" in plan.expression
    for frame, action in zip(range(plan.frames), _actions(game, plan), strict=False):
        score += core.act(action)
        rams.append(core.ram())
        rewards.append(score)
        lives.append(core.lives)
        if needs_pixels:
            screens.append(core.screen())
        pixels.append(int((screens[-1] != others[frame]).sum()) if needs_pixels and others else 0)
        if core.game_over:
            core.reset()
    core.close()
    numbers = {"reward": rewards, "lives": lives, "frame": range(1, plan.frames + 1), "pixels": pixels}
    return _Measurements(
        np.array(rams), screens, {name: np.array(series, np.int64) for name, series in numbers.items()}
    )


def _actions(game: Game, plan: Check) -> Iterator[int]:
    if plan.actions == "noop":
        return itertools.repeat(0)
    if plan.actions == "random":
        choices = [int(action) for action in game.minimal_actions]
        generator = np.random.default_rng(0)
        drawn = generator.choice(choices, -(-plan.frames // _FRAMES_PER_ACTION))
        return iter(np.repeat(drawn, _FRAMES_PER_ACTION).tolist())
    return itertools.cycle(int(Action[name]) for name in plan.actions)


def _values(game: Game, run: _Measurements, plan: Check) -> Series:
    """The value of the check's expression after each frame."""
    split = split_calls(plan.expression, game, "check")
    names = {name: series for name, series in run.numbers.items() if name not in game.ram_labels}
    for name, (function, label) in split.calls.items():
        series = evaluate_series(parse_expression(game, label, (), "check"), run.ram, {})
        changed = np.concatenate([[0], np.cumsum(series[1:] != series[:-1])])
        names[name] = np.full_like(series, series[0]) if function == "first" else changed
    known = [name for name in CHECK_NAMES if name in names]
    return evaluate_series(parse_expression(game, split.source, (*known, *split.calls), "check"), run.ram, names)
