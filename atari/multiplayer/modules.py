"""PettingZoo's module of each environment: `from atari.multiplayer import pong_v3`."""

import inspect
from collections.abc import Callable, Iterable, Iterator
from types import ModuleType
from typing import Any

from atari.games.pettingzoo import ENVIRONMENTS, Environment


def make_modules(package: str, functions: Iterable[Callable[..., Any]]) -> Iterator[ModuleType]:
    """A module of each environment, with these functions of a game as functions of its parameters."""
    for environment in ENVIRONMENTS.values():
        module = ModuleType(f"{package}.{environment.id}", f"PettingZoo's environment {environment.id}.")
        for function in functions:
            setattr(module, function.__name__, _of(environment, function))
        yield module


def _of(environment: Environment, function: Callable[..., Any]) -> Callable[..., Any]:
    kind = inspect.Parameter
    parameters = [kind(name, kind.POSITIONAL_OR_KEYWORD, default=value) for name, value in environment.defaults.items()]
    signature = inspect.Signature([*parameters, kind("options", kind.VAR_KEYWORD)])

    def make(*values: Any, **options: Any) -> Any:
        given = signature.bind(*values, **options).arguments
        return function(environment.id, **given.pop("options", {}), **given)

    make.__name__, make.__doc__ = function.__name__, function.__doc__
    vars(make)["__signature__"] = signature
    return make
