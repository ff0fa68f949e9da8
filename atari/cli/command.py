"""What all commands share: how one is declared, and how it prints a result."""

import argparse
import dataclasses
import enum
import json
import math
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction[argparse.ArgumentParser]


def add_command(
    commands: "Commands", name: str, run: Callable[[argparse.Namespace], int], help_: str
) -> argparse.ArgumentParser:
    """Add a command that calls `run` with the parsed arguments and ends with the exit code it returns."""
    parser = commands.add_parser(name, help=help_, description=f"{help_[0].upper()}{help_[1:]}.", allow_abbrev=False)
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.set_defaults(run=run)
    return parser


def plain(value: Any) -> Any:
    """A value made of dataclasses, mappings, sequences, enums and paths, in what JSON has."""
    if isinstance(value, enum.Enum):
        return value.name
    if dataclasses.is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return str(value) if isinstance(value, Path) else value


def print_json(value: Any) -> None:
    """Print what `plain` accepts as one JSON document."""
    print(json.dumps(plain(value), indent=2))


def print_table(rows: Iterable[Sequence[object]]) -> None:
    """Print rows as columns as wide as they need to be."""
    lines = [[str(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        print("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip())


def print_error(error: Exception) -> None:
    """Print what an exception says to stderr, in one line and without error numbers."""
    if isinstance(error, OSError) and error.strerror:
        sentence = error.strerror + (f": {error.filename}" if error.filename else "")
    else:
        sentence = " ".join(str(error).split())
    print(f"atari: error: {sentence}", file=sys.stderr)


def print_warning(warning: object) -> None:
    """Print a warning to stderr, in one line."""
    print(f"atari: warning: {warning}", file=sys.stderr)


@contextmanager
def ctrl_c_noticed() -> Iterator[Event]:
    """Turn Ctrl-C into an event, so that it ends the play between two steps and tears no frame; a second one acts."""
    interrupted = Event()

    def notice(*_: object) -> None:
        interrupted.set()
        signal.signal(signal.SIGINT, before)

    before = signal.signal(signal.SIGINT, notice)
    try:
        yield interrupted
    finally:
        signal.signal(signal.SIGINT, before)


def number(kind: type[int] | type[float], low: float) -> Callable[[str], float]:
    """A type for argparse: numbers of at least `low`."""

    def parse(text: str) -> float:
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not low <= value < math.inf:
            raise argparse.ArgumentTypeError(f"{text!r} is not {_KINDS[kind]} of at least {low}")
        return value

    return parse


_KINDS = {int: "a whole number", float: "a number"}
