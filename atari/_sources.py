"""Finds the installed package for a Python that has imported `atari` from its source folder."""

import sys
from importlib.machinery import PathFinder
from pathlib import Path


def installed_modules() -> list[str]:
    """The folders of the installed package. Its Python modules and its compiled module come from one build.

    Raises:
        ImportError: the package is not installed for this Python.
    """
    for folder in sys.path:
        package = PathFinder.find_spec("atari", [folder])
        if package and PathFinder.find_spec("atari._emulator", package.submodule_search_locations):
            return list(package.submodule_search_locations or ())
    here = Path(__file__).parent
    raise ImportError(
        f"{here} is the source folder, and atari is not installed for {sys.executable}; "
        f"run `{sys.executable} -m pip install {here.parent}`, or start the Python of the environment that atari is "
        "installed in"
    )
