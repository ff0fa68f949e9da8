"""`check` proves the effect of an intervention by playing the same frames with it and without it."""

import ast
import itertools
import operator
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.cores import NativeCore
from atari.games.actions import Action
from atari.games.game import Game
from atari.games.interventions import Check, Intervention, resolve
from atari.games.interventions.file import CHECK_NAMES, split_calls
from atari.games.interventions.writes import compile_write, parse_expression
from atari.task import Task
from atari.task.task import GameLike, resolve_frames

Series = npt.NDArray[np.int64]

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
        ram, picture: the share of the frames on which RAM that the intervention does not write differs from the run
            without it, and the share on which the picture does. A write that changes neither has no effect.
        first_failure: for "holds", the first frame on which the expression is false with the intervention, or None.
    """

    task: Task
    name: str
    passed: bool
    kind: str
    expression: str
    with_it: float
    without: float
    ram: float
    picture: float
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
        changed = (
            f"; RAM that it does not write differs on {self.ram:.1%} of the frames, the picture on {self.picture:.1%}"
        )
        return (
            f"{self.game} {self.name}: {'passed' if self.passed else 'FAILED'}: {what} {self.expression!r} "
            f"{self.with_it:{form}} with it, {self.without:{form}} without{failed}{changed}"
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
        None. `ram` and `picture` are the shares of the frames on which RAM that is not written, and the picture, differ
        from the run without it; if both are 0, the check has not passed.

    Raises:
        TypeError, ValueError: there is no such intervention, or it has no check; as `Task.of`, or the task has another
            field that changes the game.

    Example:
        >>> from atari.lab.interventions import check
        >>> result = check("pong", "lazy_enemy")
        >>> result.passed, result.expression
        (True, 'score_enemy')
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
    written = {compile_write(found, rule, intervention.name).index for rule in intervention.writes}
    rest = [place for place in range(with_it.ram.shape[1]) if place not in written]
    ram = float((with_it.ram[:, rest] != without.ram[:, rest]).any(axis=1).mean())
    picture = float((with_it.pictures != without.pictures).mean())
    facts = (task, intervention.name)
    if plan.kind == "holds":
        held, held_without = (series != 0 for series in values)
        failures = np.flatnonzero(~held)
        passed = bool(held.all() and not held_without.all() and ram + picture > 0)
        first = int(failures[0]) + plan.after + 1 if failures.size else None
        shares = float(held.mean()), float(held_without.mean())
        return CheckResult(*facts, passed, plan.kind, plan.expression, *shares, ram, picture, first)
    mean, mean_without = (float(series.mean()) for series in values)
    low, high = (mean_without, mean) if plan.kind == "more" else (mean, mean_without)
    passed = high > low and high - low >= (plan.by - 1) * abs(low) and ram + picture > 0
    return CheckResult(*facts, passed, plan.kind, plan.expression, mean, mean_without, ram, picture)


@dataclass(frozen=True)
class _Measurements:
    """The results of playing: (frames, 128) RAM, check sums of pictures, screens, and series of numbers by name."""

    ram: npt.NDArray[np.uint8]
    pictures: Series
    screens: list[npt.NDArray[np.uint8]]
    numbers: dict[str, Series]


def _play(
    task: Task, interventions: tuple[Intervention, ...], plan: Check, others: list[npt.NDArray[np.uint8]] | None = None
) -> _Measurements:
    """Play the frames of a check; `others` are the screens without the intervention. A game that ends begins again."""
    game = task.definition
    chosen: dict[str, Any] = {"mode": task.set_mode, "difficulty": task.set_difficulty}
    core = NativeCore(game, seed=0, repeat_action_probability=0.0, interventions=interventions, **chosen)
    core.reset()
    screens, pictures, rams, rewards, lives, pixels = [], [], [], [], [], []
    score = 0
    needs_pixels = "pixels" in plan.expression
    for frame, action in zip(range(plan.frames), _actions(game, plan), strict=False):
        score += core.act(action)
        rams.append(core.ram())
        rewards.append(score)
        lives.append(core.lives)
        screen = core.screen()
        pictures.append(zlib.crc32(screen.tobytes()))
        if needs_pixels:
            screens.append(screen)
        pixels.append(int((screens[-1] != others[frame]).sum()) if needs_pixels and others else 0)
        if core.game_over:
            core.reset()
    core.close()
    numbers = {"reward": rewards, "lives": lives, "frame": range(1, plan.frames + 1), "pixels": pixels}
    series = {name: np.array(values, np.int64) for name, values in numbers.items()}
    return _Measurements(np.array(rams), np.array(pictures), screens, series)


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
    source, calls = split_calls(plan.expression, game, "check")
    names = {name: series for name, series in run.numbers.items() if name not in game.ram_labels}
    for name, (function, label) in calls.items():
        series = _evaluate(parse_expression(game, label, (), "check"), run.ram, {})
        changed = np.concatenate([[0], np.cumsum(series[1:] != series[:-1])])
        names[name] = np.full_like(series, series[0]) if function == "first" else changed
    known = [name for name in CHECK_NAMES if name in names]
    return _evaluate(parse_expression(game, source, (*known, *calls), "check"), run.ram, names)


def _floor(function: Callable[[Series, Series], Series]) -> Callable[[Series, Series], Series]:
    """The division whose result for a divisor of zero or less is 0, as in the native core."""

    def divided(left: Series, right: Series) -> Series:
        good = right > 0
        return np.where(good, function(left, np.where(good, right, 1)), 0)

    return divided


_BINARY: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
    ast.FloorDiv: _floor(operator.floordiv), ast.Mod: _floor(operator.mod),
    ast.BitAnd: operator.and_, ast.BitOr: operator.or_, ast.BitXor: operator.xor,
    ast.LShift: lambda left, right: left << (right & 31), ast.RShift: lambda left, right: left >> (right & 31),
}  # fmt: skip
_COMPARE: dict[type, Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq, ast.NotEq: operator.ne, ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}  # fmt: skip
_UNARY: dict[type, Callable[[Any], Any]] = {
    ast.USub: operator.neg, ast.Invert: operator.invert, ast.Not: lambda value: value == 0
}  # fmt: skip


def _evaluate(tree: ast.Expression, ram: npt.NDArray[np.uint8], names: Mapping[str, Series]) -> Series:
    """The values of an expression without labels, (frames,), from RAM (frames, 128) and the series of its variables."""
    return np.broadcast_to(_Evaluator(ram.astype(np.int64), names).value(tree.body), (len(ram),)).astype(np.int64)


class _Evaluator:
    """Evaluates an expression of the rules' language on a recorded history of RAM, all frames at once."""

    def __init__(self, ram: Series, names: Mapping[str, Series]) -> None:
        self._ram, self._names = ram, names

    def value(self, node: ast.expr) -> Series:
        match node:
            case ast.Constant(value=int(value)):
                return np.array(value, np.int64)
            case ast.Name(id=name):
                return self._names[name]
            case ast.Subscript(value=ast.Name(id="ram"), slice=ast.Constant(value=int(place))):
                return self._ram[:, place & 127]
            case ast.BinOp(left=left, op=op, right=right):
                return np.asarray(_BINARY[type(op)](self.value(left), self.value(right)))
            case ast.UnaryOp(op=op, operand=operand):
                return _number(_UNARY[type(op)](self.value(operand)))
            case ast.Compare(left=left, ops=ops, comparators=rights):
                values = [self.value(each) for each in (left, *rights)]
                pairs = zip(ops, values, values[1:], strict=False)
                return _number(np.logical_and.reduce([_COMPARE[type(op)](a, b) for op, a, b in pairs]))
            case ast.BoolOp(op=op, values=parts):
                return self._bool(isinstance(op, ast.And), parts)
            case ast.IfExp(test=test, body=body, orelse=orelse):
                return np.where(self.value(test) != 0, self.value(body), self.value(orelse))
            case ast.Call(func=ast.Name(id=helper), args=arguments):
                return self._call(helper, [self.value(each) for each in arguments])
        raise ValueError(f"{ast.unparse(node)!r} cannot be evaluated on a history of RAM")

    def _bool(self, is_and: bool, parts: list[ast.expr]) -> Series:
        value = self.value(parts[0])
        for part in parts[1:]:
            value = np.where((value != 0) == is_and, self.value(part), value)
        return value

    def _call(self, helper: str, values: list[Series]) -> Series:
        if helper == "s8":
            return (values[0] + 128 & 255) - 128
        if helper == "bcd":
            digits = [self._ram[:, int(place) & 127] for place in values]
            return np.asarray(sum((10 * (byte >> 4) + (byte & 15)) * 100**i for i, byte in enumerate(digits)))
        if helper not in ("count", "same", "pos_sum", "neg_sum"):
            raise ValueError(f"{helper}() cannot be evaluated on a history of RAM")
        low, high = (int(place) & 127 for place in values[:2])
        part = self._ram[:, low : high + 1]
        if helper == "count":
            return np.asarray(np.logical_or.reduce([part == value[..., None] for value in values[2:]]).sum(1))
        if helper == "same":
            return _number((part == part[:, :1]).all(1))
        signed = (part + 128 & 255) - 128
        return np.asarray(np.maximum(signed if helper == "pos_sum" else -signed, 0).sum(1))


def _number(truth: Any) -> Series:
    return np.asarray(truth, np.int64)
