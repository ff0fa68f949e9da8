"""Libraries and parts of the package are imported only when they are used, and an error names a missing library."""

import importlib
import sys
from collections.abc import Callable

import gymnasium
import numpy as np
import pytest
from own_process import run_program

import atari
from atari.integrations.jax import xla

WITHOUT = {
    "import atari": {"atari.cli", "atari.recording", "av"},
    "atari.AtariVectorEnv('pong', 1).reset()": {"torch", "jax"},
    "import atari.lab": {"aiohttp", "anywidget", "torch"},
    "import atari.classic": {"gym", "numpy.int", "numpy.float"},  # the runner of scripts alone replaces them
}
"""Lines of one program, each with names that do not exist after it."""


def test_what_is_not_imported_before_its_use() -> None:
    found = "set(sys.modules).union(f'numpy.{name}' for name in vars(numpy))"
    checks = [f"{line}\nprint({names!r} & {found})" for line, names in WITHOUT.items()]
    assert run_program("\n".join(["import numpy, sys", *checks])) == "set()\n" * len(WITHOUT)


def imported(module: str) -> Callable[[], object]:
    return lambda: importlib.import_module(module)


@pytest.mark.parametrize(
    ("missing", "use", "text"),
    [
        ("torch", lambda: atari.to_torch(np.zeros(3)), "needs PyTorch"),
        ("torch", imported("atari.integrations.torch"), "TorchEnvs needs PyTorch"),
        ("jax", lambda: atari.to_jax(np.zeros(3)), "needs JAX"),
        ("jax", lambda: xla(atari.AtariVectorEnv("pong", 1)), r"xla\(\) needs JAX.*"),
        ("stable_baselines3", imported("atari.sb3"), r"atari\.sb3 needs Stable-Baselines3"),
        ("ray", imported("atari.integrations.ray"), r"atari\.integrations\.ray needs Ray"),
    ],
)
def test_a_missing_library_is_named(
    missing: str, use: Callable[[], object], text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    ours = ("atari.sb3", "atari.integrations.sb3", "atari.integrations.torch", "atari.integrations.ray")
    for name in [name for name in sys.modules if name.startswith((*ours, "stable_baselines3."))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match=f"{text}: .* -m pip install"):
        use()
