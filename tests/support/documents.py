"""The code blocks of the documentation that need other packages. All other blocks run in every test lane."""

import re
from pathlib import Path

TOP = Path(__file__).parents[2]


def blocks(lane: str, language: str = "python") -> dict[str, str]:
    """The blocks that begin with "```LANGUAGE LANE", by document and number."""
    return {
        f"{path.name}-{number}": block
        for path in [*sorted(TOP.glob("*.md")), *sorted(TOP.glob("docs/*.md"))]
        for number, block in enumerate(
            re.findall(rf"^```{language} {lane}\n(.*?)^```$", path.read_text(), re.MULTILINE | re.DOTALL)
        )
    }
