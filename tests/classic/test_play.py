"""`gym.utils.play`: keys become actions."""

from typing import Any

import pytest

import atari.classic as gym
from atari.classic.utils.play import play


@pytest.fixture(autouse=True)
def _no_window(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


def press_then_quit(seen: list[Any], key: int) -> Any:
    """A callback that presses a key after the first step, and closes the window three steps later."""
    import pygame

    def callback(before: Any, after: Any, action: Any, reward: Any, done: bool, info: dict[str, Any]) -> None:
        seen.append((action, done, type(info)))
        if len(seen) == 1:
            pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=key))
        if len(seen) == 4:
            pygame.event.post(pygame.event.Event(pygame.QUIT))

    return callback


def test_the_keys_of_a_game() -> None:
    seen: list[Any] = []
    play(gym.make("Pong-v0"), fps=1000, callback=press_then_quit(seen, ord("d")))
    assert [action for action, _, _ in seen[:4]] == [0, 2, 2, 2]  # none, then RIGHT
    assert {(done, kind) for _, done, kind in seen} == {(False, dict)}


def test_keys_of_ones_own() -> None:
    seen: list[Any] = []
    play(
        gym.make("CartPole-v0"),
        fps=1000,
        zoom=2,
        callback=press_then_quit(seen, ord("k")),
        keys_to_action={(ord("k"),): 1},
    )
    assert [action for action, _, _ in seen[:4]] == [0, 1, 1, 1]


def test_an_environment_without_keys_needs_keys_to_action() -> None:
    with pytest.raises(gym.error.Error, match=r"does not say which keys play it; give them, as in play\(env, keys_to"):
        play(gym.make("CartPole-v0"))
