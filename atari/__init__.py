"""Every ALE game as a Gymnasium environment.

`import atari` registers every ID these games have had; `gymnasium.make("ALE/Breakout-v5")` or `atari.make("breakout")`
makes one. `atari.games` describes the games, `atari.wrappers` preprocesses, `atari.roms` finds the ROM files.
"""

import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

try:
    import_module("atari._emulator")
except ImportError as error:
    raise ImportError(
        f"the compiled part of atari is missing here ({error}); if this is the source folder, start Python from "
        "another one, or install the package with `pip install -e .`"
    ) from error

from atari import algorithmic, cores
from atari.actions import Action
from atari.arrays import to_jax, to_torch
from atari.catalog import games
from atari.env import AtariEnv
from atari.game import Game
from atari.registration import explain, make, register_all, register_game
from atari.vector import AtariVectorEnv

if TYPE_CHECKING:
    from atari import roms, wrappers

__version__ = "0.1.0"
__all__ = [
    "Action",
    "AtariEnv",
    "AtariVectorEnv",
    "Game",
    "algorithmic",
    "cores",
    "explain",
    "games",
    "make",
    "register_game",
    "roms",
    "to_jax",
    "to_torch",
    "wrappers",
]

# `atari/games/` holds data files, no module: without this, `import atari.games` would put an empty namespace package
# in the place of the mapping.
sys.modules["atari.games"] = games  # type: ignore[assignment]

register_all()
algorithmic.register_all()


def __getattr__(name: str) -> Any:
    """Import `atari.wrappers` and `atari.roms` when they are first used, to keep `import atari` quick."""
    if name in ("roms", "wrappers"):
        return import_module(f"atari.{name}")
    raise AttributeError(f"module 'atari' has no attribute {name!r}")
