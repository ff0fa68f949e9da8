"""The code blocks of the documentation that need other packages. All other blocks run in every test lane."""

import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.peers

TOP = Path(__file__).parents[2]
BLOCKS = {
    f"{path.name}-{number}": block
    for path in [*sorted(TOP.glob("*.md")), *sorted(TOP.glob("docs/*.md"))]
    for number, block in enumerate(
        re.findall(r"^```python peers\n(.*?)^```$", path.read_text(), re.MULTILINE | re.DOTALL)
    )
}


@pytest.mark.parametrize("name", BLOCKS)
def test_a_block(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(BLOCKS[name], name, "exec"), {})


def test_there_are_some() -> None:
    assert len(BLOCKS) >= 2
