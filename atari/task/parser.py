"""`Parser`: the argument parser of all commands, and types of arguments."""

import argparse
import difflib
import math
import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NoReturn

from atari.cores.options import SEED_LIMIT
from atari.task.fields import ROWS
from atari.task.resolution import OPTIONS


class HelpFormatter(argparse.HelpFormatter):
    """A formatter whose usage is short: required arguments, and [options] for the others, which the help lists."""

    def add_usage(
        self, usage: str | None, actions: Iterable[argparse.Action], groups: Any, prefix: str | None = None
    ) -> None:
        """Add the usage; a parser with subcommands keeps its own."""
        actions = list(actions)
        shown = [action for action in actions if action.required or not action.option_strings]
        if shown != actions and not any(isinstance(action, argparse._SubParsersAction) for action in actions):
            actions, groups = [*shown, argparse.Action([], "", metavar="[options]")], []
        super().add_usage(usage, actions, groups, prefix)


class Parser(argparse.ArgumentParser):
    """An argument parser with a short usage, options at any place, and errors that suggest the nearest name."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **{"formatter_class": HelpFormatter, "allow_abbrev": False, **options})
        self._intermixed = False
        for kind in (None, "store"):
            self.register("action", kind, StoreOnce)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse; an option may precede an optional argument, such as the games of `evaluate`."""
        if self._intermixed or any(action.nargs in (argparse.PARSER, argparse.REMAINDER) for action in self._actions):
            return super().parse_known_args(args, namespace)
        self._intermixed = True  # for nested calls of this method
        try:
            return self.parse_known_intermixed_args(args, namespace)
        finally:
            self._intermixed = False

    def error(self, message: str) -> NoReturn:
        """Print the usage and the error, with a suggestion, and exit with code 2."""
        super().error(self._advised(message))

    def _advised(self, message: str) -> str:
        """An error with the nearest name, or how a value that begins with a dash is given."""
        if chosen := re.search(r"invalid choice: '([^']*)' \(choose from (.*)\)", message):
            if Path(chosen[1]).is_file() and "COMMAND" in message:
                return f"{chosen[1]} is a file; name a command before it: {chosen[2]}"
            near = difflib.get_close_matches(chosen[1], re.findall(r"[\w.-]+", chosen[2]), n=1)
        elif without := re.match(r"argument (?:-\w, )?(--[\w-]+)[^:]*: expected one argument", message):
            return f"{message}; a value that begins with - is joined by =, as {without[1]}=-1"
        elif unknown := re.match(r"unrecognized arguments: (--[\w-]+)", message):
            if field := field_of_flag(unknown[1]):
                return f"{self.prog} has no place for {unknown[1]}, the field {field!r} of a task; leave it out"
            if unknown[1] == "--json":
                return "--json stands after the command's name"
            near = self._near_flags(unknown[1].replace("_", "-"))
        else:
            near = []
        return f"{message}; did you mean {near[0]!r}?" if near else message

    def _near_flags(self, wanted: str) -> list[str]:
        known = [flag for flag in self._option_string_actions if flag.startswith("--")]
        nearest = difflib.get_close_matches(wanted, known, n=1, cutoff=0.9)  # --frame-skip is no --frame
        begins = sorted((flag for flag in known if wanted.startswith(f"{flag}-")), key=len, reverse=True)
        return [*nearest, *begins, *difflib.get_close_matches(wanted, known, n=1, cutoff=0.7)]


class StoreOnce(argparse.Action):
    """The action "store", which refuses a flag that is given twice: one of the values would have no effect.

    `flags` of the parsed arguments has the names of the flags that were given.
    """

    def __call__(self, parser: argparse.ArgumentParser, namespace: Any, values: Any, flag: str | None = None) -> None:
        """Store the value of a flag, or of a word."""
        if flag is not None:
            given: frozenset[str] = getattr(namespace, "flags", frozenset())
            if self.dest in given:
                raise argparse.ArgumentError(self, "it is given twice; leave one of them out")
            namespace.flags = given | {self.dest}
        setattr(namespace, self.dest, values)


def add_refused(parser: argparse.ArgumentParser, flags: Mapping[str, str]) -> None:
    """Add flags that raise errors with these texts; `{prog}` in them is the command."""
    for flag, text in flags.items():
        parser.add_argument(
            flag, nargs="?", action=_Refused, const=text, default=argparse.SUPPRESS, help=argparse.SUPPRESS
        )


class _Refused(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        parser.error(str(self.const).replace("{prog}", parser.prog))


def flags_of(option: str) -> tuple[str, ...]:
    """The flags of an option of a task."""
    return ROWS[option].flags or (f"--{option.replace('_', '-')}",)


def field_of_flag(flag: str) -> str | None:
    """The option of a task that a flag of some command sets, or None."""
    positive = flag.replace("--no-", "--", 1)
    return next((name for name in OPTIONS if {flag, positive} & {*flags_of(name)}), None)


def as_type(read: Callable[[str], Any]) -> Callable[[str], Any]:
    """A function that reads a text as a type of argparse, which prints the errors of this kind alone."""

    def parse(text: str) -> Any:
        try:
            return read(text)
        except (TypeError, ValueError) as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return parse


def number(kind: type[int] | type[float], low: float, high: int = 10**9) -> Callable[[str], float]:
    """An argparse type that accepts numbers within `low`..`high`."""

    def parse(text: str) -> float:
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{text!r:.40} is not {_KINDS[kind]} within {low}..{high}")
        return value

    return parse


_KINDS = {int: "a whole number", float: "a number"}

seed = number(int, 0, SEED_LIMIT - 1)
"""An argparse type: a seed."""
