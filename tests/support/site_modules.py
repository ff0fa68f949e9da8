"""Modules of the folders of `scripts`, which are no packages."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

SCRIPTS = Path(__file__).parents[2] / "scripts"


def load(name: str, folder: str = "site") -> ModuleType:
    """A module of a folder of `scripts` by the name of its file; only one that imports no other of them."""
    full = f"{folder or 'scripts'}_{name}"
    if full not in sys.modules:
        spec = importlib.util.spec_from_file_location(full, SCRIPTS / folder / f"{name}.py")
        assert spec is not None
        assert spec.loader is not None
        sys.modules[full] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[full])
    return sys.modules[full]
