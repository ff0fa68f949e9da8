"""The doors of a `Task`: all of them give equal tasks, or refuse a value with the same sentence; a task can be played."""

import argparse
import contextlib
import copy
import io
import json
import pickle
import random
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from field_values import DRAWN, flags_of, seconds_of_noop, seconds_of_step, small, task_with, value_of

import atari
from atari.games.catalog import playable_ids
from atari.games.game import Game
from atari.task import Task
from atari.task.arguments import add_task, task_of
from atari.task.checks import FrameSkip, OneOf, OrNone, Probability, Span, Whole, check_actions, check_bool
from atari.task.fields import CHECKS, DEFAULTS, ROWS

MOST_SECONDS = 0.1
"""The seconds that a step, or the no-ops of a reset, of a played task may take."""


def attack(seed: int) -> None:
    """Store, copy and spell some tasks, and forge some."""
    source = random.Random(seed)
    for _ in range(3):
        if task := task_with(source, any_game(source), {}, source.choice((0.05, 0.3))):
            compare_copies(task)
    for _ in range(6):
        game = any_game(source)
        name = source.choice(("interventions", *DRAWN))
        compare_doors(game, {name: forged(source, name, game)})
    game = any_game(source)
    fields = {name: value_of(source, name, game, small) for name in source.sample(DRAWN, 3)}
    compare_doors(game, {**fields, "interventions": (), (name := source.choice(DRAWN)): forged(source, name, game)})


def any_game(source: random.Random) -> Game:
    """A game; each is equally likely."""
    return atari.games[source.choice(playable_ids())]


def compare_copies(task: Task) -> None:
    """Every way to store, copy or write out a task gives an equal task."""
    changed = {name: value for name, value in task.as_options().items() if value != DEFAULTS[name]}
    options = {name: value for name, value in changed.items() if name not in ("rules", "rom_md5")}
    doors: dict[str, Callable[[], Task]] = {
        "from_json(to_json())": lambda: Task.from_json(task.to_json()),
        "pickle": lambda: pickle.loads(pickle.dumps(task)),
        "copy": lambda: copy.copy(task),
        "deepcopy": lambda: copy.deepcopy(task),
        "repr": lambda: eval(repr(task), {"Task": Task}),
        "Task.of": lambda: Task.of(task),
        "replace": task.replace,
        "the fields": lambda: Task(task.definition, **task.as_options()),
        "the options": lambda: Task.of(task.game, **options),
        "the command line": lambda: of_command_line(task.game, options),
    }
    for name, door in doors.items():
        try:
            made = door()
        except (TypeError, ValueError) as error:
            raise AssertionError(f"{name} refuses {task!r}: {error}") from None
        assert made == task, f"{name} of {task!r} differs in {task.differences(made)}"
        assert hash(made) == hash(task), f"{name} of {task!r} has another hash"


def of_command_line(game: str, options: Mapping[str, Any]) -> Task:
    """The task of a command line with these options.

    Raises:
        ValueError: the parser, or the task, refuses one.
    """
    parser = argparse.ArgumentParser()
    add_task(parser)
    errors = io.StringIO()
    try:
        with contextlib.redirect_stderr(errors):
            args = parser.parse_args([flag for name, value in options.items() for flag in flags_of(name, value)])
    except SystemExit:
        raise ValueError(errors.getvalue()) from None
    return task_of(args, game=game)


def forged(source: random.Random, name: str, game: Game) -> Any:
    """A value of a field, or one just outside of its range, in a form that JSON has."""
    if name == "interventions":
        return [intervention(source, game) for _ in range(source.choice((1, 1, 2)))]
    if source.random() < 0.3:
        return value_of(source, name, game)
    if source.random() < 0.2:
        return source.choice((None, True, 1, 0.5, "", "none", [], [1], {}, [[]]))
    return outside(source, name, CHECKS[name], game)


def outside(source: random.Random, name: str, check: Any, game: Game) -> Any:
    """A value of the right kind that a check refuses, or nearly."""
    match check:
        case Whole(low, high):
            return source.choice((low - 1, high + 1, low - 0.5, float(high), str(low)))
        case Probability():
            return source.choice((np.nextafter(check.low, -1.0), np.nextafter(check.high, 2.0), -1, 2, str(check.high)))
        case OneOf(choices):
            return source.choice(choices).swapcase()
        case OrNone(inner):
            return outside(source, name, inner, game)
        case Span(each) | FrameSkip(each):
            ends = each.low, each.high, outside(source, name, each, game)
            return tuple(source.choice(ends) for _ in range(source.choice((1, 2, 2, 2, 3))))
    if check is check_bool:
        return source.choice((0, 1, "true", None))
    if check is check_actions:
        return source.choice((("NOOP", "NOOP"), ("noop",), (), "most", ("RESET",)))
    if name == "reward":
        return source.choice(("reward +", "score", "ram[256]", "1 / 0", "(" * 300, "before.ram[0] ** 2"))
    offered = getattr(game, {"mode": "modes", "difficulty": "difficulties"}[name])
    return source.choice((max(offered) + 1, min(offered) - 1, float(offered[0]), str(offered[0])))


def intervention(source: random.Random, game: Game) -> dict[str, Any]:
    """A definition of an intervention, right or nearly."""
    labels = sorted(game.ram_labels) or ["none"]

    def number(low: int, high: int) -> int:
        return source.choice((source.randint(low, high), low, high, low - 1, high + 1))

    def expression() -> str:
        name = source.choice((source.choice(labels), f"ram[{number(0, 127)}]", "old", "frame", "random(0, 3)"))
        return source.choice((name, f"{name} + {number(0, 255)}", " + ".join([name] * source.choice((2, 40, 300)))))

    write: dict[str, Any] = {
        "to": source.choice((source.choice(labels), number(0, 255))),
        "value": source.choice((number(0, 255), expression())),
    }
    others: dict[str, Callable[[], Any]] = {
        "when": lambda: source.choice(("frame", "reset", number(0, 2**31 - 1), [0, number(0, 9)], "held")),
        "if": expression,
        "mask": lambda: number(1, 255),
    }
    write |= {key: make() for key, make in others.items() if source.random() < 0.2}
    return {"name": "forged", "description": "-", "source": "-", "writes": [write] * source.choice((1, 1, 1, 40))}


def compare_doors(game: Game, fields: Mapping[str, Any]) -> None:
    """The doors refuse the fields, all with the same sentence if there is one field, or make equal tasks that play."""
    text = json.dumps({**json.loads(Task(game.id).to_json()), **fields})
    fields = json.loads(json.dumps(fields))  # with lists in place of tuples
    doors = {
        "from_json": lambda: Task.from_json(text),
        "Task": lambda: Task(game.id, **fields),
    }
    if not any(value is None and ROWS[name].accepts for name, value in fields.items()):
        doors["Task.of"] = lambda: Task.of(game.id, **fields)
    if all(has_text(name, value) for name, value in fields.items()):
        doors["the command line"] = lambda: of_command_line(game.id, fields)
    made = {name: outcome(door) for name, door in doors.items()}
    shown = f"{game.id} {fields!r:.1000}"
    first, *others = made.items()
    for name, result in others:
        both = f"{shown}: {first[0]} {first[1]!r:.300}, {name} {result!r:.300}"
        assert isinstance(result, Task) == isinstance(first[1], Task), both
        if isinstance(result, Task):
            assert result == first[1], both
        elif len(fields) == 1:
            assert sentence(first[1]) in sentence(result), both
    if isinstance(first[1], Task):
        play(first[1], shown)


def sentence(error: Exception | Task) -> str:
    """The message of a refusal, with tuples written as lists: a command line and JSON have one of them each."""
    return str(error).replace("(", "[").replace(")", "]").replace(",]", "]")


def has_text(name: str, value: Any) -> bool:
    """Whether a command line has a text that stands for this value alone.

    "1.0" is the integer 1, a word of `actions` is a list of one, "none" is None, and a number is a word for a field of
    names.
    """
    if CHECKS[name] is check_bool or isinstance(value, bool):
        return CHECKS[name] is check_bool and isinstance(value, bool)
    if isinstance(CHECKS[name], OneOf):
        return False
    if name == "reward":
        return isinstance(value, str) and value not in ("", "none")
    if name == "actions":
        return bool(value) and isinstance(value, list) and all(isinstance(word, str) and word for word in value)
    words = value if isinstance(value, list) and len(value) > 1 else [value]
    return all(isinstance(word, int) or (isinstance(word, float) and not word.is_integer()) for word in words)


def outcome(door: Callable[[], Task]) -> Task | Exception:
    """The task, or the refusal."""
    try:
        return door()
    except (TypeError, ValueError) as error:
        return error


def play(task: Task, shown: str) -> None:
    """Make a task that a door accepts, in an environment and in a vector; play it if this takes few seconds."""
    try:
        env, envs = atari.make(task), atari.AtariVectorEnv(task, 1, num_threads=1)
    except (TypeError, ValueError) as error:
        raise AssertionError(f"{shown}: accepted as a task, and refused when it is made: {error}") from None
    if seconds_of_step(task) < MOST_SECONDS and seconds_of_noop(task) * task.noops[1] < MOST_SECONDS:
        env.reset(seed=0)
        envs.reset(seed=0)
        env.step(env.action_space.sample())
        envs.step(envs.action_space.sample())
    env.close()
    envs.close()
