"""Objects that labels list while the console does not draw them, and objects that they hide while it does.

A game, a mode, a difficulty, a seed and a length of play are drawn; some plays go on after the end of the game.
"""

import random

from drawn_objects import Play, undecided

import atari
from atari.games.objects import positions

GAMES = tuple(game.id for game in atari.games.playable() if positions(game.ram_labels))


def attack(seed: int) -> None:
    """Play a game to a random place, and compare its objects with the screen there."""
    source = random.Random(seed)
    game = atari.games[source.choice(GAMES)]
    mode, difficulty = source.choice(game.modes), source.choice(game.difficulties)
    frames = source.choice((0, source.randrange(60), source.randrange(1500), source.randrange(4000)))
    last = source.random() < 0.3
    play = Play(game, source.randrange(2**31), mode=mode, difficulty=difficulty)
    try:
        play.frames(frames // 2)
        if last:
            play.last_life()
        play.frames(frames - frames // 2)
        found = [fault for fault in play.faults() if fault[0] not in undecided().get(game.id, {})]
    finally:
        play.close()
    where = f"mode {mode}, difficulty {difficulty}, after {frames} frames" + (", with one life" if last else "")
    assert not found, f"{game.id}, {where}: " + "; ".join(f"{name} {fault}" for name, fault in found)
