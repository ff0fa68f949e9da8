#!/usr/bin/env python
"""Writes the typed options of a task into atari/task/options.py, from the rows of atari/task/fields.py.

    scripts/generate/options.py          # writes the file
    scripts/generate/options.py --check  # fails if the file would change; a test calls this

Type checkers run no code, so the options have to stand in the source.
"""

import argparse
import ast
import inspect
import sys
from collections.abc import Iterable
from pathlib import Path

from atari.env import AtariEnv
from atari.task.fields import ROWS
from atari.task.resolution import ALIASES, OPTIONS

TASK = Path(__file__).resolve().parents[2] / "atari" / "task"
FILE = TASK / "options.py"
BEGIN, END = (
    "# Begin of what scripts/generate/options.py writes.\n",
    "# End of what scripts/generate/options.py writes.\n",
)
BY_HAND = ("mode", "difficulty")
"""Options with other types in a vector."""


def types() -> dict[str, str]:
    """The type of each option, as it stands in the source."""
    tree = ast.parse((TASK / "fields.py").read_text(encoding="utf-8"))
    fields = next(node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == "TaskFields")
    of_fields = {
        ast.unparse(one.target): ast.unparse(one.annotation) for one in fields.body if isinstance(one, ast.AnnAssign)
    }
    found = {name: ROWS[name].accepts or of_fields[name] for name in OPTIONS if name not in BY_HAND}
    return {**found, **dict.fromkeys(ALIASES, "bool | None")}


def class_of(head: str, doc: str, names: Iterable[str]) -> str:
    """The source of a class of options."""
    found = types()
    lines = [f"class {head}:", f'    """{doc}"""', "", *(f"    {name}: {found[name]}" for name in names)]
    return "\n".join(lines) + "\n"


def written(text: str) -> str:
    """A source file with its block made anew."""
    named = inspect.signature(AtariEnv.__init__).parameters
    added = [name for name in types() if name not in named]
    shared = [name for name in types() if name in named]
    block = "\n\n".join(
        [
            class_of("AddedOptions(TypedDict, total=False)", "The options that `AtariEnv` does not name.", added),
            class_of("_Shared(AddedOptions, total=False)", "All options with one type in all functions.", shared),
        ]
    )
    before, rest = text.split(BEGIN)
    return f"{before}{BEGIN}{block}\n\n{END}{rest.split(END)[1]}"


def main() -> None:
    """Write the file, or compare it."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing, and fail if the file would change")
    args = parser.parse_args()
    old = FILE.read_text(encoding="utf-8")
    new = written(old)
    if not args.check:
        FILE.write_text(new, encoding="utf-8")
    elif new != old:
        sys.exit("atari/task/options.py is old: run scripts/generate/options.py")


if __name__ == "__main__":
    main()
