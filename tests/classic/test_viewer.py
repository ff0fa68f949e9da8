"""The window of `render()`: keys, and the user who closes it."""

from typing import Any

import numpy as np
import pygame
import pytest

import atari.classic as gym
from atari.classic.envs.classic_control import rendering
from atari.classic.viewer import Viewer


@pytest.fixture(autouse=True)
def no_display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


def post(kind: int, **fields: Any) -> None:
    pygame.event.post(pygame.event.Event(kind, **fields))


def test_keys_have_pyglets_numbers() -> None:
    viewer = Viewer("keys", 0)
    viewer.imshow(np.zeros((4, 4, 3), np.uint8))
    calls: list[Any] = []
    viewer.window.on_key_press = lambda key, mod: calls.append(("press", key, mod))
    viewer.window.on_key_release = lambda key, mod: calls.append(("release", key, mod))
    post(pygame.KEYDOWN, key=pygame.K_LEFT, mod=1)
    post(pygame.KEYDOWN, key=pygame.K_RETURN, mod=0)
    post(pygame.KEYUP, key=pygame.K_a, mod=0)
    viewer.imshow(np.zeros((4, 4, 3), np.uint8))
    assert calls == [("press", 0xFF51, 1), ("press", 0xFF0D, 0), ("release", ord("a"), 0)]
    viewer.close()


def test_without_handlers_the_keys_are_left_to_the_script() -> None:
    viewer = Viewer("keys", 0)
    viewer.imshow(np.zeros((4, 4, 3), np.uint8))
    pygame.event.clear()
    post(pygame.KEYDOWN, key=pygame.K_a, mod=0)
    viewer.imshow(np.zeros((4, 4, 3), np.uint8))
    assert [event.key for event in pygame.event.get(pygame.KEYDOWN)] == [pygame.K_a]
    viewer.close()


def test_a_window_that_the_user_closed_stays_closed() -> None:
    env = gym.make("Pong-v4")
    env.reset()
    assert env.render("rgb_array").shape == (210, 160, 3)
    assert env.unwrapped.viewer is None  # type: ignore[attr-defined]
    assert env.render() is True
    post(pygame.QUIT)
    assert [env.render(), env.render()] == [False, False]
    assert env.unwrapped.viewer.isopen is False  # type: ignore[attr-defined]
    env.close()
    env.reset()
    assert env.render() is True  # a new window
    env.close()


def test_a_window_for_images() -> None:
    viewer = rendering.SimpleImageViewer()
    viewer.imshow(np.zeros((210, 160, 3), np.uint8))
    assert viewer.isopen
    viewer.close()
    assert not viewer.isopen
