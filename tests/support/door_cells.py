"""The cells of the table of doors and fields: each door with a value of each field."""

from typing import Any

import pytest
from doors import Door
from field_values import CASES

from atari.task import Task


def cell_options(door: Door, field: str) -> dict[str, Any]:
    """Options, GAME among them, in which a field differs from its default."""
    case = CASES[field]
    if door.games != "several":
        return {"game": "breakout", **case.needs, field: case.value}
    case = case.several or case
    return {"players": 2, **case.needs, "game": "pong", field: case.value}


def call(door: Door, options: dict[str, Any]) -> Task:
    """The task of a door."""
    options = dict(options)
    game = options.pop("game")
    if not door.takes_options:
        return door.task(Task.of(game, **options))
    return door.task(f"ALE/{game.title()}-v5" if door.games == "ids" else game, **options)


def check_cell(door: Door, field: str) -> None:
    """Check that a door takes a field, so that its task has the value, or refuses it with a sentence that names it."""
    options = cell_options(door, field)
    if field in door.outside:
        assert getattr(call(door, options), field) == getattr(Task("pong"), field), door.outside[field]
        return
    if field in door.refuses:
        with pytest.raises((TypeError, ValueError)) as error:
            call(door, options)
        text = str(error.value).replace("-", "_")  # flags have hyphens
        assert any(name in text for name in {*options} - {"game"}), door.refuses[field]
        return
    played = call(door, options)
    assert getattr(played, door.translates.get(field, field)) == getattr(Task(**options), field)
