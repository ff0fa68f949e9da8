"""The pool of ale-py's interfaces, which many tests use, beside ale-py."""

from typing import Any

import ale_pool
import ale_py
import numpy as np
import pytest
from ale_pool import PooledInterface

GAMES = ("pong", "berzerk", "double_dunk", "montezuma_revenge", "tetris", "elevator_action")


def loaded(kind: Any, game: str, seed: int, reset: bool = True, **settings: Any) -> Any:
    """An interface of a kind, with a game."""
    interface = kind()
    interface.setInt("random_seed", seed)
    interface.setFloat("repeat_action_probability", 0.25)
    for name, value in settings.items():
        interface.setBool(name, value)
    interface.loadROM(ale_py.roms.get_rom_path(game))
    if reset:
        interface.reset_game()
    return interface


def played(interface: Any, frames: int, seed: int = 0) -> list[Any]:
    """Everything that can be seen of a game of random actions, and the hidden state at its end."""
    seen = []
    for action in np.random.default_rng(seed).integers(18, size=frames).tolist():
        reward = interface.act(action)
        seen.append((reward, interface.lives(), interface.game_over(), interface.getFrameNumber()))
        seen.append((interface.getRAM().tobytes(), interface.getScreenRGB().tobytes()))
    return [*seen, interface.cloneSystemState().serialize()]


def loads(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The loads of ale-py from now on, with an empty pool."""
    made: list[Any] = []

    class Counted(ale_py.ALEInterface):
        def loadROM(self, rom: Any) -> None:
            made.append(rom)
            super().loadROM(rom)

    monkeypatch.setattr(ale_pool, "ale_py", type("ale_py", (), {"ALEInterface": Counted}))
    monkeypatch.setattr(ale_pool, "_unused", [])
    monkeypatch.setattr(ale_pool, "_loaded", {})
    return made


@pytest.mark.parametrize(("game", "averaged"), list(zip(GAMES, (False, True) * 3, strict=True)))
def test_a_used_interface_plays_as_one_of_ale_py(game: str, averaged: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    made = loads(monkeypatch)
    for seed in (1, 2):
        first = loaded(PooledInterface, game, seed, color_averaging=averaged)
    first.setMode(first.getAvailableModes()[-1])
    first.setDifficulty(first.getAvailableDifficulties()[-1])
    first.reset_game()
    for index in range(0, 128, 5):
        first.setRAM(index, 255 - index)
    played(first, 100)
    del first
    again = loaded(PooledInterface, game, 1, reset=False, color_averaging=averaged)
    assert len(made) == 2
    theirs = loaded(ale_py.ALEInterface, game, 1, reset=False, color_averaging=averaged)
    assert again.cloneSystemState().serialize() == theirs.cloneSystemState().serialize()
    for interface in (again, theirs):
        interface.reset_game()
    assert played(again, 200, 1) == played(theirs, 200, 1)


def restored(interface: Any) -> None:
    interface.reset_game()
    interface.restoreState(interface.cloneState())


@pytest.mark.parametrize(
    ("game", "settings", "use", "count"),
    [
        ("pong", {}, lambda interface: interface.reset_game(), 1),
        ("pong", {}, lambda interface: (interface.setDifficulty(1), interface.getScreenRGB()), 2),
        ("pong", {}, restored, 2),
        ("pong", {"sound_obs": True}, lambda interface: interface.reset_game(), 2),
        ("video_cube", {}, lambda interface: interface.reset_game(), 2),
    ],
)
def test_what_a_reset_leaves_is_loaded(
    game: str, settings: Any, use: Any, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Reads before a reset, restored states, sound, games whose rules keep variables over a reset."""
    made = loads(monkeypatch)
    for _ in range(2):
        use(loaded(PooledInterface, game, 1, reset=False, **settings))
    assert len(made) == count


def test_frames_before_a_reset(monkeypatch: pytest.MonkeyPatch) -> None:
    loads(monkeypatch)
    played(loaded(PooledInterface, "pong", 1), 10)
    ours, theirs = (loaded(kind, "pong", 1, reset=False) for kind in (PooledInterface, ale_py.ALEInterface))
    for interface in (ours, theirs):
        interface.setMode(1)
    assert played(ours, 60) == played(theirs, 60)


def test_a_load_depends_on_the_frame_skip(monkeypatch: pytest.MonkeyPatch) -> None:
    """In games whose mode is selected by playing."""
    loads(monkeypatch)
    for skip in (1, 4, 1, 4):
        seen = []
        for kind in (PooledInterface, ale_py.ALEInterface):
            interface = kind()
            interface.setInt("random_seed", 5)
            interface.setInt("frame_skip", skip)
            interface.loadROM(ale_py.roms.get_rom_path("double_dunk"))
            interface.setMode(7)
            interface.reset_game()
            seen.append(played(interface, 10))
        assert seen[0] == seen[1]
