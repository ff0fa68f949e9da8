"""`AleCore`: the contract of every core, and the properties of ale-py alone."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import ale_py
import numpy as np
import pytest
from core_contract import CoreContract
from core_tools import play, some_actions, unchanged, visible

import atari
from atari.cores import AleCore

ROMS = Path(ale_py.__file__).parent / "roms"


class TestAleCore(CoreContract):
    core_type = AleCore


def made(game: str = "breakout", *, sound: bool = False, seed: int = 0) -> AleCore:
    core = AleCore(game, sound=sound, seed=seed)
    core.reset()
    return core


def test_a_snapshot_after_restore_state_waits_for_a_reset() -> None:
    core = made()
    core.restore_state(core.clone_state())
    with pytest.raises(RuntimeError, match=r"possible again only after reset\(\)"):
        core.snapshot()
    core.reset()
    saved = core.snapshot()
    expected = play(core, some_actions(core, 20))
    core.restore(saved)
    assert play(core, some_actions(core, 20)) == expected


@pytest.mark.parametrize(("game", "sound"), [("breakout", True), ("video_checkers", False), ("video_cube", False)])
def test_where_something_outlives_a_reset_it_waits_for_a_seed(game: str, sound: bool) -> None:
    """A reset keeps the sound generator, and variables in the rules of two games."""
    core = made(game, sound=sound)
    core.restore_state(core.clone_state())
    core.reset()
    with pytest.raises(RuntimeError, match=r"possible again only after seed\(\)"):
        core.snapshot()
    core.seed(1)
    core.restore(core.snapshot())
    core.reset()
    new = made(game, sound=sound, seed=1)
    assert visible(core) == visible(new)


def test_a_snapshot_grows_by_a_byte_an_act_until_a_reset() -> None:
    core = made()
    saved = core.snapshot()
    play(core, some_actions(core, 100))
    assert 100 <= len(core.snapshot()) - len(saved) <= 102
    core.reset()
    assert len(core.snapshot()) < len(saved) + 50
    core.restore_state(core.clone_state())
    core.restore(saved)
    assert core.snapshot() == saved, "a restored snapshot makes snapshots possible again"


def test_the_framebuffer_of_a_restored_state_is_stale_until_the_next_act() -> None:
    core = made("seaquest")
    state, before = core.clone_state(), core.screen()
    play(core, [1] * 30)
    stale = core.screen()
    core.restore_state(state)
    assert np.array_equal(core.screen(), stale)
    assert not np.array_equal(stale, before)


def test_the_seed_that_ale_py_cannot_use_is_the_one_below() -> None:
    """As a signed number it is -1, which ale-py replaces by the clock."""
    first, second = made("seaquest", seed=2**32 - 1), made("seaquest", seed=2**32 - 2)
    actions = some_actions(first, 60)
    assert play(first, actions) == play(second, actions)


def test_a_snapshot_of_another_ale_py_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    core = made()
    with monkeypatch.context() as patch:
        patch.setattr(ale_py, "__version__", "0.99")
        other = core.snapshot()
    with unchanged(core), pytest.raises(ValueError, match=r"taken with ale-py = '0\.99', but this environment has"):
        core.restore(other)


@pytest.mark.parametrize(
    ("game", "rom", "error", "text"),
    [
        ("breakout", ".", IsADirectoryError, "is a folder"),
        ("breakout", "breakout.bin", FileNotFoundError, "there is no file"),
        *(("breakout", content, ValueError, "breakout") for content in (b"", b"\0" * 2048, b"x" * 2**20)),
        ("breakout", ROMS / "pong.bin", ValueError, "Pong"),
        ("warlords", None, ValueError, "'warlords' is a two-player cartridge without single-player rules"),
        (replace(atari.games["breakout"], id="mine"), None, ValueError, "ale-py has only its own games, not 'mine'"),
    ],
)
def test_a_game_that_cannot_be_played_is_refused(tmp_path: Path, game: Any, rom: Any, error: Any, text: str) -> None:
    if isinstance(rom, bytes):
        (tmp_path / "breakout.bin").write_bytes(rom)
        rom = "breakout.bin"
    with pytest.raises(error, match=text):
        AleCore(game, rom=None if rom is None else tmp_path / rom)


def test_a_rom_file_that_goes_away_raises_at_the_next_seed(tmp_path: Path) -> None:
    """A seed makes ale-py read the file again, and it would end the process."""
    copy = tmp_path / "breakout.bin"
    copy.write_bytes((ROMS / "breakout.bin").read_bytes())
    core = AleCore("breakout", rom=copy)
    core.reset()
    saved = core.snapshot()
    for change in (copy.unlink, lambda: copy.write_bytes(b"nonsense")):
        change()
        with unchanged(core), pytest.raises((FileNotFoundError, ValueError), match="breakout"):
            core.seed(1)
        with unchanged(core), pytest.raises((FileNotFoundError, ValueError), match="breakout"):
            core.restore(saved)


def test_a_seed_before_the_first_use_loads_the_game_once(monkeypatch: pytest.MonkeyPatch) -> None:
    loads: list[object] = []

    class Counted(ale_py.ALEInterface):
        def loadROM(self, rom: object) -> None:
            loads.append(rom)
            super().loadROM(rom)

    monkeypatch.setattr(atari.cores.ale, "ALEInterface", Counted)
    core = AleCore("breakout")
    assert not loads
    core.seed(1)
    core.reset()
    assert len(loads) == 1


def test_a_rom_of_any_file_name_is_played(tmp_path: Path) -> None:
    """ale-py chooses the rules by the file name; the core does not."""
    copy = tmp_path / "game (1978).a26"
    copy.write_bytes((ROMS / "breakout.bin").read_bytes())
    core, usual = AleCore("breakout", rom=copy), AleCore("breakout")
    assert play(core, [1, 3, 3, 0] * 10) == play(usual, [1, 3, 3, 0] * 10)
