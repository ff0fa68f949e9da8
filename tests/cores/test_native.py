"""`NativeCore`: the contract of every core, and the properties of our emulator alone."""

import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from core_contract import CoreContract
from core_tools import play, some_actions, visible

import atari
from atari.cores import NativeCore, PlainCore
from atari.games.game import Rom
from atari.games.rules import parse_rules
from atari.roms import find


class TestNativeCore(CoreContract):
    core_type = NativeCore


class TestPlainCore(CoreContract):
    core_type = PlainCore


@pytest.mark.parametrize("game", ["combat", "joust", "maze_craze", "warlords"])
def test_two_player_cartridges_run_without_rules(game: str) -> None:
    """These cartridges have a screen, but no reward, lives or end."""
    core = NativeCore(game)
    core.reset()
    assert len(np.unique(core.screen())) > 2
    assert {core.act(action) for action in [0, 1, 3, 4] * 20} == {0}
    assert (core.lives, core.game_over, core.frame_number) == (0, False, 80)


def test_a_cloned_state_is_complete() -> None:
    """Unlike ale-py's, a cloned state also has the framebuffer, the held action and sound."""
    core = NativeCore("seaquest", sound=True, repeat_action_probability=0.5)
    core.reset()
    play(core, some_actions(core, 50))
    state, seen = core.clone_state(include_rng=True), visible(core)
    expected = play(core, some_actions(core, 50, seed=1))
    core.restore_state(state)
    assert visible(core) == seen
    assert play(core, some_actions(core, 50, seed=1)) == expected


def test_a_cloned_state_fits_another_core_of_the_game() -> None:
    first, second = NativeCore("pong"), NativeCore("pong", seed=3)
    first.reset()
    play(first, some_actions(first, 30))
    second.restore_state(first.clone_state(include_rng=True))
    assert visible(second) == visible(first)


def test_seeding_without_loading_again_is_as_a_new_core() -> None:
    """`seed` copies the state after the first load if that does not depend on the seed; in adventure it does."""
    for game in ("pong", "adventure", "berzerk", "klax"):
        core = NativeCore(game, seed=1)
        core.reset()
        play(core, some_actions(core, 40))
        core.seed(7)
        assert visible(core) == visible(NativeCore(game, seed=7)), game


def test_seeding_leaves_nothing_of_a_state_that_no_game_has_left() -> None:
    """A state has rows after the last row of the screen. Only a state that was edited by hand has pixels in them."""
    core = NativeCore("pong", seed=1)
    core.load(core.save()[:-1] + b"\x02")
    assert core.save()[-1] == 2
    core.seed(1)
    assert core.save() == NativeCore("pong", seed=1).save()


@pytest.mark.parametrize("game", [game.id for game in atari.games.playable()])
def test_a_game_begins_as_on_the_plain_core(game: str) -> None:
    """`reset` skips the frames that its reset trace has; the reference core plays all frames."""
    rng = np.random.default_rng(0)
    cores = [core(game, sound=True) for core in (NativeCore, PlainCore)]
    facts = cores[0].game
    for round_ in range(3):
        mode, difficulty = int(rng.choice(facts.modes)), int(rng.choice(facts.difficulties))
        frames, place, value = rng.integers((40, 128, 256))
        for core in cores:
            core.reset()
            for action in some_actions(core, int(frames)):
                core.act(action)
            core.set_ram(int(place), int(value))
            if round_ % 2:
                core.set_mode(mode)
                core.set_difficulty(difficulty)
            core.reset()
        assert cores[0].save() == cores[1].save(), round_


def test_a_framebuffer_may_keep_rows_from_before_a_reset(tmp_path: Path) -> None:
    """The first frame has a byte of RAM as background and clears that byte; all later frames are very short."""
    frame = "A580 8509 A2FA 8502 CA D0FB A900 8580 8509"  # LDA $80, STA COLUBK, 250 lines, 0 to both
    short = "A902 8500 8502 8502 8502 A900 8500 4C11F0"  # VSYNC for three lines, in a loop
    code = bytes.fromhex(frame + short)
    (tmp_path / "left.bin").write_bytes(code.ljust(0xFFC, b"\0") + b"\x00\xf0\x00\xf0")
    rules = parse_rules({"lives_initial": 1, "state": {}, "step": "reward = 0\nterminal = 0\nlives = 1"})
    mine = replace(atari.games["breakout"], rom=Rom(), rules=rules)
    cores = [core(mine, rom=tmp_path / "left.bin") for core in (NativeCore, PlainCore)]
    for value in (0x1E, 0x46):
        for core in cores:
            core.reset()
            core.set_ram(0, value)
            core.reset()
        assert cores[0].save() == cores[1].save()
        colours = set()
        for _ in range(2):  # the two framebuffers
            for core in cores:
                core.act(0)
            colours |= set(np.unique(cores[0].screen()))
        assert value in colours


def test_rules_are_evaluated_for_every_frame_of_a_reset() -> None:
    """That includes the frames that `reset` skips: these rules sum a byte that changes, and keep the sum."""
    step = "total = total + ram[0x90]\nreward = total\nterminal = 0\nlives = 1"
    rules = parse_rules({"lives_initial": 1, "state": {"total": 0}, "step": step, "kept_over_reset": ["total"]})
    mine = replace(atari.games["breakout"], rules=rules)
    rewards = []
    for core in (NativeCore(mine), PlainCore(mine)):
        for _ in range(3):
            core.reset()
        rewards.append(core.act(0))
    assert rewards[0] == rewards[1] > 0


def test_a_rom_without_a_hash_in_its_game_is_taken_as_it_is(tmp_path: Path) -> None:
    image = bytearray(find("breakout").read_bytes())
    image[0x100] ^= 0xFF
    (tmp_path / "changed.bin").write_bytes(image)
    mine = replace(atari.games["breakout"], rom=Rom())
    core = NativeCore(mine, rom=tmp_path / "changed.bin")
    core.reset()
    assert core.frame_number == 0
    with pytest.raises(ValueError, match="the ROM of Breakout is needed"):
        NativeCore("breakout", rom=tmp_path / "changed.bin")
    with pytest.raises(FileNotFoundError, match="names no hash to search for; say where its file is with rom="):
        NativeCore(mine)


@pytest.mark.parametrize("size", [0, 1, 1000, 8448, 100_000])
def test_an_image_of_no_supported_type_is_refused(tmp_path: Path, size: int) -> None:
    (tmp_path / "odd.bin").write_bytes(bytes(size))
    with pytest.raises(ValueError, match=r"empty|bytes|Supercharger|cartridge type"):
        NativeCore(replace(atari.games["breakout"], rom=Rom()), rom=tmp_path / "odd.bin")


def test_a_foreign_rom_under_the_rules_of_a_game_cannot_hang(tmp_path: Path) -> None:
    """The RAM of this ROM never has the mode that a reset waits for."""
    (tmp_path / "jam.bin").write_bytes(b"\x02" * 4092 + b"\x00\xf0\x00\xf0")
    mine = replace(atari.games["breakout"], rom=Rom())
    with pytest.raises(RuntimeError, match="the mode cannot be selected"):
        NativeCore(mine, rom=tmp_path / "jam.bin")


def test_the_state_is_refused_if_it_could_not_have_been_saved() -> None:
    core = NativeCore("pong")
    state = bytearray(core.save())
    for bad in (b"", bytes(state[:-1]), bytes(state) + b"0", b"\xff" * len(state)):
        seen = visible(core)
        with pytest.raises(ValueError, match="the state is damaged, or of another game or version"):
            core.load(bad)
        assert visible(core) == seen


@pytest.mark.parametrize("game", ["pong", "pitfall2", "klax"])
def test_snapshots_of_the_plain_core_are_those_of_the_native_one(game: str) -> None:
    """Each core restores the other's snapshot and continues in the same way. Cloned states fit one kind of core."""
    options: dict[str, Any] = {"seed": 4, "sound": True, "repeat_action_probability": 0.25}
    for first, second in ((NativeCore, PlainCore), (PlainCore, NativeCore)):
        core, copy = first(game, **options), second(game, **options)
        core.reset()
        play(core, some_actions(core, 40))
        saved = core.snapshot()
        copy.restore(saved)
        with pytest.raises(ValueError, match="or of another kind of core"):
            copy.restore_state(core.clone_state())
        assert copy.snapshot() == saved
        assert visible(copy) == visible(core)
        actions = some_actions(core, 40, seed=1)
        assert play(core, actions) == play(copy, actions)
        assert core.snapshot() == copy.snapshot()


def test_other_threads_run_while_frames_are_played() -> None:
    """While a call plays 10,000 frames, another thread makes progress."""
    core = NativeCore("pitfall", frame_skip=10_000)
    core.reset()
    rounds = 0
    playing = True

    def count() -> None:
        nonlocal rounds
        while playing:
            rounds += 1
            time.sleep(0)

    other = threading.Thread(target=count)
    other.start()
    during = calls = 0
    while during <= 100 and calls < 50:  # a busy machine may give the other thread no time in a call
        before, calls = rounds, calls + 1
        core.act(0)
        during = rounds - before
    playing = False
    other.join()
    assert core.frame_number >= 10_000
    assert during > 100
