"""Every ALE game as a Gymnasium environment.

`import atari` registers every ID that these games have had; `gymnasium.make("ALE/Breakout-v5")` and
`atari.make("breakout")` make an environment. `atari.games` describes the games, `atari.wrappers` preprocesses,
`atari.roms` finds the ROM files.
"""

from atari import _start  # isort: skip # noqa: F401 - before the other imports, which take a second

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if find_spec("atari._emulator") is None:  # the source folder, which Python finds first if it starts beside it
    __path__[:] = import_module("atari._sources").installed_modules()

from atari import algorithmic, cores
from atari._variables import check as check_variables
from atari._version import __version__ as __version__
from atari.actions import Action
from atari.algorithmic.registration import register_all as register_algorithmic
from atari.env import AtariEnv
from atari.games.game import Game
from atari.making import make
from atari.registration import explain, register_all, register_game
from atari.task import PRESETS, Task
from atari.vector import AtariVectorEnv

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
    "algorithmic",
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

check_variables()
register_all()
register_algorithmic()


def __getattr__(name: str) -> Any:
    if name in _LATER:
        return import_module(f"atari.{name}")
    if name in ("to_jax", "to_torch"):
        return getattr(import_module("atari.integrations.arrays"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
