"""The code blocks of the documentation that need PyTorch."""

from pathlib import Path

import pytest
from documents import blocks

pytest.importorskip("torch")

BLOCKS = blocks("learn")


@pytest.mark.parametrize("name", BLOCKS)
def test_a_block(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(BLOCKS[name], name, "exec"), {})


def test_there_are_some() -> None:
    assert len(BLOCKS) >= 2
