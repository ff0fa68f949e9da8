"""The code blocks of the documentation that need JAX."""

import os
from pathlib import Path

import pytest
from documents import blocks

os.environ.setdefault("JAX_PLATFORMS", "cpu")
pytest.importorskip("jax", reason="needs JAX, which scripts/test --jax installs")

BLOCKS = blocks("jax")


@pytest.mark.parametrize("name", BLOCKS)
def test_a_block(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(BLOCKS[name], name, "exec"), {})


def test_there_are_some() -> None:
    assert BLOCKS
