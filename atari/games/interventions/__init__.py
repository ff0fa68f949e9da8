"""Interventions: changes of a game through writes to its RAM, described in `data/<game>.toml`.

`file.py` reads and checks the files, `writes.py` defines a write and compiles it for the native core. `docs/ram.md`
explains them; `atari.lab.interventions` proves their effects.
"""

from atari.games.interventions.file import Check, Intervention, load, resolve
from atari.games.interventions.writes import CompiledWrite, WriteRule, compile_write

__all__ = ["Check", "CompiledWrite", "Intervention", "WriteRule", "compile_write", "load", "resolve"]
