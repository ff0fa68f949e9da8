"""PyTorch, JAX and Stable-Baselines3 are imported only when they are used, and an error names a missing one."""

import importlib
import subprocess
import sys

import gymnasium
import numpy as np
import pytest

import atari
from atari.integrations.jax import xla


def test_neither_library_is_imported_before_its_use() -> None:
    code = "import sys, atari; atari.AtariVectorEnv('pong', 1).reset(); print({'torch', 'jax'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.strip() == "set()"


@pytest.mark.parametrize(("name", "package"), [("to_torch", "PyTorch"), ("to_jax", "JAX")])
def test_a_missing_library_is_named(name: str, package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in ("torch", "jax"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match=f"needs {package}: .* -m pip install"):
        getattr(atari, name)(np.zeros(3))


def test_a_missing_stable_baselines3_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    ours = ("atari.sb3", "atari.integrations.sb3")
    for name in [name for name in sys.modules if name in ours or name.startswith("stable_baselines3.")]:
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(
        gymnasium.error.DependencyNotInstalled, match=r"atari\.sb3 needs Stable-Baselines3: .* -m pip install"
    ):
        importlib.import_module("atari.sb3")


def test_a_missing_jax_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "jax", None)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match=r"xla\(\) needs JAX.*: .* -m pip install"):
        xla(atari.AtariVectorEnv("pong", 1))


def test_a_missing_torch_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    monkeypatch.delitem(sys.modules, "atari.integrations.torch", raising=False)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match=r"TorchEnvs needs PyTorch: .* -m pip install"):
        importlib.import_module("atari.integrations.torch")


def test_a_missing_ray_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    for name in [name for name in sys.modules if name.startswith("atari.integrations.ray")]:
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(
        gymnasium.error.DependencyNotInstalled, match=r"atari\.integrations\.ray needs Ray: .* -m pip install"
    ):
        importlib.import_module("atari.integrations.ray")
