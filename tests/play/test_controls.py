"""Keys and gamepads become actions and commands."""

import pygame
import pytest

import atari
from atari.games.actions import PLAYER_ACTIONS, Action
from atari.play.controls import HELP, Command, Controls

event = pygame.event.Event


@pytest.fixture
def controls() -> Controls:
    return Controls(pygame)


def press(controls: Controls, *keys: int) -> Command | None:
    return [controls.handle(event(pygame.KEYDOWN, key=key)) for key in keys][-1]


def release(controls: Controls, *keys: int) -> None:
    for key in keys:
        assert controls.handle(event(pygame.KEYUP, key=key)) is None


@pytest.mark.parametrize(
    ("keys", "action"),
    [
        ([], Action.NOOP),
        ([pygame.K_UP], Action.UP),
        ([pygame.K_s], Action.DOWN),
        ([pygame.K_LEFT, pygame.K_UP], Action.UPLEFT),
        ([pygame.K_d, pygame.K_DOWN, pygame.K_SPACE], Action.DOWNRIGHTFIRE),
        ([pygame.K_LCTRL], Action.FIRE),
        ([pygame.K_LEFT, pygame.K_RIGHT, pygame.K_UP], Action.UP),
    ],
)
def test_keys(controls: Controls, keys: list[int], action: Action) -> None:
    for key in keys:
        assert press(controls, key) is None
    assert controls.action(PLAYER_ACTIONS) == action
    release(controls, *keys)
    assert controls.action(PLAYER_ACTIONS) == Action.NOOP


def test_what_is_not_legal_becomes_what_is_left_of_it(controls: Controls) -> None:
    legal = atari.games["skiing"].legal_actions
    assert Action.UPFIRE not in legal
    press(controls, pygame.K_RIGHT, pygame.K_SPACE)
    assert controls.action(legal) == Action.RIGHT
    assert controls.action((Action.FIRE, Action.LEFT)) == Action.FIRE
    assert controls.action((Action.LEFT, Action.DOWN)) == Action.LEFT


@pytest.mark.parametrize("game", [game.id for game in atari.games.playable()])
def test_every_game_can_be_played_with_every_key(game: str, controls: Controls) -> None:
    legal = atari.games[game].legal_actions
    for action in legal:
        keys = [
            key
            for held, key in (
                (action.vertical == 1, pygame.K_UP),
                (action.vertical == -1, pygame.K_DOWN),
                (action.horizontal == 1, pygame.K_RIGHT),
                (action.horizontal == -1, pygame.K_LEFT),
                (action.fire, pygame.K_SPACE),
            )
            if held
        ]
        for key in keys:
            press(controls, key)
        assert controls.action(legal) == action
        release(controls, *keys)


@pytest.mark.parametrize(
    ("keys", "action"),
    [
        ([pygame.K_UP], Action.RIGHT),
        ([pygame.K_s], Action.LEFT),
        ([pygame.K_RIGHT, pygame.K_w], Action.RIGHT),
        ([pygame.K_LEFT, pygame.K_UP], Action.NOOP),
        ([pygame.K_DOWN, pygame.K_SPACE], Action.LEFTFIRE),
    ],
)
def test_a_paddle_has_one_axis(keys: list[int], action: Action) -> None:
    controls = Controls(pygame, paddle=True)
    press(controls, *keys)
    assert controls.action(PLAYER_ACTIONS) == action


def test_commands(controls: Controls) -> None:
    expected = {
        pygame.K_ESCAPE: Command.QUIT,
        pygame.K_p: Command.PAUSE,
        pygame.K_n: Command.FRAME,
        pygame.K_r: Command.NEW_GAME,
        pygame.K_F5: Command.SAVE,
        pygame.K_F9: Command.LOAD,
        pygame.K_F10: Command.VIDEO,
        pygame.K_F11: Command.FULL_SCREEN,
        pygame.K_m: Command.MUTE,
        pygame.K_i: Command.INTERVENTIONS,
    }
    assert {key: press(controls, key) for key in expected} == expected
    assert controls.handle(event(pygame.QUIT)) == Command.QUIT
    assert controls.action(PLAYER_ACTIONS) == Action.NOOP
    assert all(command.value.upper() in HELP.upper() for command in Command)


def test_rewinding_while_the_key_is_held(controls: Controls) -> None:
    press(controls, pygame.K_BACKSPACE)
    assert controls.rewinding
    release(controls, pygame.K_BACKSPACE)
    assert not controls.rewinding


def test_gamepads(controls: Controls) -> None:
    def move(axis: int, value: float) -> Action:
        controls.handle(event(pygame.JOYAXISMOTION, axis=axis, value=value))
        return controls.action(PLAYER_ACTIONS)

    assert move(0, 0.9) == Action.RIGHT
    assert move(1, -0.8) == Action.UPRIGHT
    assert move(0, -0.3) == Action.UP
    assert move(5, 1.0) == Action.UP
    assert move(1, 0.0) == Action.NOOP
    controls.handle(event(pygame.JOYHATMOTION, value=(-1, -1)))
    controls.handle(event(pygame.JOYBUTTONDOWN, button=2))
    assert controls.action(PLAYER_ACTIONS) == Action.DOWNLEFTFIRE
    controls.handle(event(pygame.JOYBUTTONUP, button=2))
    controls.handle(event(pygame.JOYHATMOTION, value=(0, 0)))
    assert controls.action(PLAYER_ACTIONS) == Action.NOOP


def test_keys_are_let_go_of_with_the_window(controls: Controls) -> None:
    press(controls, pygame.K_UP)
    controls.handle(event(pygame.WINDOWFOCUSLOST))
    assert controls.action(PLAYER_ACTIONS) == Action.NOOP
