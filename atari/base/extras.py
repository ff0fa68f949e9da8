"""Optional packages, and the commands that install them for the Python that runs."""

import re
import shlex
import sys
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import gymnasium

from atari.base.start import PROGRAM, say

_SLOW = {"torch": "PyTorch", "stable_baselines3": "Stable-Baselines3 and PyTorch", "jax": "JAX"}


def pip_install(*packages: str) -> str:
    """The command that installs packages for this Python, whichever environment the shell has activated."""
    return shlex.join([sys.executable or "python", "-m", "pip", "install", *packages])


def install_extra(extra: str) -> str:
    """The command that installs the packages of an extra of this package.

    It names the packages themselves, so it works after an installation from a clone, from a wheel and from an index.
    """
    from importlib.metadata import requires  # here: it imports the parser of e-mails

    of_extra = re.compile(rf"""extra == ['"]{re.escape(extra)}['"]""")
    return pip_install(*(line.partition(";")[0] for line in requires("atari-envs") or [] if of_extra.search(line)))


def import_extra(module: str, need: str) -> Any:
    """An optional module. The command `atari` prints a line before it imports one that takes seconds.

    Args:
        module: its name.
        need: the sentence about it, such as f"probes need PyTorch: {pip_install('torch')}".

    Raises:
        gymnasium.error.DependencyNotInstalled: it is not installed.
    """
    if PROGRAM and module in _SLOW and module not in sys.modules and find_spec(module):
        say(f"atari: loading {_SLOW[module]}, which takes some seconds")
    try:
        return import_module(module)
    except ImportError as error:
        raise gymnasium.error.DependencyNotInstalled(need) from error
