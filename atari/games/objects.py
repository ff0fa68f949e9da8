"""`GameObject`: a thing on the screen, from the labels of its position."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from atari.games.game import RamLabel


@dataclass(frozen=True)
class GameObject:
    """A thing on the screen.

    Attributes:
        name: the name of its labels without `x` and `y`, such as "ball" or "asteroid_3".
        kind: the name without numbers, such as "asteroid"; alike things have the same.
        x, y: column and row of its left upper corner, in pixels of the screen; None if no byte has it and it is
            not constant.
        width, height: in pixels; None if they are not known.
    """

    name: str
    kind: str
    x: int | None
    y: int | None
    width: int | None
    height: int | None


Positions = dict[str, dict[str, RamLabel]]
"""The labels of each object by axis, "x" and "y", by the object's name."""


def positions(labels: Mapping[str, RamLabel]) -> Positions:
    """The positions among labels: `ball_x` and `ball_y`, or `tank_x_left` and `tank_y_left`, are one object.

    A label that was never seen to move a thing, and does not say when it is visible, is left out.
    """
    found: Positions = {}
    for name, label in labels.items():
        axis = {"position_x": "x", "position_y": "y"}.get(label.kind)
        if axis is None or (label.visible is None and label.evidence == "no effect seen"):
            continue
        words = name.split("_")
        marks = [number for number, word in enumerate(words) if re.fullmatch(rf"{axis}\d*", word)]
        if marks:
            words[marks[-1]] = words[marks[-1]][1:]
        owner = "_".join(word for word in words if word) or name
        if axis in found.get(owner, {}):
            owner = name  # a second label of the same position
        found.setdefault(owner, {})[axis] = label
    return found


def constants(axes: Mapping[str, RamLabel]) -> dict[str, int]:
    """The coordinates, by axis, that an object with these labels has all the time."""
    return {axis: here for label in axes.values() for axis in "xy" if (here := getattr(label, axis)) is not None}


def visible_objects(found: Positions, values: Mapping[str, int | None]) -> list[GameObject]:
    """The objects whose position has a value, so that they are on the screen, by the values of the labels by name."""
    objects = []
    for name, axes in found.items():
        place = {**constants(axes), **{axis: values[label.name] for axis, label in axes.items()}}
        if None not in place.values():
            kind = re.sub(r"_?\d+", "", name) or name
            widths = (label.width for label in axes.values() if label.width is not None)
            heights = (label.height for label in axes.values() if label.height is not None)
            objects.append(
                GameObject(name, kind, place.get("x"), place.get("y"), next(widths, None), next(heights, None))
            )
    return objects
