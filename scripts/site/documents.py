"""Documents of the repository that are pages of the site too, and links between them."""

import posixpath
import re
from collections.abc import Iterator
from pathlib import Path

from page import Page

ROOT = Path(__file__).parents[2]

# The place on the site of each document outside of docs/.
OUTSIDE = {
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "atari/games/SCHEMA.md": "game-files.md",
}

_LINK = re.compile(r"\[([^\]]*)\]\((?!\w+:|#)([^)#\s]+)(#[^)\s]*)?\)")
_COMMENT = re.compile(r"<!--.*?-->\n?", re.DOTALL)
_LANE = re.compile(r"^(```\w+) \w+$", re.MULTILINE)  # "```python ray": the tests' name of what the block needs


def pages() -> Iterator[Page]:
    """The documents outside of docs/, with the links of their places there."""
    for source, target in OUTSIDE.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        yield Page(target, relink(text, ROOT / source))


def relink(text: str, source: Path) -> str:
    """The text of a document with links to the pages of the site; a link to other files becomes its text.

    A link to a file that does not exist stays as it is, so that the build fails.
    """

    own = source.relative_to(ROOT).as_posix()
    folder = posixpath.dirname(own.removeprefix("docs/")) if own.startswith("docs/") else ""

    def replace(match: re.Match[str]) -> str:
        words, target, anchor = match.group(1), match.group(2), match.group(3) or ""
        place = (source.parent / target).resolve()
        if not place.is_relative_to(ROOT) or not place.exists():
            return match.group(0)
        name = place.relative_to(ROOT).as_posix()
        if name in OUTSIDE or name.startswith("docs/"):
            page = OUTSIDE.get(name, name.removeprefix("docs/").replace(".ipynb", ".md"))
            return f"[{words}]({posixpath.relpath(page, folder or '.')}{anchor})"
        return words if words.startswith("`") else f"{words} (`{name}`)"

    return _LINK.sub(replace, text)


def clean(text: str, source: Path) -> str:
    """A document of docs/ as a page: without comments and words that only tests read, with links to pages."""
    return relink(_LANE.sub(r"\1", _COMMENT.sub("", text)), source)
