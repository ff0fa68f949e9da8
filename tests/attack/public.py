"""Hostile arguments to the public functions and classes of the package, and to the methods of the objects they return.

The functions, their parameters and the methods are read from the modules.
"""

import inspect
import os
import random
import tempfile
from collections.abc import Callable
from importlib import import_module
from types import ModuleType
from typing import Any

import numpy as np

import atari
from attack.api import LEFT_OUT, OWN_CHECKS, hostile
from attack.findings import attempt

MODULES = (
    *("atari", "atari.cores", "atari.lab", "atari.lab.interventions", "atari.learning", "atari.multiplayer"),
    *("atari.recording", "atari.wrappers", "atari.vector"),
)

LONG = {"causes", "check", "compare", "evaluate", "record_games", "show", "register_game"}
"""Functions that play for minutes, wait for a person, or change the process."""

MODULE_OF_BINDING = "atari._emulator"


def plausible(source: random.Random) -> dict[str, Callable[[], Any]]:
    """A maker of a value that fits a parameter, by the parameter's name."""
    game = source.choice(("pong", "breakout", "surround"))

    def vector() -> Any:
        made = atari.AtariVectorEnv(source.choice(("pong", "breakout")), 2, num_threads=1)
        attempt(lambda: made.reset(seed=0))
        return made

    def single() -> Any:
        made = atari.make(source.choice(("pong", "breakout")), obs_type=source.choice(("ram", "rgb")), frameskip=1)
        attempt(lambda: made.reset(seed=0))
        return made

    def either() -> Any:
        return source.choice((single, vector))()

    return {
        **dict.fromkeys(("game", "game_or_id", "env_id", "games"), lambda: game),
        **dict.fromkeys(("env", "target", "source"), either),
        **dict.fromkeys(("num_envs", "num_players", "players"), lambda: 2),
        **dict.fromkeys(("capacity",), lambda: 100),
        **dict.fromkeys(("observation_shape", "size"), lambda: source.choice(((84, 84), (128,), (4, 4)))),
        **dict.fromkeys(("action", "actions"), lambda: np.zeros(2, np.int64)),
        **dict.fromkeys(("path", "file", "output"), lambda: "made"),
        **dict.fromkeys(("values",), lambda: {0: 1}),
        **dict.fromkeys(("indices", "targets", "env_id"), lambda: [0]),
        **dict.fromkeys(("seed", "index", "place", "label"), lambda: source.choice((0, 1))),
        **dict.fromkeys(("name",), lambda: source.choice(("dqn", "random", "lives"))),
    }


def arguments_for(
    source: random.Random, function: Any, makers: dict[str, Callable[[], Any]]
) -> tuple[list[Any], dict[str, Any]]:
    """Arguments of which the required ones mostly fit, and one or two are hostile."""
    try:
        parameters = list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError):
        return [hostile(source) for _ in range(source.randrange(4))], {}
    wrong = source.sample(parameters, min(len(parameters), source.choice((0, 1, 1, 2))))
    positional: list[Any] = []
    named: dict[str, Any] = {}
    for parameter in parameters:
        required = parameter.default is parameter.empty
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD) or not (required or parameter in wrong):
            continue
        value = hostile(source) if parameter in wrong or parameter.name not in makers else makers[parameter.name]()
        if parameter.kind is parameter.POSITIONAL_ONLY:
            positional.append(value)
        else:
            named[parameter.name] = value
    return positional, named


def public_names(module: ModuleType, source: random.Random) -> list[str]:
    """The names of a module that can be called, in random order."""
    names = [name for name in getattr(module, "__all__", dir(module)) if not name.startswith("_") and name not in LONG]
    return source.sample(names, len(names))


def attack(seed: int) -> None:
    """Call some public functions and classes, then methods of what they returned."""
    source = random.Random(seed)
    makers = plausible(source)
    before = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # for the files that the calls write
        try:
            for _ in range(6):
                module = import_module(source.choice(MODULES))
                for name in public_names(module, source)[:2]:
                    made = use(source, lambda module=module, name=name: getattr(module, name), makers)
                    attack_methods(source, made, makers)
        finally:
            os.chdir(before)


def use(source: random.Random, get: Callable[[], Any], makers: dict[str, Callable[[], Any]]) -> Any:
    """The result of a call with some hostile arguments; None if it was refused."""
    refused = (AttributeError, KeyError, NotImplementedError)  # an object of another kind, refused by Python itself
    try:
        function = attempt(get)
        if not callable(function):
            return function
        positional, named = arguments_for(source, function, makers)
        private = function.__module__ == MODULE_OF_BINDING or getattr(function, "__name__", "") in OWN_CHECKS
        return attempt(lambda: function(*positional, **named), private=private)
    except (*refused, ImportError):  # some names need an optional package
        return None


def attack_methods(source: random.Random, target: Any, makers: dict[str, Callable[[], Any]]) -> None:
    """Call methods of an object of this package."""
    kind = type(target)
    if not kind.__module__.startswith("atari") or kind.__module__ == MODULE_OF_BINDING:
        return
    names = [name for name in dir(kind) if not name.startswith("_") and name not in LEFT_OUT]
    for name in source.sample(names, min(len(names), 12)):
        use(source, lambda name=name: getattr(target, name), makers)
    close = getattr(target, "close", None)
    if callable(close):
        attempt(close)
