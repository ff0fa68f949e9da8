"""The flags of a task: one of each field, and what they say about wrong values."""

import argparse
import json
import re
from pathlib import Path
from typing import Any

import pytest
from field_values import CASES, flags_of

import atari
from atari.task import Task
from atari.task.arguments import (
    SCREEN,
    add_task,
    descriptions,
    field_from_text,
    given_options,
    read_game,
    show_task,
    task_of,
)
from atari.task.fields import GROUPS, ROWS
from atari.task.parser import Parser, seed
from atari.task.resolution import OPTIONS

TEXTS: tuple[tuple[str, str, Any], ...] = (
    ("--actions", "NOOP,FIRE", ("NOOP", "FIRE")),
    ("--max-num-frames-per-episode", "none", None),
    ("--max-frames", "1e5", 100_000),
    ("--img-width", "none", None),
    ("--reward", "-5 * lives_lost + min(reward, 3)", "-5 * lives_lost + min(reward, 3)"),
)
"""Flags whose values are not written as Python writes them."""


def parsed(*words: str, parser: argparse.ArgumentParser | None = None) -> argparse.Namespace:
    if parser is None:
        parser = Parser(allow_abbrev=False)
        parser.add_argument("game")
        add_task(parser)
    return parser.parse_args(["pong", *words])


@pytest.mark.parametrize("name", OPTIONS)
def test_every_option_has_a_flag(name: str) -> None:
    value = CASES[name].value
    assert given_options(parsed(*flags_of(name, value))) == {name: tuple(value) if isinstance(value, list) else value}
    if isinstance(value, bool):
        assert given_options(parsed(*flags_of(name, not value))) == {name: not value}


@pytest.mark.parametrize(("flag", "text", "value"), TEXTS)
def test_values_that_have_texts_of_their_own(flag: str, text: str, value: Any) -> None:
    assert [*given_options(parsed(flag, text)).values()] == [value]


@pytest.mark.parametrize("text", ["1", "1e5", "lives, 1", "full", "none"])
def test_the_text_of_a_reward_is_not_split(text: str) -> None:
    assert field_from_text("reward", text) == (None if text == "none" else text)


def test_no_flag_is_no_option() -> None:
    args = parsed()
    assert (given_options(args), args.preset, args.print_task) == ({}, None, False)
    assert task_of(args) == Task.of("pong")


def test_other_names() -> None:
    assert given_options(parsed("--sticky", "0.5")) == {"repeat_action_probability": 0.5}
    assert given_options(parsed("--full-action-space")) == {"full_action_space": True}
    assert task_of(parsed("--full-action-space")).actions == "full"


def test_help_is_that_of_the_rows(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        parsed("--help")
    shown = "".join(capsys.readouterr().out.split())  # lines are broken at hyphens, too
    for name in OPTIONS:
        assert "".join(ROWS[name].says.split()) in shown, name


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--frameskip", "x"], "argument --frameskip: frameskip must be an integer within 1..10000, got 'x'"),
        (["--frameskip", "1.5"], "got 1.5"),
        (["--frameskip", "1,2,3"], "a frameskip range is (low, high), got (1, 2, 3)"),
        (["--noops", "3"], "argument --noops: noops must be (low, high), both included, such as (1, 30), got 3"),
        (["--fire", "always"], "fire must be one of 'never', 'before_noops', 'after_noops', got 'always'"),
        (["--sticky", "2"], "argument --repeat-action-probability/--sticky: repeat_action_probability must be"),
        (["--actions", "NOOP,JUMP"], "got 'JUMP'"),
        (["--stack-num", "0"], "stack_num must be within 1..256, got 0"),
        (["--preset", "dqn"], "argument --preset: there is no preset 'dqn'; did you mean 'dqn2015'?"),
        (["--maxpol"], "did you mean '--maxpool'?"),
    ],
)
def test_wrong_values(words: list[str], text: str, capsys: pytest.CaptureFixture[str]) -> None:
    parser = Parser(allow_abbrev=False)
    parser.add_argument("game")
    add_task(parser)
    with pytest.raises(SystemExit):
        parsed(*words, parser=parser)
    assert text in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--mode", "x"], "mode"),
        (["--padding", "reset"], "padding='reset' has no effect"),
        (["--actions", "full", "--full-action-space"], "two names of one option"),
        (["--intervention", "lazy"], "lazy"),
        (["--preset", "dqn2015", "--sticky", "0.25"], "preset 'dqn2015' needs repeat_action_probability=0.0"),
    ],
)
def test_wrong_tasks_are_value_errors(words: list[str], text: str) -> None:
    with pytest.raises(ValueError, match=re.escape(text)):
        task_of(parsed(*words))


def test_groups() -> None:
    parser = Parser(allow_abbrev=False)
    parser.add_argument("game")
    add_task(parser, ("limits", "mode"), refused=("max_frames",))
    flags = {flag for action in parser._actions for flag in action.option_strings}
    assert flags == {
        "-h", "--help", "--preset", "--print-task", "--mode", "--max-num-frames-per-episode", "--max-episode-steps"
    }  # fmt: skip
    assert sum(map(len, GROUPS.values())) == len(OPTIONS) + 3


def test_the_task_of_an_agent_and_of_a_base() -> None:
    assert task_of(parsed(), agent=True) == Task.of("pong", preset="baselines")
    assert task_of(parsed(), base={"frameskip": 1}).frameskip == 1
    assert task_of(parsed("--preset", "dopamine"), game="breakout") == Task.of("breakout", preset="dopamine")


def test_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert read_game("own.toml") == tmp_path / "own.toml"
    assert read_game("pong") == "pong"
    task = Task.of("pong", preset="dqn2015", frameskip=3)
    Path("task.json").write_text(task.to_json())
    assert read_game("task.json") == task
    assert task_of(parsed(), game="task.json") == task
    assert task_of(parsed("--frameskip", "2"), game="task.json") == task.replace(frameskip=2)


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (b"", "task.json has no task: the task is damaged: Expecting"),
        (b"\xff\xfe", "task.json has no task: the task is damaged: Expecting"),
        (b'{"format": 2, "game": "pong"}', "task.json has no task: the task is of format 2"),
        (b'{"format": 1, "game": "pong", "episodic_life": "no"}', "episodic_life must be True or False, got 'no'"),
        (b'{"format": 1, "game": "pong"' + b" " * (4 << 20), "and 1,048,576 are allowed"),
    ],
)
def test_files_without_a_task(content: bytes, text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("task.json").write_bytes(content)
    with pytest.raises(ValueError, match=re.escape(text)):
        task_of(parsed(), game="task.json")
    with pytest.raises(FileNotFoundError, match="there is no file none"):
        task_of(parsed(), game="none.json")


def by_frame(*words: str) -> argparse.Namespace:
    parser = Parser(prog="atari test", allow_abbrev=False)
    parser.add_argument("game")
    add_task(parser, ("mode", "repeat_action_probability"), fixed={**SCREEN, "frameskip": 1})
    return parser.parse_args(words)


def test_a_field_that_a_command_does_not_obey_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "task.json"
    file.write_text(Task.of("pong", noops=(1, 30)).to_json())
    with pytest.raises(ValueError, match=r"`atari test` has no place for noops=\(1, 30\); give the game alone, 'pong'"):
        task_of(by_frame(str(file)))
    file.write_text(Task.of("pong", reward_clipping=True, players=2).to_json())
    with pytest.raises(ValueError, match=r"no place for players=2; give the game alone, 'pong', or a task without it"):
        task_of(by_frame(str(file)))


def test_a_field_that_does_not_matter_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    args = by_frame("Pong-ram-v4", "--mode", "1")
    task = task_of(args)
    assert task == Task.of("pong", mode=1, repeat_action_probability=0.0, frameskip=1)
    assert not show_task(args, task)
    first = "pong: Pong, as PongNoFrameskip-v4, but mode=1, without frameskip=(2, 5), without obs_type='ram'\n"
    assert capsys.readouterr().out == first


def test_print_task(capsys: pytest.CaptureFixture[str]) -> None:
    task = atari.Task.of("pong", preset="dqn2015")
    args = parsed("--preset", "dqn2015", "--print-task")
    assert show_task(args, task_of(args))
    assert capsys.readouterr().out == f"{task}\n"
    args.json = True
    assert show_task(args, task)
    assert json.loads(capsys.readouterr().out) == json.loads(task.to_json())


def test_values_from_texts() -> None:
    assert field_from_text("actions", "FIRE") == ("FIRE",)
    assert field_from_text("actions", "minimal") == "minimal"
    assert field_from_text("frameskip", "4") == 4


def test_seeds() -> None:
    assert seed("4294967295") == 2**32 - 1
    for text in ("4294967296", "-1", "1.5"):
        with pytest.raises(argparse.ArgumentTypeError, match=rf"'{text}' is not a whole number within 0\.\.4294967295"):
            seed(text)


def test_texts_do_not_depend_on_the_indentation_of_docstrings() -> None:
    """Python 3.13 takes it off, and `python -OO` leaves docstrings out."""
    indented = type(
        "Indented",
        (),
        {"__doc__": "One.\n\n    Attributes:\n        a: first,\n            more.\n        b: second.\n    "},
    )
    even = type("Even", (), {"__doc__": "One.\n\nAttributes:\n    a: first,\n        more.\n    b: second.\n"})
    bare = type("Bare", (), {})
    assert descriptions(indented) == descriptions(even) == {"a": "first, more", "b": "second"}
    assert descriptions(bare)["a"] == ""
