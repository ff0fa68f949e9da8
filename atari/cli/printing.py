"""The output of commands: JSON, tables and warnings."""

import dataclasses
import enum
import json
import sys
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from atari.base.json_text import escaped
from atari.base.program import print_exact
from atari.base.text_table import aligned


def to_json_types(value: Any) -> Any:
    """Convert a value made of dataclasses, mappings, sequences, enums and paths to the types of JSON."""
    if isinstance(value, enum.Enum):
        return value.name
    if dataclasses.is_dataclass(value):
        return {field.name: to_json_types(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): to_json_types(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_json_types(item) for item in value]
    return str(value) if isinstance(value, Path) else value


def print_json(value: Any) -> None:
    """Print a value that `to_json_types` accepts as one JSON document, at once: the command may continue."""
    print_exact(f"{json.dumps(to_json_types(value), indent=2)}\n")


def print_table(rows: Iterable[Sequence[object]]) -> None:
    """Print rows with aligned columns."""
    for line in aligned(rows):
        print(line)


@contextmanager
def printed_warnings() -> Iterator[None]:
    """Print the warnings of a block as `print_warning` does."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield
    for warning in caught:
        print_warning(warning.message)


def print_warning(warning: object) -> None:
    """Print a warning to stderr, in one line."""
    print(f"atari: warning: {escaped(str(warning))}", file=sys.stderr)
