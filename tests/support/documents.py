"""The pages of the documentation, and the code blocks that need other packages; others run in every test lane."""

import re
from pathlib import Path

TOP = Path(__file__).parents[2]


def blocks(lane: str, language: str = "python") -> dict[str, str]:
    """The blocks that begin with "```LANGUAGE LANE", by document and number."""
    return {
        f"{path.name}-{number}": block
        for path in [*sorted(TOP.glob("*.md")), *sorted(TOP.glob("docs/*.md")), *sorted(TOP.glob("docs/recipes/*.md"))]
        for number, block in enumerate(
            re.findall(rf"^```{language} {lane}\n(.*?)^```$", path.read_text(), re.MULTILINE | re.DOTALL)
        )
    }


def page(name: str) -> list[str]:
    """The lines of a page of the documentation."""
    return (TOP / "docs" / name).read_text(encoding="utf-8").splitlines()
