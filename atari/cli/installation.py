"""`atari info` without a game: the cores, ROM files and packages of this Python, and commands that install others."""

import platform
import shlex
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from typing import Any

import gymnasium

import atari
from atari import roms
from atari.base.text_table import aligned
from atari.cores import CORES
from atari.cores.host_check import machine
from atari.games.catalog import games
from atari.web.shelf import is_built


@dataclass(frozen=True)
class Use:
    """A use of this package that needs others.

    Attributes:
        name: the words for it, at most 17 characters.
        extra: the extra of this package that installs what it needs, or None.
        packages: the packages that it needs, each with its module.
    """

    name: str
    extra: str | None
    packages: dict[str, str]

    def missing(self) -> list[str]:
        """The packages whose module is not found."""
        return [package for package, module in self.packages.items() if find_spec(module) is None]

    def installed(self) -> dict[str, str]:
        """The versions of the other packages; "" if another package has the module, as pygame has pygame-ce's."""
        missing = self.missing()
        return {package: _version(package) for package in self.packages if package not in missing}


USES = (
    Use("videos with sound", "video", {"av": "av"}),
    Use("windows, sound", "play", {"pygame-ce": "pygame"}),
    Use("agents, plots", "learn", {"torch": "torch", "tensorboard": "tensorboard", "matplotlib": "matplotlib"}),
    Use("notebooks", None, {"jupyterlab": "jupyterlab", "ipykernel": "ipykernel"}),
    Use("inspector", "lab", {"aiohttp": "aiohttp", "anywidget": "anywidget", "tomli-w": "tomli_w"}),
    Use("several players", "multiplayer", {"pettingzoo": "pettingzoo"}),
    Use("Stable-Baselines3", "sb3", {"stable-baselines3": "stable_baselines3"}),
    Use("JAX", "jax", {"jax": "jax"}),
    Use("Ray and RLlib", "ray", {"ray[rllib]": "ray", "torch": "torch"}),
    Use("Minari", "minari", {"minari": "minari", "h5py": "h5py", "pillow": "PIL"}),
    Use("Tab completion", "completion", {"shtab": "shtab"}),
    Use("AutoROM", "roms", {"autorom": "AutoROM"}),
)


def facts() -> dict[str, Any]:
    """The installed and the missing parts, in the types of JSON. A core that plays has None, another one its error."""
    here = machine()
    uses = [
        {"use": use.name, "extra": use.extra, "installed": use.installed(), "missing": use.missing()} for use in USES
    ]
    return {
        "version": atari.__version__,
        "python": here.python,
        "executable": sys.executable,
        "platform": here.platform,
        "cores": {name: _error_of_core(name) for name in ("native", "ale")},
        "simd": here.simd,
        "translator": here.translator,
        "ale_py": _version("ale-py"),
        "roms": {"found": len(roms.installed()), "games": len(games)},
        "page": is_built(),
        "uses": uses,
    }


def lines(here: dict[str, Any]) -> Iterator[str]:
    """The facts for a terminal of 80 columns and 24 lines."""
    found, of = here["roms"]["found"], here["roms"]["games"]
    fast = f"plays; SIMD {here['simd']}, translator {here['translator'] or 'off'}"
    rows = [
        ("native core", here["cores"]["native"] or fast),
        ("ale-py's core", here["cores"]["ale"] or f"plays; ale-py {here['ale_py']}"),
        ("ROM files", f"{found} of {of} games" + ("" if found else "; `atari roms --help` says how to add them")),
        ("page (atari web)", "here" if here["page"] else "missing: scripts/web builds it in a clone (Emscripten)"),
        *((use["use"], _packages(use)) for use in here["uses"]),
    ]
    yield f"atari-envs {here['version']}, {here['python']}, {here['platform']}"
    yield from (f"  {line}" for line in aligned(rows))
    torch_is_missing = any("torch" in use["missing"] for use in here["uses"])
    if any("missing: pip" in text for _, text in rows):
        yield f"pip is `{here['executable'] or 'python'} -m pip`"
    if torch_is_missing and platform.system() == "Linux":
        yield "PyTorch's build for CPUs is smaller: pytorch.org/get-started has its command"
    yield "`atari info --games` lists the games, and `atari info GAME` has the facts of one"


def _packages(use: dict[str, Any]) -> str:
    """The installed packages of a use, and the command that installs the missing ones."""
    installed = ", ".join(f"{package} {version}".strip() for package, version in use["installed"].items())
    command = f"missing: pip install {shlex.join(use['missing'])}" if use["missing"] else ""
    return "; ".join(filter(None, [installed, command]))


def _error_of_core(name: str) -> str | None:
    try:
        CORES[name]("pong").reset()
    except gymnasium.error.DependencyNotInstalled:
        return "missing: pip install --upgrade ale-py"
    except (gymnasium.error.Error, OSError, ValueError) as error:
        return str(error)
    return None


def _version(package: str) -> str:
    try:
        return version(package.partition("[")[0])
    except PackageNotFoundError:
        return ""
