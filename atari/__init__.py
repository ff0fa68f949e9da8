"""Every ALE game as a Gymnasium environment.

`import atari` registers every ID that these games have had; `gymnasium.make("ALE/Breakout-v5")` and
`atari.make("breakout")` make an environment. `atari.games` describes the games, `atari.wrappers` preprocesses,
`atari.roms` finds the ROM files.
"""

import sys
from importlib import import_module
from importlib.machinery import PathFinder
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any


def _installed_modules() -> list[str]:
    """The folders of the installed package. Its Python modules and its compiled module come from one build.

    Raises:
        ImportError: the package is not installed for this Python.
    """
    for folder in sys.path:
        package = PathFinder.find_spec("atari", [folder])
        if package and PathFinder.find_spec("atari._emulator", package.submodule_search_locations):
            return list(package.submodule_search_locations or ())
    here, clone = __path__[0], __path__[0].removesuffix("atari")
    raise ImportError(
        f"{here} is the source folder, and atari is not installed for {sys.executable}; run `{sys.executable} -m pip "
        f"install {clone}`, or start the Python of the environment that atari is installed in"
    )


if find_spec("atari._emulator") is None:  # the source folder, which Python finds first if it starts beside it
    __path__[:] = _installed_modules()

from atari.base import start  # isort: skip # noqa: F401 - before the other imports, which take a second

from atari import cores
from atari.base import namesake
from atari.base.variables import check as check_variables
from atari.base.version import VERSION
from atari.base.wrapped import show_wrapped
from atari.env import AtariEnv
from atari.games.actions import Action
from atari.games.game import Game
from atari.registry.making import make
from atari.registry.registration import explain, register_algorithmic, register_all, register_game
from atari.task import PRESETS, Task
from atari.vector import AtariVectorEnv

__version__ = VERSION

if TYPE_CHECKING:
    from atari import classic, integrations, lab, learning, multiplayer, recording, roms, testing, wrappers
    from atari.games.catalog import games  # the package `atari.games` is also this mapping
    from atari.integrations.arrays import to_jax, to_torch

__all__ = [
    "PRESETS",
    "Action",
    "AtariEnv",
    "AtariVectorEnv",
    "Game",
    "Task",
    "classic",
    "cores",
    "explain",
    "games",
    "integrations",
    "lab",
    "learning",
    "make",
    "multiplayer",
    "recording",
    "register_game",
    "roms",
    "testing",
    "to_jax",
    "to_torch",
    "wrappers",
]

_LATER = ("classic", "integrations", "lab", "learning", "multiplayer", "recording", "roms", "testing", "wrappers")
"""Packages that are imported when they are first used, to keep `import atari` quick."""

namesake.check(__path__)
check_variables()
register_all()
register_algorithmic()
show_wrapped()


def __getattr__(name: str) -> Any:
    if name in _LATER:
        return import_module(f"atari.{name}")
    if name in ("to_jax", "to_torch"):
        return getattr(import_module("atari.integrations.arrays"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
