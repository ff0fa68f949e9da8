"""Games of your own: the example cartridge, `AtariEnv(game=FILE, rom=FILE)` and `register_game`."""

import copy
import runpy
import sys
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import atari

ROOT = Path(__file__).parents[2]
CATCH = ROOT / "examples" / "catch"
RULES, IMAGE = CATCH / "catch.toml", CATCH / "catch.bin"


def make(**options: Any) -> atari.AtariEnv:
    return atari.AtariEnv(RULES, rom=IMAGE, repeat_action_probability=0.0, frameskip=1, **options)


def follow(env: atari.AtariEnv) -> int:
    """The action that moves the cup under the ball."""
    ram, labels = env.core.ram(), env.game.ram_labels
    ball, cup = int(ram[labels["ball_x"].index]), int(ram[labels["player_x"].index])
    return 1 if ball > cup + 3 else 2 if ball < cup - 1 else 0


def assembled(source: Path, output: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """The status of scripts/assemble.py."""
    monkeypatch.setattr(sys, "argv", ["assemble.py", str(source), str(output)])
    return int(runpy.run_path(str(ROOT / "scripts" / "assemble.py"))["main"]())


def test_the_image_is_what_the_source_assembles_to(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert assembled(CATCH / "catch.asm", tmp_path / "out.bin", monkeypatch) == 0
    assert (tmp_path / "out.bin").read_bytes() == IMAGE.read_bytes()


def test_catching_scores_and_missing_costs_lives() -> None:
    env = make()
    _, info = env.reset(seed=0)
    assert info["lives"] == 3
    rewards = [env.step(follow(env))[1] for _ in range(1000)]
    assert sum(rewards) == sum(reward == 1 for reward in rewards) >= 11
    assert env.core.lives == 3
    frames = 0
    terminated = False
    while not terminated:  # the cup stays, and most balls fall elsewhere
        _, _, terminated, _, info = env.step(0)
        frames += 1
    assert info["lives"] == 0
    assert frames < 1500
    env.reset()
    assert env.core.lives == 3


def test_labels_say_where_things_are_on_the_screen() -> None:
    env = make()
    env.reset(seed=0)
    for _ in range(100):
        screen = env.step(0)[0]
        ball = np.argwhere((screen == 236).all(axis=2))
        cup = np.argwhere((screen == (252, 252, 84)).all(axis=2))
        ram, labels = env.core.ram(), env.game.ram_labels
        if ram[labels["ball_y"].index] == 186:
            continue  # a new ball, visible in the next frame
        seen = {"ball_x": ball[:, 1].min(), "ball_y": ball[:, 0].min(), "player_x": cup[:, 1].min()}
        for name, place in seen.items():
            label = labels[name]
            assert label.transform is not None
            assert eval(label.transform, {"v": int(ram[label.index])}) == place, name


def test_it_passes_gymnasiums_checker_and_copies() -> None:
    env = make(obs_type="grayscale", sound_obs=True)
    check_env(env, skip_render_check=True)
    env.reset(seed=1)
    env.step(1)
    other = copy.deepcopy(env)
    assert [env.step(1)[1:4] for _ in range(30)] == [other.step(1)[1:4] for _ in range(30)]


def test_registered_ids_work_with_gymnasium_and_in_vector_environments() -> None:
    assert atari.register_game(RULES, rom=IMAGE) == ("Catch-v5", "Catch-ram-v5")
    try:
        env = gymnasium.make("Catch-v5")
        assert env.reset(seed=0)[0].shape == (210, 160, 3)
        envs = gymnasium.make_vec("Catch-ram-v5", num_envs=2)
        assert envs.reset(seed=0)[0].shape == (2, 128)
        assert atari.make("Catch-ram-v5").observation_space.shape == (128,)
        with pytest.raises(gymnasium.error.NameNotFound, match="did you mean 'Catch-v5'"):
            atari.make("Cacth-v5")
        with pytest.raises(ValueError, match="the ID 'Catch-v5' is taken; rename the game file"):
            atari.register_game(RULES, rom=IMAGE)
    finally:
        for env_id in ("Catch-v5", "Catch-ram-v5"):
            del gymnasium.registry[env_id]


def test_the_rom_beside_the_definition_is_found(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(RULES.read_text())
    with pytest.raises(FileNotFoundError, match="the game 'mine' names no hash to search for"):
        atari.AtariEnv(tmp_path / "mine.toml")
    assert atari.AtariEnv(RULES).reset(seed=0)[0].shape == (210, 160, 3)
    assert atari.AtariVectorEnv(RULES, 2).reset(seed=0)[0].shape == (2, 4, 84, 84)
    text = RULES.read_text() + f'\n[rom]\nmd5 = "{"0" * 32}"\n'
    (tmp_path / "mine.toml").write_text(text)
    (tmp_path / "mine.bin").write_bytes(IMAGE.read_bytes())
    with pytest.raises(FileNotFoundError, match="no ROM file of Catch"):  # another game's
        atari.AtariEnv(tmp_path / "mine.toml")
    with pytest.raises(ValueError, match="the ROM of Catch is needed"):
        atari.AtariEnv(tmp_path / "mine.toml", rom=IMAGE)
    with pytest.raises(FileNotFoundError):
        atari.AtariEnv(tmp_path / "missing.toml", rom=IMAGE)


def test_a_replay_beside_the_definition_is_no_rom(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(RULES.read_text())
    env = atari.recording.RecordReplay(atari.AtariEnv(tmp_path / "mine.toml", rom=IMAGE), tmp_path / "mine.a26r")
    env.reset(seed=0)
    env.close()
    (tmp_path / "mine.a26r").rename(tmp_path / "mine.a26")
    with pytest.raises(FileNotFoundError, match="the game 'mine' names no hash to search for"):
        atari.AtariEnv(tmp_path / "mine.toml")
    with pytest.raises(ValueError, match=r"mine\.a26 is a replay, not a ROM file; `atari replay show "):
        atari.AtariEnv(tmp_path / "mine.toml", rom=tmp_path / "mine.a26")


def test_where_a_game_lies_makes_it_no_other_game(tmp_path: Path) -> None:
    (tmp_path / "catch.toml").write_text(RULES.read_text())
    assert atari.games.resolve(tmp_path / "catch.toml") == atari.games.resolve(RULES)
    assert atari.games.resolve(RULES).file == RULES.absolute()


def test_ale_py_refuses_it() -> None:
    with pytest.raises(ValueError, match="ale-py has only its own games, not 'catch'; use core='native'"):
        make(core="ale")


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("lda #1", "line 1: .org must come first"),
        (".org $F000\nfoo #1", "line 2: FOO is no instruction"),
        (".org $F000\nlda nowhere", "line 2: 'nowhere' is not defined"),
        (".org $F000\nsta #1", "line 2: STA does not take such an operand"),
        (".org $F000\nLoop: nop\n.org $F100\nbne Loop", "line 4: the branch is too far"),
        (".org $F000\n.byte 300", "line 2: 300 does not fit into a byte"),
        ("", "the program is empty"),
    ],
)
def test_the_assembler_names_the_line_that_is_wrong(
    source: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "wrong.asm").write_text(source)
    assert assembled(tmp_path / "wrong.asm", tmp_path / "out.bin", monkeypatch) == 1
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out.bin").exists()
