"""Helpers of the tests of the command line: run a command and read its output."""

import json
from typing import Any, TypeAlias

import pytest

from atari.cli import main

Capture: TypeAlias = pytest.CaptureFixture[str]
Patch: TypeAlias = pytest.MonkeyPatch


def read(capsys: Capture, *words: str) -> str:
    assert main(words) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    return captured.out


def read_json(capsys: Capture, *words: str) -> Any:
    return json.loads(read(capsys, *words, "--json"))


def record_json(capsys: Capture, *words: str) -> Any:
    """The result of `atari record`, which prints its progress to stderr."""
    assert main(["record", *words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def refused(capsys: Capture, words: list[str], text: str, code: int = 1) -> str:
    """Check that a command ends with an error that has a text, of one line unless it is about the usage.

    Returns its output before that.
    """
    assert main(words) == code
    out, err = capsys.readouterr()
    assert text in " ".join(err.split())
    assert code == 2 or (err.startswith("atari: error: ") and err.count("\n") == 1), err
    return out
