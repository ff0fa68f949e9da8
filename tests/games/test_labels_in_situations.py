"""Confirmed labels of all games agree with the emulator: at resets, in play, at ends, in demo screens, at a full score.

`label_situations` plays into these situations. A value that is wrong there must be corrected, or not be visible.
"""

from collections import Counter
from typing import Any

import numpy as np
import pytest
from drawn_objects import undecided
from label_situations import Recorder, points, pure, situations, undrawn, undrawn_at_reset

import atari
from atari.cores import NativeCore
from atari.games.game import Game, RamLabel
from atari.lab import Poke, Ram
from atari.lab.labels import Labels

FRAMES = 2400

FLICKERING = {"adventure", "asteroids", "ms_pacman", "venture"}
"""Games that draw some objects in each second frame only, so that a single frame shows nothing of them."""

RESERVES = {"air_raid"}
"""Games whose label counts the lives, while the rules have one life until the game is over."""

REMEMBERED = {"qbert", "star_gunner", "time_pilot"}
"""Games whose rules do not follow a byte of lives that someone else has written: they remember the lives before."""

ENDLESS = {"elevator_action", "et"}
"""Games with lives that random actions do not end."""


def confirmed(game: Game) -> dict[str, RamLabel]:
    return {name: label for name, label in game.ram_labels.items() if label.evidence.startswith("confirmed")}


def digits(game: str, label: RamLabel, score: Any) -> Any:
    """The value that one label of a score has at this score."""
    weight = label.weight or 1
    if game == "robotank":
        return score % 12  # tanks of the present squadron; a squadron has twelve
    digit = 256 if label.encoding != "bcd" else 10 if label.mask == 15 else 100
    return weight * (score // weight % digit)


def disagreements(game: Game) -> Counter[tuple[str, str, int, int]]:
    """The wrong values by label, situation, value and right value; places on the screen have its size."""
    found: Counter[tuple[str, str, int, int]] = Counter()
    labels = Labels(game, confirmed(game))
    for played in situations(game, FRAMES):
        score = points(game, played.ram) if pure(game, "points") else None
        # Without an end, rules that remember lives go on counting.
        lives = (played.situation != "demo") | pure(game, "lives")
        for name, *columns in zip(labels.names, *labels.evaluate(played.ram), strict=True):
            value, visible = columns
            label = game.ram_labels[name]
            if label.kind == "lives" and game.id not in RESERVES:
                right, wrong = played.lives, (value != played.lives) & lives
            elif label.kind == "score" and score is not None and not name.startswith(("score_player", "score_enemy")):
                right = digits(game.id, label, score)
                wrong = (value != right) & (value != score)
            elif label.kind.startswith("position"):
                size = game.screen.height if label.kind == "position_y" else game.screen.width
                right, wrong = np.full(len(value), size), (value < -16) | (value > size + 8)
            else:
                continue
            for frame in np.flatnonzero(visible & wrong):
                found[name, str(played.situation[frame]), int(value[frame]), int(right[frame])] += 1
    return found


@pytest.mark.parametrize("game", [game for game in atari.games.playable() if confirmed(game)], ids=lambda game: game.id)
def test_confirmed_labels_agree_in_all_situations(game: Game) -> None:
    assert not disagreements(game)


LIVING = [game.id for game in atari.games.playable() if "lives" in confirmed(game) and game.id not in ENDLESS]


@pytest.mark.parametrize("game", [game.id for game in atari.games.playable() if game.id not in FLICKERING - {*LIVING}])
def test_the_last_frame_has_no_lives_and_draws_its_objects(game: str) -> None:
    recorder = Recorder(atari.games[game])
    over = recorder.play_out(2000, 13_000 if game in LIVING else 4000)
    if game in LIVING:
        assert over
        assert Labels(atari.games[game], ["lives"]).values(recorder.core.ram()) == {"lives": 0}
    assert not over or game in FLICKERING or not undrawn(recorder) - undecided().get(game, {}).keys()


@pytest.mark.parametrize("game", sorted({*LIVING, *ENDLESS} - RESERVES - REMEMBERED))
def test_lives_that_someone_has_written_are_counted_as_the_rules_do(game: str) -> None:
    """A rule may read only some bits of the byte; the others are no lives."""
    core = NativeCore(game, seed=0)
    core.reset()
    start, ram = core.clone_state(include_rng=True), Ram(core)
    for byte in range(256):
        core.restore_state(start)
        poke = Poke(core, {ram.byte("lives"): byte})
        core.act(0)
        poke.release()
        assert ram["lives"] == core.lives, byte


@pytest.mark.parametrize("game", [game.id for game in atari.games.playable() if game.id != "tic_tac_toe_3d"])
def test_visible_objects_of_a_reset_are_drawn(game: str) -> None:
    """The cursor of 3-D Tic-Tac-Toe blinks more slowly than in four frames."""
    assert not undrawn_at_reset(atari.games[game]) - undecided().get(game, {}).keys()


@pytest.mark.parametrize("game", ["boxing", "ice_hockey", "othello", "pong", "surround"])
def test_the_scores_of_two_sides_give_the_score_of_the_rules(game: str) -> None:
    labels = Labels(atari.games[game], ["score_player", "score_enemy"])
    for played in situations(atari.games[game], FRAMES):
        (mine, theirs), visible = labels.evaluate(played.ram)
        assert visible.all()
        assert (mine - theirs).tolist() == points(atari.games[game], played.ram).tolist()


@pytest.mark.parametrize(
    ("game", "ram", "expected"),
    [
        ("berzerk", {90: 255}, {"lives": 0}),
        ("frogger", {80: 255}, {"lives": 0}),
        ("jamesbond", {6: 0, 12: 0x68, 111: 147}, {"lives": 0}),
        ("blackjack", {6: 0x0B, 9: 0xBB}, {"score_1": 0, "score_100": 0}),
        ("demon_attack", {1: 0xAB, 3: 0xCD, 5: 0xEA}, {"score_1": 0}),
        ("boxing", {18: 0xC0, 19: 0x42}, {"score_player": 100, "score_enemy": 42}),
        ("entombed", {99: 17}, {"score_1": 17}),
    ],
)
def test_situations_that_random_play_does_not_reach(game: str, ram: dict[int, int], expected: dict[str, int]) -> None:
    memory = np.zeros(128, np.uint8)
    memory[[*ram]] = [*ram.values()]
    assert Labels(atari.games[game], expected).values(memory) == expected


def test_digits_of_a_transformed_score_are_written_as_decimals() -> None:
    labels = Labels(atari.games["demon_attack"], ["score_1"])
    memory = np.zeros(128, np.uint8)
    memory[5] = 0x0B
    assert labels.byte_of("score_1", memory, 12) == 0x12  # one bit from 0x0B is 0x0C, no decimal number
