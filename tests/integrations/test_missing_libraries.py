"""PyTorch, JAX and Stable-Baselines3 are imported only when they are used, and an error names a missing one."""

import importlib
import subprocess
import sys
from collections.abc import Callable

import gymnasium
import numpy as np
import pytest

import atari
from atari.integrations.jax import xla


def test_neither_library_is_imported_before_its_use() -> None:
    code = "import sys, atari; atari.AtariVectorEnv('pong', 1).reset(); print({'torch', 'jax'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.strip() == "set()"


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
