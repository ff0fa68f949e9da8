"""The command line as a whole: exit codes, help, errors, pipes."""

import os
import re
import subprocess
import sys
from pathlib import Path

import gymnasium
import pytest
from cli_tools import Capture, Patch, read, refused

import atari
from atari import cli
from atari.cli import main, record
from atari.task import Task
from atari.task.fields import GROUPS

COMMANDS = [
    ["info"], ["record"], ["play"], ["roms"], ["replay"],
    ["replay", "show"], ["replay", "verify"], ["replay", "render"],
    ["completion"], ["lab"], ["causes"], ["collect"],
    ["roms", "list"], ["roms", "verify"], ["roms", "identify"], ["roms", "import"], ["roms", "install"],
]  # fmt: skip


def test_version(capsys: Capture) -> None:
    assert read(capsys, "--version") == f"atari-envs {atari.__version__}\n"


def test_help_names_every_command(capsys: Capture) -> None:
    out = read(capsys, "--help")
    assert read(capsys) == out
    assert out.startswith("usage: atari [-h] [--version] COMMAND")
    assert {command[0] for command in COMMANDS} <= set(out.split())


def test_the_page_of_the_command_line_has_every_command() -> None:
    page = (Path(__file__).parents[2] / "docs" / "command-line.md").read_text(encoding="utf-8")
    named = {
        " ".join(word for word in row.split() if word.islower())
        for row in re.findall(r"^\| `atari ([^`]*)`", page, re.M)
    }
    below = {" ".join(command) for command in COMMANDS}
    assert named == (below | {*cli._COMMANDS}) - {"roms", "replay"}


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_each_command_has_help(command: list[str], capsys: Capture) -> None:
    assert main([*command, "--help"]) == 0
    captured = capsys.readouterr()
    assert captured.out.startswith(f"usage: atari {' '.join(command)}")
    assert captured.err == ""


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["replay", __file__], " is a file; name a command before it: "),
        (["play", "pong", "--intervention", "a,b"], "'a,b' has a comma; give the option once for each name"),
        (["roms"], "arguments are required: COMMAND"),
        (["paly"], "there is no command 'paly'; did you mean 'play'?"),
        (["recrod"], "there is no command 'recrod'; did you mean 'record'?"),
        (["xyz"], "invalid choice: 'xyz'"),
        (["replay", "verfy"], "did you mean 'verify'?"),
        (["replay", "verfy"], "usage: atari replay [-h]"),
        (["replay", "verify", "a.a26r", "--core", "plian"], "did you mean 'plain'?"),
        (["record", "pong", "--secnds", "2"], "did you mean '--seconds'?"),
        (["record", "pong", "--protocol", "dopamine"], "unrecognized arguments: --protocol dopamine"),
        (["completion", "bsh"], "did you mean 'bash'?"),
        (["play"], "arguments are required: GAME"),
        (["record"], "arguments are required: GAME"),
        (["replay"], "arguments are required: COMMAND"),
        (["replay", "verify"], "arguments are required: FILE"),
        (["info", "breakout", "pong"], "unrecognized arguments: pong"),
        (["info", "--i"], "unrecognized arguments: --i"),
        (["record", "pong", "--secnds", "2"], "usage: atari record GAME [options] "),
        (["replay", "show", "a.a26r", "--core", "ale"], "usage: atari replay show FILE [options] "),
        (["roms", "identify"], "arguments are required: FILE"),
        (["record", "pong", "--seconds", "nan"], "'nan' is not a number within 0.1..1000000000"),
        (["record", "pong", "--seconds", "inf"], "'inf' is not a number within 0.1..1000000000"),
        (["record", "pong", "--steps", "5", "--seconds", "5"], "not allowed with argument"),
        (["record", "pong", "--steps", "0"], "'0' is not a whole number within 1..1000000000"),
    ],
)
def test_wrong_usage_is_2(words: list[str], text: str, capsys: Capture) -> None:
    assert not refused(capsys, words, text, 2)


@pytest.mark.parametrize("words", ["random --json pong", "random pong --json", "--json random pong"])
def test_an_option_stands_before_between_or_after_the_arguments(words: str, capsys: Capture) -> None:
    assert Task.from_json(read(capsys, "evaluate", *words.split(), "--print-task")).game == "pong"


def test_flags_are_in_groups_and_the_usage_is_one_line(capsys: Capture) -> None:
    usage, *rest = read(capsys, "record", "--help").splitlines()
    assert usage == "usage: atari record GAME [options]"
    titles = [line for line in rest if line.endswith(":") and not line.startswith(" ")]
    fields = [f"what is played: {group}:" for group in GROUPS]
    assert titles == ["positional arguments:", "options:", "what is played:", *fields]


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (ValueError("a\nb  c"), "a b c"),
        (FileNotFoundError(2, "No such file or directory", "x.bin"), "No such file or directory: x.bin"),
        (OSError(28, "No space left on device"), "No space left on device"),
        (PermissionError("x.bin may not be read"), "x.bin may not be read"),
        (gymnasium.error.NameNotFound("there is no such thing"), "there is no such thing"),
        (RuntimeError("broken"), "broken"),
    ],
)
def test_errors_of_the_library_are_one_line_and_1(
    error: Exception, line: str, capsys: Capture, monkeypatch: Patch
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(record, "_play", fail)
    assert main(["record", "pong", "--no-video", "--json"]) == 1
    captured = capsys.readouterr()
    assert captured.err == f"atari: error: {line}\n"
    assert captured.out == ""


def test_a_bug_shows_its_traceback(monkeypatch: Patch) -> None:
    monkeypatch.setattr(record, "_play", lambda *_: 1 // 0)
    with pytest.raises(ZeroDivisionError):
        main(["record", "pong", "--no-video", "--json"])


def test_ctrl_c_is_130(capsys: Capture, monkeypatch: Patch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(record, "_play", interrupt)
    assert main(["record", "pong", "--no-video", "--json"]) == 130
    assert capsys.readouterr().err == "atari: interrupted\n"


def test_python_m_atari_is_the_command_line() -> None:
    command = [sys.executable, "-m", "atari", "info", "breakuot"]
    unknown = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert (unknown.returncode, unknown.stdout) == (1, "")
    assert unknown.stderr == "atari: error: there is no game 'breakuot'; did you mean 'breakout'?\n"


def test_a_reader_that_has_gone_ends_the_command_quietly() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "atari", "info", "--ids"]
    result = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, timeout=120, check=False)
    os.close(writer)
    assert (result.returncode, result.stderr) == (0, b"")
