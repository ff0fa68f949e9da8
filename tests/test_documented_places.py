"""The places in the code that CONTRIBUTING.md and docs/architecture.md name exist: files, folders and symbols."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

TOP = Path(__file__).parent.parent
ROOTS = (TOP, TOP / "atari", TOP / "atari" / "emulator")
"""A path in the two documents begins at one of these."""
DOCUMENTS = ("CONTRIBUTING.md", "docs/architecture.md")
SUFFIXES = (".py", ".cpp", ".hpp", ".def", ".toml", ".md", ".yml")
MADE = {"build/site"}
"""Paths that a command makes."""


def quoted(text: str) -> list[str]:
    return re.findall(r"`([^`\n]+)`", text)


def is_path(name: str) -> bool:
    return bool(re.fullmatch(r"[\w./*<>-]+", name)) and ("/" in name or name.endswith(SUFFIXES))


def files(name: str, *beside: Path) -> list[Path]:
    """The files or folders of a path; `<id>` and `*` stand for any text."""
    pattern = re.sub(r"<\w+>", "*", name.removeprefix("./")).rstrip("/")
    for root in (*ROOTS, *beside):
        found = sorted(root.glob(pattern))
        if found:
            return found
    return []


def names_in_python(file: Path) -> Iterator[str]:
    """The names that a module defines, with `Class.member` for members, and its strings."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ClassDef):
            yield from (f"{node.name}.{member}" for child in node.body for member in defined(child))
        yield from defined(node)
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def defined(node: ast.AST) -> Iterator[str]:
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        yield node.name
    elif isinstance(node, ast.Assign | ast.AnnAssign):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        yield from (target.id for target in targets if isinstance(target, ast.Name))


def has(file: Path, symbol: str) -> bool:
    if file.suffix == ".py":
        return symbol in names_in_python(file)
    text = re.sub(r"//.*", "", file.read_text(encoding="utf-8"))
    return re.search(rf"(?<!\w){re.escape(symbol)}(?!\w)", text) is not None


def rows() -> list[tuple[str, str]]:
    """The questions and answers of "Where is what"."""
    section = (TOP / "CONTRIBUTING.md").read_text().split("## Where is what", 1)[1].split("\n## ", 1)[0]
    return re.findall(r"^\| (.+\?) \| (.+) \|$", section, re.MULTILINE)


def places_of(answer: str) -> tuple[list[Path], list[str]]:
    """The files that an answer names, a bare name beside the file before it, and the symbols that it names."""
    found: list[Path] = []
    for name in filter(is_path, quoted(answer)):
        here = files(name, *(path.parent for path in reversed(found)))
        assert here, f"{name} does not exist"
        found += here
    return found, [name for name in quoted(answer) if not is_path(name)]


@pytest.mark.parametrize(("question", "answer"), rows())
def test_an_answer_names_files_and_what_they_define(question: str, answer: str) -> None:
    found, symbols = places_of(answer)
    assert found
    for symbol in symbols:
        assert any(has(file, symbol) for file in found), f"{symbol} is in none of {[file.name for file in found]}"


@pytest.mark.parametrize("document", DOCUMENTS)
def test_each_path_exists(document: str) -> None:
    text = (TOP / document).read_text()
    text = (
        text.replace(text[text.find("## Where is what") : text.find("## Test lanes")], "") if "lanes" in text else text
    )
    for name in quoted(text):
        for word in name.split():
            if is_path(word) and not word.startswith((".venv", "../")) and word not in MADE:
                assert files(word), f"{document}: {word} does not exist"


def test_a_symbol_with_its_file_is_there() -> None:
    """Prose writes these pairs as "`symbol` (`file`)"."""
    text = (TOP / "docs" / "architecture.md").read_text()
    pairs = re.findall(r"`([^`\n]+)`\s\(`([^`\n]+)`\)", text)
    assert len(pairs) >= 8
    for symbol, name in pairs:
        found = files(name)
        assert found, f"{name} does not exist"
        assert any(has(file, symbol.split("(")[0]) for file in found), f"{symbol} is not in {name}"


def test_the_table_of_folders_has_all() -> None:
    section = (TOP / "docs" / "architecture.md").read_text().split("## The folders", 1)[1].split("\n## ", 1)[0]
    listed = {
        found
        for cell in re.findall(r"^\| ([^|]+) \|", section, re.MULTILINE)
        for name in quoted(cell)
        for found in files(name)
    }
    missing = [
        folder.relative_to(TOP).as_posix()
        for parent in ROOTS
        for folder in [*parent.iterdir()]
        if folder.is_dir()
        and any(folder.rglob("*.[ch]pp")) | any(folder.glob("*.py"))
        and (parent != TOP or folder.name in ("wrappers", "roms"))
        and folder not in listed
        and folder.name != "emulator"
    ]
    assert not missing, f"docs/architecture.md has no row for {missing}"
