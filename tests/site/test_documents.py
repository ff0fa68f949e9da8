"""The documents as files of a checkout: tables made from data are up to date, and every link has a place."""

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import cv2
import pytest
import site_modules

import atari

TOP = Path(__file__).resolve().parents[2]
LISTED = subprocess.run(
    ["git", "ls-files", "*.md"], cwd=TOP, capture_output=True, text=True, check=False
).stdout.split()
DOCUMENTS = LISTED or [
    path.relative_to(TOP).as_posix() for path in (*TOP.glob("*.md"), *TOP.glob("docs/*.md"), *TOP.glob("atari/**/*.md"))
]


TABLES = site_modules.load("tables", "generate")

START = (TOP / "mkdocs.yml").read_text(encoding="utf-8").partition("  - Start:\n")[2].partition("  - Recipes:\n")[0]
FIRST = ["README.md", *(f"docs/{page}" for page in re.findall(r"[\w-]+\.md", START))]
BLOCK = re.compile(r"^ *```[^\n]*\n(.*?)^ *```$", re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("name", TABLES.DOCUMENTS)
def test_tables_are_those_of_the_data(name: str) -> None:
    if name == "learning.md":
        pytest.importorskip("torch")
    text = (TOP / "docs" / name).read_text(encoding="utf-8")
    assert TABLES.filled(text) == text, f"{name} is old: run scripts/generate/tables.py"


def test_every_table_has_a_place() -> None:
    texts = [(TOP / "docs" / name).read_text(encoding="utf-8") for name in TABLES.DOCUMENTS]
    found = [table for text in texts for table in re.findall(r"<!-- table: ([\w.]+) -->", text)]
    assert sorted(found) == sorted(TABLES.TABLES)


def links(text: str) -> Iterator[str]:
    """The targets of the links of a document to other files, outside of code."""
    code = re.compile(r"```.*?```|`[^`\n]*`", re.DOTALL)
    for target in re.findall(r"\]\(([^)\s]+)\)", code.sub("", text)):
        if not re.match(r"\w+:", target):
            yield target


def anchor(title: str) -> str:
    """The anchor of a headline, as GitHub and MkDocs make it."""
    words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", title).replace("`", "").replace("*", "").strip().lower()
    return re.sub(r"[^\w\- ]", "", words).replace(" ", "-")


def dead(file: Path, text: str) -> Iterator[str]:
    """The links of a document that have no place in a checkout."""
    for target in links(text):
        path, _, part = target.partition("#")
        place = file.parent / path if path else file
        if not place.exists():
            yield target
        elif part and place.suffix == ".md":
            headlines = re.findall(r"^#+ (.*)$", place.read_text(encoding="utf-8"), re.MULTILINE)
            if part not in map(anchor, headlines):
                yield target


@pytest.mark.parametrize("name", DOCUMENTS)
def test_no_link_is_dead(name: str) -> None:
    file = TOP / name
    assert list(dead(file, file.read_text(encoding="utf-8"))) == []


def test_a_dead_link_is_found() -> None:
    file = TOP / "docs" / "tasks.md"
    text = "[a](tasks.md) [b](nothing.md) [c](tasks.md#no-such-part) `[d](nothing.md)` [e](https://example.org/x)"
    assert list(dead(file, text)) == ["nothing.md", "tasks.md#no-such-part"]


@pytest.mark.parametrize("name", FIRST)
def test_code_of_the_first_pages_fits_beside_the_navigation(name: str) -> None:
    lines = [line for block in BLOCK.findall((TOP / name).read_text(encoding="utf-8")) for line in block.splitlines()]
    assert lines
    assert [line for line in lines if len(line) > 75] == []


def test_the_readme_shows_what_its_evaluation_prints(capsys: pytest.CaptureFixture[str]) -> None:
    text = (TOP / "README.md").read_text(encoding="utf-8")
    code, shown = BLOCK.findall(text[text.index("**Evaluate and compare**") :])[:2]
    exec(code, {})
    assert shown in capsys.readouterr().out


def test_the_observations_of_the_presets_can_be_seen() -> None:
    """Each of the nine rows has 20 lines of words, then 84 of observations; those in the middle are in play."""
    picture = cv2.imread(str(TOP / "docs" / "assets" / "presets.png"), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    rows = picture[20:].reshape(len(atari.PRESETS), 104, -1)[:, 20:, 356:700]
    assert (rows > 30).mean(axis=(1, 2)).min() > 0.6
