"""The flags of all commands that take a whole number: they are bounded, and a wrong number is one sentence."""

import argparse
from collections.abc import Iterator
from importlib import import_module

import pytest

from atari import cli
from atari.task.parser import Parser

COMMANDS = tuple(name for name in cli._COMMANDS if name != "train")  # tests/learning has those of agents
WRONG = (str(10**23), "-1", "1e400", "nan", "", "1.5", "0x10", "9" * 5000)
RESOLVED_LATER = {"--mode", "--difficulty"}
"""Flags whose numbers the game decides."""


def parsers(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """A parser and its subcommands."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for inner in action.choices.values():
                yield from parsers(inner)


def takes_whole_numbers(action: argparse.Action) -> bool:
    """Whether the type of a flag reads an int."""
    if not action.option_strings or not callable(action.type):
        return False
    for text in ("4", "2", "2,5"):
        try:
            value = action.type(text)
        except (argparse.ArgumentTypeError, ValueError, TypeError):
            continue
        if type(value) is int or (isinstance(value, tuple) and type(value[0]) is int):
            return True
    return False


def flags() -> Iterator[tuple[str, str]]:
    for name in COMMANDS:
        top = Parser(prog="atari")
        import_module(f"atari.cli.{name}").register(top.add_subparsers())
        for parser in parsers(top):
            for action in filter(takes_whole_numbers, parser._actions):
                yield parser.prog.removeprefix("atari "), action.option_strings[0]


FLAGS = list(flags())


def test_the_flags_are_found() -> None:
    found = {flag for _, flag in FLAGS}
    assert {"--seed", "--seeds", "--episodes", "--frames", "--port", "--jobs", "--scale", "--num-envs"} <= found
    assert {"--frameskip", "--noops", "--stack-num", "--mode", "--players", "--threads", "--episode"} <= found


@pytest.mark.parametrize(("command", "flag"), FLAGS, ids=map(" ".join, FLAGS))
def test_a_wrong_number_is_one_sentence(command: str, flag: str, capsys: pytest.CaptureFixture[str]) -> None:
    for text in WRONG:
        words = [*command.split(), f"{flag}={text}"]
        if flag in RESOLVED_LATER:
            words += ["pong", "--print-task"]
        assert cli.main(words) in ((1, 2) if flag in RESOLVED_LATER else (2,)), text
        printed = capsys.readouterr()
        assert not printed.out
        (sentence,) = [line for line in printed.err.splitlines() if line.startswith("atari")]
        assert "Traceback" not in printed.err
        assert flag in sentence or flag in RESOLVED_LATER, sentence
