"""Helpers of the tests of the command line: run a command and read its output."""

import json
from typing import Any

import pytest

from atari.cli import main


def read(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(words) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    return captured.out


def read_json(capsys: pytest.CaptureFixture[str], *words: str) -> Any:
    return json.loads(read(capsys, *words, "--json"))
