"""The causal map: what changes of RAM cause, against forks played by hand, and the maps that are shipped."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atari
import atari._emulator as _emulator
from atari.cli import main
from atari.cores.compiled import compiled
from atari.cores.native import NativeCore
from atari.games.toml_file import tomllib
from atari.lab import causes, shipped_causes
from atari.lab.causal.explore import _play
from atari.lab.causal.files import DATA, load, save, to_arrays
from atari.lab.causal.fit import COLUMNS
from atari.lab.causal.map import CausalMap
from atari.lab.causal.picture import draw
from atari.roms import find
from atari.roms import image as rom_image


@pytest.fixture(scope="module")
def pong() -> CausalMap:
    return causes("pong", states=40, seed=1)


def test_bytes_of_pong(pong: CausalMap) -> None:
    ball, enemy_y = pong.bytes[49], pong.bytes[50]
    assert ball.seen > 0.5
    assert not ball.derived
    assert ball.frames == 1
    assert enemy_y.derived
    assert not enemy_y.pixels.any()
    assert pong.bytes[90].inert
    assert pong.bytes[90].writes == ()
    assert pong.bytes[14].reward
    assert not pong.bytes[90].reward
    x, y = 141, 100  # the player's paddle
    assert 46 in pong.pixel(x, y)
    assert 49 not in pong.pixel(2, 2)
    with pytest.raises(IndexError, match="160 columns and 210 rows"):
        pong.pixel(160, 0)


def test_suggestions_of_pong(pong: CausalMap) -> None:
    found = {(each.index, each.kind): each for each in pong.suggestions}
    assert found[49, "position_x"].transform in ("v - 48", "v - 49")
    assert found[54, "position_y"].transform in ("v - 14", "v - 15")
    assert (found[49, "position_x"].width, found[49, "position_x"].height) == (2, 4)
    assert found[13, "score"].weight == -1
    assert found[14, "score"].weight == 1
    assert 'kind = "position_x"' in found[49, "position_x"].label()
    for each in pong.suggestions:
        if each.transform is not None:
            atari.games.game._ram_label("suggested", tomllib.loads(f"it = {each.label()}")["it"])


@pytest.mark.parametrize(
    ("game", "byte", "kind"), [("breakout", 57, "lives"), ("seaquest", 59, "lives"), ("seaquest", 57, "score")]
)
def test_score_and_lives(game: str, byte: int, kind: str) -> None:
    found = causes(game, states=8, frames=2)
    assert kind in [each.kind for each in found.suggestions if each.index == byte]
    assert found.bytes[byte].lives == (kind == "lives")


def test_effects_equal_forks_played_by_hand() -> None:
    core = NativeCore("breakout", seed=3, repeat_action_probability=0.0)
    saved, actions, ram, _ = _play(core, 4, 3, 3, None)
    engine = _emulator.Causes(
        game=compiled(core.game, rom_image.read_image(find(core.game))), values=3, frames=3, threads=1, seed=3
    )
    engine.explore(saved, actions, 0)
    effects = engine.effects()
    generator = np.random.default_rng(0)
    for row in generator.choice(effects, 60, replace=False):
        effect = dict(zip(COLUMNS, row.tolist(), strict=True))
        number = effect["state"]
        core.restore_state(saved[number])
        assert core.ram()[effect["byte"]] == effect["old_value"] == ram[number, effect["byte"]]
        twins = [(core.act(action), core.screen(), core.lives, core.ram()) for action in actions[number]]
        core.restore_state(saved[number])
        core.set_ram(effect["byte"], effect["new_value"])
        forks = [(core.act(action), core.screen(), core.lives, core.ram()) for action in actions[number]]
        differs = [bool((fork[1] != twin[1]).any()) for fork, twin in zip(forks, twins, strict=True)]
        assert effect["frame"] == (differs.index(True) + 1 if any(differs) else 0)
        assert effect["reward"] == forks[0][0] - twins[0][0]
        assert effect["lives"] == forks[0][2] - twins[0][2]
        if effect["frame"]:
            (_, old, _, _), (_, new, _, _) = twins[effect["frame"] - 1], forks[effect["frame"] - 1]
            rows, columns = np.nonzero(old != new)
            assert effect["pixels"] == len(rows)
            assert [effect[side] for side in ("left", "top", "right", "bottom")] == [
                columns.min(), rows.min(), columns.max(), rows.max(),
            ]  # fmt: skip
            assert effect["new_then"] == forks[effect["frame"] - 1][3][effect["byte"]]
    core.restore_state(saved[0])
    assert engine.counts()[:, 0].tolist() == [12] * 128


def test_the_result_depends_on_neither_threads_nor_calls() -> None:
    done: list[int] = []
    one, again = causes("pong", 8, seed=1), causes("pong", 8, seed=1, threads=3, progress=done.append)
    assert sum(done) == 8
    assert one.effects is not None
    np.testing.assert_array_equal(again.effects, one.effects)
    np.testing.assert_array_equal(again.pixel_counts, one.pixel_counts)
    assert again.suggestions == one.suggestions


def test_a_policy_plays() -> None:
    calls = []

    def policy(core: NativeCore) -> int:
        calls.append(core.frame_number)
        return 1

    found = causes("breakout", states=3, frames=1, policy=policy)
    assert len(calls) >= 60
    assert found.settings == {"states": 3, "values": 4, "frames": 1, "seed": 0}


def test_files(pong: CausalMap, tmp_path: Path) -> None:
    save(pong, tmp_path / "pong.npz")
    loaded = load(tmp_path / "pong.npz")
    assert (loaded.game, loaded.height, loaded.settings) == (pong.game, pong.height, pong.settings)
    assert loaded.suggestions == pong.suggestions
    for ours, theirs in zip(loaded.bytes, pong.bytes, strict=True):
        for name in ("derived", "inert", "reward", "lives", "over", "rewritten", "seen", "frames", "writes", "box"):
            assert getattr(ours, name) == getattr(theirs, name), name
        assert not (theirs.pixels & ~ours.pixels).any()
    assert 46 in loaded.pixel(141, 100)
    assert draw(loaded).shape[2] == 3


@pytest.mark.parametrize("content", [b"", b"PK\3\4 no archive", b"\x93NUMPY"])
def test_a_file_that_is_no_map(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "pong.npz"
    file.write_bytes(content)
    with pytest.raises(ValueError, match="not a causal map of this version"):
        load(file)


def test_a_damaged_map(pong: CausalMap, tmp_path: Path) -> None:
    for name in ("facts", "numbers", "writes", "cells"):
        arrays = to_arrays(pong)
        arrays[name] = arrays[name][..., :3]
        np.savez(tmp_path / "pong.npz", **arrays)
        with pytest.raises(ValueError, match="not a causal map of this version"):
            load(tmp_path / "pong.npz")


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: causes("pong", states=0), r"states must be within 1\.\.5000"),
        (lambda: causes("pong", frames=61), r"frames must be within 1\.\.60"),
        (lambda: causes("combat"), "without single-player rules"),
        (lambda: shipped_causes("combat"), "no causal map of combat"),
        (
            lambda: causes(atari.Task.of("pong", interventions=["lazy_enemy"]), states=2),
            r"causes has no place for interventions=.*; give the game alone, 'pong'",
        ),
        (lambda: causes(atari.Task.of("breakout", preset="dqn2015"), states=2), "causes has no place for noops="),
    ],
)
def test_bad_arguments(call: Callable[[], Any], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        call()


def test_bad_arguments_of_the_engine() -> None:
    core = NativeCore("pong")
    game = compiled(core.game, rom_image.read_image(find(core.game)))
    engine = _emulator.Causes(game=game, values=1, frames=2, threads=1, seed=0)
    state = core.clone_state(include_rng=True)
    with pytest.raises(ValueError, match="of another game"):
        engine.explore([NativeCore("breakout").clone_state()], np.zeros((1, 2), np.uint8), 0)
    with pytest.raises(ValueError, match="of shape"):
        engine.explore([state], np.zeros((2, 2), np.uint8), 0)
    with pytest.raises(ValueError, match=r"0\.\.17"):
        engine.explore([state], np.full((1, 2), 18, np.uint8), 0)
    with pytest.raises(ValueError, match="threads"):
        _emulator.Causes(game=game, values=1, frames=2, threads=0, seed=0)
    assert engine.frames_played == 0


def test_shipped_maps() -> None:
    files = sorted(DATA.glob("*.npz"))
    assert [file.stem for file in files] == sorted(game.id for game in atari.games.playable())
    assert sum(file.stat().st_size for file in files) < 600_000
    for game in ("pong", "ms_pacman", "zaxxon"):
        found = shipped_causes(game)
        assert found.game == game
        assert any(byte.seen for byte in found.bytes)


def test_a_shipped_map_is_what_the_defaults_make() -> None:
    again, shipped = to_arrays(causes("flag_capture")), np.load(DATA / "flag_capture.npz")
    for name, array in again.items():
        np.testing.assert_array_equal(array, shipped[name], err_msg="run scripts/generate/causal_maps.py")


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["causes", "pong", "--states", "4", "--frames", "1", "-o", str(tmp_path)]
    assert main(arguments) == 0
    assert "score_player" not in capsys.readouterr().out
    assert load(tmp_path / "pong.npz").game == "pong"
    assert (tmp_path / "pong.png").read_bytes().startswith(b"\x89PNG")
    assert main([*arguments, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["game"] == "pong"


def test_a_task_says_the_game_its_mode_and_its_difficulty() -> None:
    plain = causes("breakout", states=2, values=1)
    for found in (
        causes(atari.Task.of("breakout", mode=8, difficulty=1), states=2, values=1),
        causes("ALE/Breakout-v5", states=2, values=1, mode=8, difficulty=1),
    ):
        assert found.task is not None
        assert (found.task.mode, found.task.difficulty, found.task.frameskip) == (8, 1, 1)
        assert (found.settings["mode"], found.settings["difficulty"]) == (8, 1)
        assert not np.array_equal(found.ram, plain.ram)
    assert "mode" not in plain.settings
