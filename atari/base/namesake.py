"""The unrelated package `atari` of the Python Package Index, whose modules have the import name of this package."""

import warnings
from collections.abc import Iterable
from importlib.machinery import PathFinder

_THEIRS = "visualize"
"""A module of the other package, and not of this one."""


def check(folders: Iterable[str]) -> None:
    """Warn if files of the other package lie in the folders of this one: whichever came later has replaced some."""
    if PathFinder.find_spec(f"atari.{_THEIRS}", [*folders]) is not None:
        warnings.warn(
            "the unrelated package 'atari' is installed, too, and the two replace each other's files; type "
            "`pip uninstall atari atari-envs`, then `pip install atari-envs`",
            stacklevel=3,
        )
