"""The tables in `data`, which scripts/generate/published_scores.py writes: published results, sets, human scores."""

import difflib
import json
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from atari.games.frozen import FrozenDict

_FOLDER = Path(__file__).parent / "data"


@cache
def read_table(name: str) -> Any:
    """The content of a file of `data`, read at its first use."""
    return json.loads((_FOLDER / f"{name}.json").read_text(encoding="utf-8"))


def check_known_name(
    kind: str, name: Any, known: Iterable[str], where: str = "", others: Mapping[str, str] = FrozenDict()
) -> str:
    """Check that `name` is one of `known`, and return it.

    Args:
        kind: the kind of thing that has the name, for the error.
        name: the user's name.
        known: the names that exist.
        where: the end of the error; "" lists the known names.
        others: words of other projects, with the known name that each means.

    Raises:
        TypeError: `name` is no string.
        ValueError: `name` is not known; the nearest known name is suggested, if one is near.
    """
    names = list(known)
    if not isinstance(name, str):
        raise TypeError(f"{kind} is named by a string such as {names[0]!r}, got {name!r}")
    if name not in names:
        wanted = name.lower()
        near = [known for known in names if wanted and known.startswith(wanted)]
        near = near or [known for word, known in others.items() if word in wanted and known in names]
        family = [known for known in names if "/" in wanted and known.startswith(wanted.partition("/")[0] + "/")]
        if family and not near:
            raise ValueError(f"there is no {kind} {name!r}; {wanted.partition('/')[0]} has {', '.join(family)}")
        near = near or sorted((known for known in names if len(wanted) > 2 and wanted in known), key=len)
        near = near or difflib.get_close_matches(wanted, names, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        raise ValueError(f"there is no {kind} {name!r}; {hint}{where or 'known are ' + ', '.join(names)}")
    return name
