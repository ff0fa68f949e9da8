"""`show_replay`: every frame is shown, and the window can be closed."""

from pathlib import Path
from typing import Any

import pygame
import pytest
from cli_tools import Patch

import atari
from atari.play import loop
from atari.recording import RecordReplay, Replay


@pytest.fixture
def replay(tmp_path: Path, monkeypatch: Patch) -> Replay:
    monkeypatch.setattr(loop.Pacer, "wait", lambda self: None)
    env = RecordReplay(atari.AtariEnv("pong"), tmp_path / "a.a26r")
    env.reset(seed=0)
    for _ in range(20):
        env.step(2)
    env.close()
    return Replay.load(tmp_path / "a.a26r")


def test_every_frame_is_shown(replay: Replay, monkeypatch: Patch) -> None:
    shown: list[Any] = []
    monkeypatch.setattr(loop.GameWindow, "show", lambda self, rgb, title, text="": shown.append((rgb.copy(), title)))
    assert loop.show_replay(replay, sound=False)
    assert len(shown) == replay.frames_total == 80
    assert (shown[-1][0] == list(replay.frames())[-1].screen).all()
    assert shown[-1][1].startswith("Pong: ")


@pytest.mark.parametrize("event", [{"type": pygame.QUIT}, {"type": pygame.KEYDOWN, "key": pygame.K_ESCAPE}])
def test_the_window_can_be_closed(replay: Replay, event: dict[str, int], monkeypatch: Patch) -> None:
    shown: list[Any] = []

    def show(self: Any, rgb: Any, title: str, text: str = "") -> None:
        shown.append(title)
        if len(shown) == 5:
            pygame.event.post(pygame.event.Event(event["type"], {k: v for k, v in event.items() if k != "type"}))

    monkeypatch.setattr(loop.GameWindow, "show", show)
    assert not loop.show_replay(replay, sound=False)
    assert len(shown) == 5


def test_keys_change_the_speed(replay: Replay, monkeypatch: Patch) -> None:
    shown: list[str] = []

    def show(self: Any, rgb: Any, title: str, text: str = "") -> None:
        shown.append(text)
        if len(shown) in (10, 11):
            pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=pygame.K_PLUS))

    monkeypatch.setattr(loop.GameWindow, "show", show)
    assert loop.show_replay(replay, sound=False)
    assert shown == [""] * 10 + ["speed 2"] + ["speed 4"] * 17  # 10 + 2 + 17 * 4 frames
