"""Every door plays what GAME says, as the table in docs/tasks.md has it."""

import pytest
from documents import read_document
from doors import DOORS, Door

from atari.task.description import summary

GAMES = ("pong", "ALE/Pong-v5", "PongNoFrameskip-v4", "Pong-ram-v4")


def row(door: Door) -> str:
    """The row of a door in the table: what it plays, in a few words."""
    played = [_words(door, game) for game in GAMES]
    if played[1:] == [f"`{game}`" for game in GAMES[1:]]:
        played[1:] = ["as its name says"] * 3
    return f"| {door.name} | {' | '.join(played)} |"


def _words(door: Door, game: str) -> str:
    if door.ids_only and game == "pong":
        return "refused"
    return "`" + summary(door.task(game)).removeprefix("pong: Pong, as ") + "`"


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.name)
def test_the_documents_say_what_a_door_plays(door: Door) -> None:
    assert row(door) in read_document("docs/tasks.md")
