"""`atari verify --machine`, and the switches of unproven machine code."""

import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from atari.cli import main
from atari.cores.host_check import differences, machine, read_goldens

GOLDENS = Path(__file__).parents[1] / "conformance" / "goldens.json"
LEVELS = ("scalar", "simd128", "avx2", "avx512")


def run(code: str, **variables: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env={**os.environ, **variables}, check=False
    )


def test_the_goldens_are_those_of_the_conformance_tests() -> None:
    games = json.loads(GOLDENS.read_text())["games"]
    goldens = read_goldens()
    assert len(goldens) == 10
    assert goldens == {game: games[game]["random"] for game in goldens}


def test_this_machine_is_exact(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "--machine"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1] == f"SIMD level: {machine().simd}"
    assert lines[2] == f"translator: {machine().translator or 'off'}"
    assert lines[-1] == "10 games of 1000 frames compared with ale-py's check sums, 0 differ"


def test_a_wrong_machine_is_named(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    right = {"pong": read_goldens()["pong"]}
    assert differences("pong", right["pong"]) == []
    monkeypatch.setattr("atari.cli.verify.read_goldens", lambda: right)
    assert main(["verify", "--machine", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["differences"] == {}
    goldens = {"pong": {**right["pong"], "ram": "00000000", "reward": 5}}
    monkeypatch.setattr("atari.cli.verify.read_goldens", lambda: goldens)
    assert main(["verify", "--machine"]) == 1
    out = capsys.readouterr().out
    assert "pong: ram is " in out
    assert "reward is " in out
    assert "1 differ" in out


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["--machine", "pong"], "--machine plays its own ten games; leave its games out"),
        (["--machine", "--frames", "5"], "--machine plays its own ten games; leave --frames out"),
        (["--machine", "--mode", "1"], "leave --mode out"),
        (["--replay", "a.json", "--seeds", "3"], "--replay plays what its file says; leave --seeds out"),
        (["--replay", "a.json", "--machine"], "leave --replay out"),
    ],
)
def test_options_without_effect_are_refused(
    arguments: list[str], text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["verify", *arguments]) == 1
    assert text in capsys.readouterr().err


@pytest.mark.parametrize("level", LEVELS)
def test_each_level_is_exact_or_refused(level: str) -> None:
    """The highest level is that of the test in this process, above, unless `ATARI_SIMD` is set."""
    supported = LEVELS[: LEVELS.index(_supported()) + 1]
    if level == supported[-1] == machine().simd:
        return
    done = run("from atari.cli import main; main(['verify', '--machine'])", ATARI_SIMD=level)
    if level in supported:
        assert (done.returncode, f"SIMD level: {level}" in done.stdout) == (0, True), done.stderr
        assert "0 differ" in done.stdout
    else:
        assert f"ATARI_SIMD is '{level}'; this processor supports {', '.join(supported)}" in done.stderr


@cache
def _supported() -> str:
    """The highest level of this processor, which the error of a level that does not exist lists last."""
    error = run("import atari", ATARI_SIMD="sse9")
    assert error.returncode == 1
    text = "the environment variable ATARI_SIMD is 'sse9'; this processor supports scalar"
    assert text in error.stderr
    return error.stderr.split()[-1]
