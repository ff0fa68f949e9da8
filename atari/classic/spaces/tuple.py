"""`Tuple`: one element of each of several spaces."""

from collections.abc import Iterable
from typing import Any

import gymnasium


class Tuple(gymnasium.spaces.Tuple):  # type: ignore[type-arg]
    """Tuples of an element of each space."""

    def __init__(self, spaces: Iterable[gymnasium.Space[Any]], seed: Any = None) -> None:
        super().__init__(spaces, seed)

    def __repr__(self) -> str:
        return f"Tuple({', '.join(map(repr, self.spaces))})"
