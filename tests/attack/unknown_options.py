"""An invented option to every public callable that takes options, as keywords or in a mapping: each refuses it by name.

The doors are found by introspection: the public names of the package's public modules, and the public methods of its
classes. `POOL` has a value for the parameters that must be given, by their names.
"""

import contextlib
import importlib
import inspect
import random
import string
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import gymnasium
from package_modules import SOURCES

import atari

MAPPINGS = ("options", "config", "kwargs", "settings")
"""How the name of a parameter with a mapping of options ends."""

POOL: dict[str, Callable[[Path], Any]] = {
    "game": lambda folder: "pong",
    "game_or_id": lambda folder: "pong",
    "task_id": lambda folder: "Pong-v5",
    "id": lambda folder: "Pong-v4",
    "env_type": lambda folder: "gymnasium",
    "num_envs": lambda folder: 2,
    "env": lambda folder: atari.AtariEnv("pong", frameskip=1, repeat_action_probability=0.0),
    "envs": lambda folder: atari.AtariVectorEnv("pong", 2),
    "venv": lambda folder: importlib.import_module("atari.sb3").AtariVecEnv("pong", 2),
    "path": lambda folder: folder / f"game{importlib.import_module('atari.recording.replay.file_format').SUFFIX}",
    "video_folder": lambda folder: folder,
    "capacity": lambda folder: 64,
    "skip": lambda folder: 4,
    "stack_size": lambda folder: 4,
    "max_steps": lambda folder: 100,
    "reward": lambda folder: "reward",
    "noop_max": lambda folder: 3,
    "env_config": lambda folder: {"game": "pong"},
    "policy": lambda folder: lambda observation, *rest: 0,
    "steps": lambda folder: 10,
    "preset": lambda folder: "dqn2015",
}

MADE: dict[str, Callable[[Path], Any]] = {
    "RamLabels": lambda folder: importlib.import_module("atari.lab").RamLabels(POOL["env"](folder)),
    "Watch": lambda folder: importlib.import_module("atari.lab").Watch(POOL["env"](folder), 14),
    "RecordReplay": lambda folder: importlib.import_module("atari.recording").RecordReplay(
        POOL["env"](folder), POOL["path"](folder)
    ),
    "RecordVideo": lambda folder: importlib.import_module("atari.recording").RecordVideo(POOL["env"](folder), folder),
    "EnvPool": lambda folder: importlib.import_module("atari.integrations.envpool").make("Pong-v5", "gymnasium"),
}
"""How classes are made that choose another class by their arguments, or that a function makes."""

EXEMPT = {
    "close": "Gymnasium's vectors close with any keywords",
    "close_extras": "Gymnasium's vectors close with any keywords",
    "call": "the keywords are those of the method that is called",
    "env_method": "the keywords are those of the method that is called",
    "render": "old Gym's environments render with any keywords",
    "upload": "old Gym's function did its work on a site that is closed",
}
"""The last names of doors that take any keywords, and why."""


@dataclass(frozen=True)
class Door:
    """A callable, the parameter that takes its options, and the class of a method."""

    call: Callable[..., Any]
    options: str
    owner: type[Any] | None = None


@cache
def doors() -> dict[str, Door]:
    """The callables with options, by their public names and parameters."""
    found: dict[str, Door] = {}
    for name in sorted(SOURCES):
        if any(part.startswith("_") for part in name.split(".")):
            continue
        if name.startswith("atari.classic."):
            continue  # old Gym's classes pass any keywords on, as Gym's did
        with contextlib.suppress(ImportError, gymnasium.error.DependencyNotInstalled):
            module = importlib.import_module(name)
            for public in getattr(module, "__all__", ()):
                with contextlib.suppress(ImportError, gymnasium.error.DependencyNotInstalled):
                    made = getattr(module, public)
                    found |= _with_options(f"{name}.{public}", made, None)
                    if inspect.isclass(made):
                        for own, method in inspect.getmembers(made, inspect.isfunction):
                            if not own.startswith("_"):
                                found |= _with_options(f"{name}.{public}.{own}", method, made)
    return found


def _with_options(name: str, call: Any, owner: type[Any] | None) -> dict[str, Door]:
    """The parameters of a function or class of the package that take options."""
    made_in = str(getattr(call, "__module__", ""))
    if not callable(call) or not made_in.startswith(("atari", "stable_baselines3.common.vec_env")):
        return {}
    if name.rpartition(".")[2] in EXEMPT or getattr(call, "_is_protocol", False):
        return {}
    with contextlib.suppress(TypeError, ValueError):
        return {
            f"{name}({parameter.name})": Door(call, parameter.name, owner)
            for parameter in inspect.signature(call).parameters.values()
            if parameter.kind is parameter.VAR_KEYWORD or parameter.name.endswith(MAPPINGS)
        }
    return {}


def attack(seed: int) -> None:
    """Give an invented option to some of the doors."""
    source = random.Random(seed)
    known = doors()
    with tempfile.TemporaryDirectory() as folder:
        for name in source.sample(sorted(known), 8):
            word = "".join(source.choices(string.ascii_lowercase, k=source.randrange(5, 14)))
            value = source.choice((None, 0, 1, True, 2.5, "text", [1], {}))
            result = refused(name, word, value, Path(folder))
            assert result is not False, f"{name} takes the invented option {word}={value!r} without a word"


def refused(name: str, word: str, value: Any, folder: Path) -> bool | None:
    """Whether a door refuses an option by its name; None if it cannot be called with the values of `POOL`."""
    door = doors()[name]
    with contextlib.ExitStack() as opened:
        try:
            arguments = _arguments(door.call, door.owner, folder, opened)
        except LookupError:
            return None
        except (TypeError, ValueError):  # the values of `POOL` do not fit
            return None
        keyword = inspect.signature(door.call).parameters[door.options].kind is inspect.Parameter.VAR_KEYWORD
        given = {word: value} if keyword else {door.options: {**arguments.pop(door.options, {}), word: value}}
        try:
            opened.callback(_close, door.call(**arguments, **given))
            if name.endswith(".set_options(options)"):  # which are for the next reset
                arguments["self"].reset()
        except Exception as error:
            return True if word in str(error) else None
    return False


def _arguments(call: Any, owner: type[Any] | None, folder: Path, opened: contextlib.ExitStack) -> dict[str, Any]:
    """The arguments that a call must have; LookupError if there is none for one of them."""
    made: dict[str, Any] = {}
    for parameter in inspect.signature(call).parameters.values():
        if parameter.name == "self" and owner is not None:
            known = MADE.get(owner.__name__)
            made["self"] = known(folder) if known else owner(**_arguments(owner, None, folder, opened))
        elif parameter.name == "num_envs" or (
            parameter.default is parameter.empty
            and parameter.kind in (parameter.POSITIONAL_OR_KEYWORD, parameter.KEYWORD_ONLY)
        ):
            made[parameter.name] = POOL[parameter.name](folder)
        if parameter.name in made:
            opened.callback(_close, made[parameter.name])
    return made


def _close(made: Any) -> None:
    with contextlib.suppress(Exception):
        made.close()
