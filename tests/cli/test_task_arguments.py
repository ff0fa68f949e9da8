"""The flags of a task: one of each field, and what they say about wrong values."""

import argparse
import json
import re
from pathlib import Path
from typing import Any

import pytest

import atari
from atari.cli.arguments import Parser
from atari.cli.task_arguments import add_task, game_or_file, print_task, seed, task_of
from atari.task import Task
from atari.task.arguments import descriptions, given_options, option_of
from atari.task.fields import GROUPS
from atari.task.resolution import OPTIONS
from atari.task.task import DEFAULTS

TEXTS: dict[str, tuple[list[str], Any]] = {
    "mode": (["--mode", "1"], 1),
    "difficulty": (["--difficulty", "1"], 1),
    "players": (["--players", "2"], 2),
    "actions": (["--actions", "NOOP,FIRE"], ("NOOP", "FIRE")),
    "continuous": (["--continuous"], True),
    "continuous_action_threshold": (["--continuous-action-threshold", "0.25"], 0.25),
    "repeat_action_probability": (["--repeat-action-probability", "0.5"], 0.5),
    "frameskip": (["--frameskip", "2,5"], (2, 5)),
    "interventions": (["--intervention", "a", "--intervention", "b.toml#c"], ("a", "b.toml#c")),
    "noops": (["--noops", "1,30"], (1, 30)),
    "fire": (["--fire", "after_noops"], "after_noops"),
    "fire_unit": (["--fire-unit", "skip"], "skip"),
    "fire_again": (["--no-fire-again"], False),
    "seeding": (["--seeding", "ale"], "ale"),
    "lives_unit": (["--lives-unit", "skip"], "skip"),
    "on_reset": (["--on-reset", "noop"], "noop"),
    "max_num_frames_per_episode": (["--max-num-frames-per-episode", "none"], None),
    "max_frames": (["--max-frames", "1e5"], 100_000),
    "max_episode_steps": (["--max-episode-steps", "7"], 7),
    "obs_type": (["--obs-type", "grayscale"], "grayscale"),
    "img_height": (["--img-height", "84"], 84),
    "img_width": (["--img-width", "none"], None),
    "stack_num": (["--stack-num", "4"], 4),
    "padding": (["--padding", "reset"], "reset"),
    "end_frames": (["--end-frames", "baselines"], "baselines"),
}
"""The flags of options that are not bool, and of some that are."""


def parsed(*words: str, parser: argparse.ArgumentParser | None = None) -> argparse.Namespace:
    if parser is None:
        parser = Parser(allow_abbrev=False)
        parser.add_argument("game")
        add_task(parser)
    return parser.parse_args(["pong", *words])


@pytest.mark.parametrize("name", OPTIONS)
def test_every_option_has_a_flag(name: str) -> None:
    words, value = TEXTS.get(name, ([f"--{name.replace('_', '-')}"], True))
    assert given_options(parsed(*words)) == {name: value}
    if name not in TEXTS:
        assert DEFAULTS[name] is False
        assert given_options(parsed(f"--no-{name.replace('_', '-')}")) == {name: False}


def test_no_flag_is_no_option() -> None:
    args = parsed()
    assert (given_options(args), args.preset, args.print_task) == ({}, None, False)
    assert task_of(args) == Task.of("pong")


def test_other_names() -> None:
    assert given_options(parsed("--sticky", "0.5")) == {"repeat_action_probability": 0.5}
    assert given_options(parsed("--full-action-space")) == {"full_action_space": True}
    assert task_of(parsed("--full-action-space")).actions == "full"


def test_help_is_that_of_the_class(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        parsed("--help")
    shown = "".join(capsys.readouterr().out.split())  # lines are broken at hyphens, too
    for name in OPTIONS:
        assert "".join(descriptions(Task)[name].split()) in shown, name


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--frameskip", "x"], "argument --frameskip: frameskip must be an integer within 1..10000, got 'x'"),
        (["--frameskip", "1.5"], "got 1.5"),
        (["--frameskip", "1,2,3"], "a frameskip range is (low, high), got (1, 2, 3)"),
        (["--noops", "3"], "argument --noops: noops must be (low, high), both included, such as (1, 30), got 3"),
        (["--fire", "always"], "fire must be one of 'never', 'before_noops', 'after_noops', got 'always'"),
        (
            ["--sticky", "2"],
            "argument --repeat-action-probability/--sticky: repeat_action_probability must be within 0..1",
        ),
        (["--actions", "NOOP,JUMP"], "got 'JUMP'"),
        (["--stack-num", "0"], "stack_num must be within 1..10000, got 0"),
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
    add_task(parser, ("limits", "mode"), leave_out=("max_frames",))
    flags = {flag for action in parser._actions for flag in action.option_strings}
    assert flags == {
        "-h", "--help", "--preset", "--print-task", "--mode", "--max-num-frames-per-episode", "--max-episode-steps"
    }  # fmt: skip
    assert sum(map(len, GROUPS.values())) == len(OPTIONS) + 3


def test_the_task_of_an_agent_and_of_a_base() -> None:
    assert task_of(parsed(), agent=True) == Task.of("pong", preset="baselines")
    assert task_of(parsed(), base={"frameskip": 1}).frameskip == 1
    assert task_of(parsed("--preset", "dopamine"), game="breakout") == Task.of("breakout", preset="dopamine")


def test_files_are_absolute(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert game_or_file("own.toml") == tmp_path / "own.toml"
    assert game_or_file("pong") == "pong"


def test_print_task(capsys: pytest.CaptureFixture[str]) -> None:
    task = atari.Task.of("pong", preset="dqn2015")
    print_task(task, as_json=False)
    assert capsys.readouterr().out == f"{task}\n"
    print_task(task, as_json=True)
    assert json.loads(capsys.readouterr().out) == json.loads(task.to_json())


def test_values_from_texts() -> None:
    assert option_of("actions", "FIRE") == ("FIRE",)
    assert option_of("actions", "minimal") == "minimal"
    assert option_of("frameskip", "4") == 4


def test_seeds() -> None:
    assert seed("4294967295") == 2**32 - 1
    for text, message in (
        ("4294967296", "a seed must be within 0..4294967295, got 4294967296"),
        ("-1", "got -1"),
        ("1.5", "a seed must be a whole number, got '1.5'"),
    ):
        with pytest.raises(argparse.ArgumentTypeError, match=re.escape(message)):
            seed(text)
