"""The environment variable ATARI_JIT: translated code, handlers, or an error."""

import os
import platform
import subprocess
import sys

import pytest
from atari_inspection import Console
from emulator.machines import rom

import atari._emulator as _emulator

RUNS = "import atari; atari.cores.NativeCore('pong').act(0); print(atari._emulator.translator())"


def run(value: str) -> subprocess.CompletedProcess[str]:
    """A new process that plays: each process translates the cartridge of a game once."""
    environment = {**os.environ, "ATARI_JIT": value}
    return subprocess.run([sys.executable, "-c", RUNS], env=environment, capture_output=True, text=True, timeout=120)


def test_handlers_run_all_code_with_0(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATARI_JIT", "0")
    assert _emulator.translator() is None
    assert not Console(rom(), "4K", plain=False, translated=True).translated
    assert run("0").stdout == "None\n"


def test_1_demands_translated_code(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATARI_JIT", "1")
    processor = {"x86_64": "x86-64", "amd64": "x86-64", "aarch64": "arm64", "arm64": "arm64"}[
        platform.machine().lower()
    ]
    assert _emulator.translator() == processor
    assert Console(rom(), "4K", plain=False, translated=True).translated
    assert run("1").stdout == f"{processor}\n"


@pytest.mark.parametrize("value", ["2", "on", " 1"])
def test_another_value_is_an_error(monkeypatch: pytest.MonkeyPatch, value: str) -> None:
    monkeypatch.setenv("ATARI_JIT", value)
    sentence = f"the environment variable ATARI_JIT is '{value}'; it must be 0"
    for call in (_emulator.translator, lambda: Console(rom(), "4K", plain=False, translated=True)):
        with pytest.raises(ValueError, match=sentence):
            call()
    if value == "2":
        played = run(value)
        assert played.returncode == 1
        assert sentence in played.stderr.splitlines()[-1]


def test_empty_is_as_not_set(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATARI_JIT", "")
    empty = _emulator.translator()
    monkeypatch.delenv("ATARI_JIT")
    assert _emulator.translator() == empty
