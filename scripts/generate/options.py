#!/usr/bin/env python
"""Writes the types of the options of a task, from the rows of `TaskFields`, into the same file, atari/task/fields.py.

    scripts/generate/options.py          # writes the file
    scripts/generate/options.py --check  # fails if the file would change; a test calls this

Type checkers run no code, so the options have to stand in the source.
"""

import argparse
import ast
import inspect
import re
import sys
from pathlib import Path

from atari.env import AtariEnv
from atari.task.fields import ROWS
from atari.task.resolution import ALIASES, OPTIONS

FILE = Path(__file__).resolve().parents[2] / "atari" / "task" / "fields.py"
BLOCK = re.compile(r"(# Begin of what scripts/generate/options.py writes.\n).*(\n\n# End of)", re.DOTALL)
CLASSES = """class AddedOptions(TypedDict, total=False):
    \"\"\"The options that `AtariEnv` does not name.\"\"\"

{added}


class SharedOptions(AddedOptions, total=False):
    \"\"\"The options that have one type in all functions.\"\"\"

{shared}
"""


def written(text: str) -> str:
    """The source of the options with its classes made anew, in the order of the rows."""
    tree = ast.parse(text)
    fields = next(node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == "TaskFields")
    annotated = [node for node in fields.body if isinstance(node, ast.AnnAssign)]
    types = {ast.unparse(node.target): ast.unparse(node.annotation) for node in annotated}
    options = {name: ROWS[name].accepts or types[name] for name in OPTIONS if name not in ("mode", "difficulty")}
    options |= dict.fromkeys(ALIASES, "bool | None")
    named = inspect.signature(AtariEnv.__init__).parameters
    added = "\n".join(f"    {name}: {kind}" for name, kind in options.items() if name not in named)
    shared = "\n".join(f"    {name}: {kind}" for name, kind in options.items() if name in named)
    return BLOCK.sub(lambda match: match[1] + CLASSES.format(added=added, shared=shared) + match[2], text)


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
        sys.exit("atari/task/fields.py is old: run scripts/generate/options.py")


if __name__ == "__main__":
    main()
