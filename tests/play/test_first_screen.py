"""The first screen names the keys that a game uses, by its data."""

import numpy as np
import pytest

import atari
from atari.cores import NativeCore
from atari.games.actions import Action
from atari.games.game import Game
from atari.play.controls import ALL_KEYS, LEFT_KEYS, NO_KEYS, RIGHT_KEYS, first_screen

FIRE = "space, left ctrl, right ctrl: FIRE"
UP, DOWN = "up arrow, W: UP", "down arrow, S: DOWN"
LEFT, RIGHT = "left arrow, A: LEFT", "right arrow, D: RIGHT"


@pytest.mark.parametrize(
    ("game", "used"),
    [
        ("breakout", ["right arrow, D, up arrow, W: RIGHT", "left arrow, A, down arrow, S: LEFT", FIRE]),
        ("blackjack", ["right arrow, D, up arrow, W: RIGHT", "left arrow, A, down arrow, S: LEFT", FIRE]),
        ("space_invaders", [LEFT, RIGHT, FIRE]),
        ("freeway", [UP, DOWN, "this game does not use FIRE"]),
        ("seaquest", [UP, DOWN, LEFT, RIGHT, FIRE]),
        ("atlantis", ["left arrow, A with FIRE: LEFTFIRE", "right arrow, D with FIRE: RIGHTFIRE", FIRE]),
    ],
)
def test_one_person(game: str, used: list[str]) -> None:
    found = atari.games[game]
    last = "press a key to begin, or H to see all keys"
    assert first_screen(found, found.minimal_actions, {1: ALL_KEYS}).splitlines() == [found.title, *used, last]
    lines = first_screen(found, found.minimal_actions, {1: ALL_KEYS}, 6).splitlines()
    assert lines == [found.title, *used, "I: 6 interventions, which change the game", last]


def test_several_people_have_a_line_each() -> None:
    game = atari.games["combat"]
    lines = first_screen(game, tuple(Action), {1: LEFT_KEYS, 2: RIGHT_KEYS, 4: NO_KEYS}).splitlines()
    assert lines[1:4] == [
        "player 1   W: UP   S: DOWN   A: LEFT   D: RIGHT   space, left shift: FIRE",
        "player 2   up arrow: UP   down arrow: DOWN   left arrow: LEFT   right arrow: RIGHT   "
        "right ctrl, right shift, return: FIRE",
        "player 4   a gamepad",
    ]


@pytest.mark.parametrize(
    ("game", "others"),
    [("sir_lancelot", (Action.UP, Action.DOWN)), ("up_n_down", (Action.RIGHT, Action.LEFT))],
)
def test_sticks_with_minimal_actions_on_one_axis_may_have_an_effect_on_the_other(
    game: str, others: tuple[Action, ...]
) -> None:
    found = atari.games[game]
    assert not set(others) & set(found.minimal_actions)
    core = NativeCore(game, seed=0, repeat_action_probability=0)
    core.reset()
    random = np.random.default_rng(0)
    different = 0
    for _ in range(300):
        action = int(random.choice([int(action) for action in found.minimal_actions]))
        for _ in range(25):
            core.act(action)
        if core.game_over:
            core.reset()
        state, screens = core.clone_state(), []
        for held in (Action.NOOP, *others):
            core.restore_state(state)
            for _ in range(24):
                core.act(int(held))
            screens.append(core.screen().tobytes())
        core.restore_state(state)
        different += len({*screens}) > 1
    assert different


PADDLES = [game for game in atari.games.playable() if game.controllers.paddles]


@pytest.mark.parametrize("game", PADDLES, ids=lambda game: game.id)
def test_up_and_down_alone_do_nothing_to_a_paddle(game: Game) -> None:
    screens = []
    for action in (Action.NOOP, Action.UP, Action.DOWN):
        core = NativeCore(game, seed=1, repeat_action_probability=0)
        core.reset()
        for frame in range(240):
            core.act(int(Action.FIRE if frame % 60 < 5 else action))
        screens.append(core.screen())
    assert np.array_equal(screens[0], screens[1])
    assert np.array_equal(screens[0], screens[2])
