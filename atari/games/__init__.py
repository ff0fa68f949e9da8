"""Game definitions: `atari.games` maps a game's id to its definition, as in `atari.games["ms_pacman"]`.

`data/` has one file a game; `SCHEMA.md` documents the files. `game.py` parses a file, `catalog.py` has the mapping,
`rules.py` defines the language of rules, and `compiler.py` compiles rules for the native core. `manuals/` has the facts
of each game for people, which `manual.py` parses.
"""

import sys
from importlib import import_module
from types import ModuleType

from atari.games.catalog import Games


class _GamesPackage(Games, ModuleType):
    """The class of this package's module object, so that every way to import `atari.games` gives the mapping."""

    __hash__ = ModuleType.__hash__

    def __reduce__(self) -> tuple[object, ...]:
        """A copy or a pickle of the package is the package itself."""
        return import_module, (__name__,)


sys.modules[__name__].__class__ = _GamesPackage
