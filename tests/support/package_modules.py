"""The modules of the package by their names.

`pkgutil.walk_packages` finds others: the search path of an editable installation has the top of the repository too, in
which the package `atari.atari` would be a second one, with classes of its own.
"""

from pathlib import Path

import atari
import atari.roms
import atari.wrappers


def sources() -> dict[str, Path]:
    """The file of every module by its name."""
    found = {}
    for package in (atari, atari.roms, atari.wrappers):
        folder = Path(str(package.__file__)).parent
        for file in folder.rglob("*.py"):
            parts = [package.__name__, *file.relative_to(folder).with_suffix("").parts]
            found[".".join(parts).removesuffix(".__init__")] = file
    return found


SOURCES = sources()
