"""Files that an earlier release wrote are read as they were meant, and new files are read like them."""

import json
import re
from pathlib import Path

import pytest
from file_formats import FILES, FORMATS, Format

KNOWN = json.loads((FILES / "facts.json").read_text("utf-8"))


def as_json(facts: object) -> object:
    return json.loads(json.dumps(facts))


@pytest.mark.parametrize("name", KNOWN)
def test_an_earlier_file_is_read(name: str) -> None:
    kind = next(each for each in FORMATS if each.file == re.sub(r"-\d+(?=\.)", "", name))
    assert as_json(kind.read(FILES / name)) == KNOWN[name]


@pytest.mark.parametrize("kind", FORMATS, ids=lambda kind: kind.file)
def test_a_new_file_has_the_same_content(kind: Format, tmp_path: Path) -> None:
    kind.write(tmp_path / kind.file)
    assert as_json(kind.read(tmp_path / kind.file)) == KNOWN[kind.file]


def test_each_format_has_a_file() -> None:
    assert {each.file for each in FORMATS} <= {*KNOWN}
    assert {*KNOWN} == {path.name for path in FILES.iterdir()} - {"facts.json"}
