"""Fixtures of the tests of play."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pygame
import pytest

from atari.play.loop import Loop


@pytest.fixture
def display(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Any:
    """SDL's dummy display and sound, in an empty folder."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    monkeypatch.setenv("SDL_AUDIODRIVER", "dummy")
    monkeypatch.chdir(tmp_path)
    yield
    pygame.quit()


@pytest.fixture
def end_after(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], None]:
    """Let windows close after some frames, with a key pressed that begins the game."""

    def end(frames: int) -> None:
        def run(loop: Loop) -> None:
            pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=pygame.K_x))
            for _ in range(frames):
                loop.tick()

        monkeypatch.setattr(Loop, "run", run)

    return end
