"""`--modern` and `--write`: the diff of a file and its rewritten form, and the file that takes its place."""

import ast
import difflib
import io
import os
import re
import sys
import tokenize
from pathlib import Path

from atari.base import durable
from atari.base.program import print_exact
from atari.base.validation import check_file
from atari.classic.rewrite import modernized
from atari.classic.rewrite.notebook import Notebook
from atari.classic.rewrite.source import Source

_PYTHON_2 = re.compile(
    r"""^\s*(print\s+[^\s(=]|print\s*>>|exec\s+["'\w]|raise\s+\w+\s*,|except\s+[\w.() ,]+,\s*\w+\s*:)"""
    r"""|<>|\bur["']|\b0\d+\b|`""",
)
HINT = "this is Python 2; `2to3 -w FILE` of Python 3.12 or older converts it, then try again"


class OldFile:
    """A script or a notebook, as it was read.

    Attributes:
        path: its path.
        before: the code before, for the diff.
        after: the code after.
        marks: the number of places that a person must check.

    Raises:
        OSError: there is no such file, or it cannot be read.
        ValueError: it is no text, no notebook, or not this version of Python.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._data = check_file(path, "name the scripts and notebooks in it").read_bytes()
        self._encoding = "utf-8" if path.suffix == ".ipynb" else _encoding(path, self._data)
        try:
            text = self._data.decode(self._encoding)
        except UnicodeDecodeError as error:
            raise ValueError(f"{path} is not text in {self._encoding}: {error}") from error
        if path.suffix == ".ipynb":
            self._read_notebook(text)
            return
        source = _rewritten(path, text)
        self.before, self.after, self.marks = text, source.result(), source.marks
        self._new = self.after

    def _read_notebook(self, text: str) -> None:
        try:
            notebook = Notebook(text)
        except ValueError as error:
            raise ValueError(f"{self.path}: {error}") from error
        self.before = notebook.code()
        source = _rewritten(self.path, notebook.script)
        self._new = notebook.result(source)
        self.after, self.marks = notebook.code(), source.marks

    def diff(self) -> str:
        """The changes in the format of `diff -u`; empty if there are none."""
        before, after = (re.sub(r"\r\n?", "\n", text).splitlines(keepends=True) for text in (self.before, self.after))
        lines = difflib.unified_diff(before, after, str(self.path), f"{self.path} (modern)")
        return "".join(
            line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n" for line in lines if line
        )

    def write(self) -> bool:
        """Replace the file, and keep its old text as NAME.orig; whether there was something to change.

        Raises:
            OSError: the file cannot be written; it is as it was.
            ValueError: the file is a link, has other names, or changed since it was read, or another NAME.orig exists.
        """
        path, data = self.path, self._new.encode(self._encoding)
        if data == self._data:
            return False
        kept = path.with_name(path.name + ".orig")
        self._check(path, kept)
        if not os.path.lexists(kept):
            durable.write_file(kept, self._data)
        part = durable.write_part(path, data)
        try:
            os.chmod(part, path.stat().st_mode & 0o7777)
            self._check(path, kept)
        except BaseException:
            durable.discard(path)
            raise
        durable.publish(path)
        return True

    def _check(self, path: Path, kept: Path) -> None:
        if path.is_symlink():
            raise ValueError(f"{path} is a link, which --write does not replace; give it the file {path.resolve()}")
        if path.stat().st_nlink > 1:
            raise ValueError(
                f"{path} has a second name (a hard link), which --write would separate from it; copy it first"
            )
        if path.read_bytes() != self._data:
            raise ValueError(f"{path} has changed since it was read; run the command again")
        if os.path.lexists(kept) and (kept.is_symlink() or kept.read_bytes() != self._data):
            raise ValueError(f"{kept} exists with another text, and --write keeps the old text there; move it away")


def modernize(words: list[str]) -> int:
    """Print what `--modern` would change in files, and change them with `--write`; the exit code of the command.

    Raises:
        OSError, ValueError: see `OldFile`.
    """
    write = "--write" in words
    paths = [Path(word) for word in words if word != "--write"]
    unknown = [word for word in words if word.startswith("-") and word != "--write"]
    if unknown or not paths:
        wrong = no_option(unknown[0], ["--write"]) if unknown else "--modern takes at least one file"
        print(f"atari.classic: {wrong}; usage: python -m atari.classic --modern FILE... [--write]", file=sys.stderr)
        return 2
    for path in paths:
        _modernize_file(OldFile(path), write)
    return 0


def _modernize_file(file: OldFile, write: bool) -> None:
    print_exact(file.diff())
    if file.before == file.after:
        said = "nothing to change"
    elif write and file.write():
        said = f"changed; the old text is in {file.path.name}.orig"
    else:
        said = "not changed; --write changes it"
    left = f"; {file.marks} to check by hand, after `# atari.classic:`" if file.marks else ""
    print(f"atari.classic: {file.path}: {said}{left}", file=sys.stderr)


def no_option(word: str, options: list[str]) -> str:
    """The sentence about an unknown option, with the one that may be meant."""
    near = difflib.get_close_matches(word, options, 1)
    return f"there is no option {word}" + (f"; did you mean {near[0]}?" if near else "")


def is_python_2(path: Path) -> bool:
    """Whether a script has a syntax error because it is in Python 2."""
    try:
        ast.parse(path.read_bytes())
    except (SyntaxError, ValueError) as error:
        return _is_python_2(str(getattr(error, "text", "") or "").strip(), error)
    return False


def _is_python_2(row: str, error: SyntaxError | ValueError) -> bool:
    """Whether the line of a syntax error is Python 2."""
    said = str(getattr(error, "msg", error))
    return bool(_PYTHON_2.search(row)) or any(each in said for each in ("print", "exec", "multiple exception types"))


def _rewritten(path: Path, text: str) -> Source:
    try:
        source = modernized(text)
    except (SyntaxError, ValueError) as error:
        line = getattr(error, "lineno", None) or 1
        rows = text.splitlines() or [""]
        row = rows[min(line, len(rows)) - 1].strip()
        said = str(getattr(error, "msg", error))
        raise ValueError(f"{path}, line {line}: {HINT if _is_python_2(row, error) else said} ({row})") from error
    try:
        ast.parse(source.result())
    except SyntaxError as error:
        raise ValueError(
            f"{path} is not understood, its new line {error.lineno} would be an error; it stays"
        ) from error
    return source


def _encoding(path: Path, data: bytes) -> str:
    if b"\0" in data or data.startswith((b"%PDF-", b"\x89PNG", b"GIF8", b"\xff\xd8\xff")):
        raise ValueError(f"{path} is not text, and so no Python script; name a script or a notebook")
    try:
        return tokenize.detect_encoding(io.BytesIO(data).readline)[0]
    except SyntaxError as error:
        raise ValueError(
            f"{path} is not text in UTF-8, and so no Python script, or its first line must name its encoding, such as "
            f"`# -*- coding: latin-1 -*-` ({error.msg})"
        ) from error
