"""`positions`, `constants` and `visible_objects`: the things on the screen, from the labels of games."""

import atari
from atari.games.objects import constants, positions, visible_objects


def test_four_objects_have_one_axis() -> None:
    """Combat moves its tanks by HMOVE alone, so that no byte has their columns. Play never met the other two."""
    lacking = {
        (game.id, name)
        for game in atari.games.values()
        for name, axes in positions(game.ram_labels).items()
        if len(axes | constants(axes)) < 2
    }
    assert lacking == {
        ("combat", "player"), ("combat", "player_2"), ("crazy_climber", "helicopter"), ("hero", "platform"),
    }  # fmt: skip


def test_positions_are_paired_by_their_names() -> None:
    def named(game: str) -> dict[str, str]:
        return {name: "".join(sorted(axes)) for name, axes in positions(atari.games[game].ram_labels).items()}

    assert named("pong") == {"player": "xy", "enemy": "xy", "ball": "xy"}
    assert named("breakout") == {"player": "x", "ball": "xy"}
    asteroids = positions(atari.games["asteroids"].ram_labels)
    values: dict[str, int | None] = dict.fromkeys(atari.games["asteroids"].ram_labels, 5)
    kinds = {thing.kind for thing in visible_objects(asteroids, values)}
    assert "asteroid" in kinds
    assert "player" in kinds
