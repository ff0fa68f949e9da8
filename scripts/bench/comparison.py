"""`Comparison`: contestants that do the same work, and the functions that prepare them for a game."""

from collections.abc import Callable
from dataclasses import dataclass

Run = Callable[[int], float]
"""Takes a number of steps and returns the seconds they took."""

Contestant = tuple[str, Callable[[str], Run]]
"""The name of one side, and the function that prepares it for a game."""


@dataclass(frozen=True)
class Comparison:
    """Contestants that do the same work; ratios refer to the last one.

    `part` is the share of the requested steps that is taken; it is below 1 where a step takes long.
    """

    name: str
    contestants: list[Contestant]
    part: float = 1.0
