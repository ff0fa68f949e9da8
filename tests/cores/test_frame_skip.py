"""A core with a frame skip of its own plays and resets as ALE does with the setting `frame_skip`."""

import ale_py
import pytest

import atari
from atari.cores import AleCore, NativeCore, PlainCore


@pytest.mark.parametrize(
    ("game", "mode"), [("berzerk", 1), ("double_dunk", 0), ("double_dunk", 7), ("video_cube", 1), ("pong", 0)]
)
@pytest.mark.parametrize("skip", [1, 2, 4])
def test_it_is_that_of_ale(game: str, mode: int, skip: int) -> None:
    ale = ale_py.ALEInterface()
    ale.setInt("random_seed", 5)
    ale.setInt("frame_skip", skip)
    ale.setFloat("repeat_action_probability", 0.25)
    ale.loadROM(ale_py.roms.get_rom_path(game))
    kinds = (NativeCore, PlainCore, AleCore)
    cores = [kind(game, seed=5, frame_skip=skip, repeat_action_probability=0.25) for kind in kinds]
    ale.setMode(mode)
    ale.reset_game()
    for core in cores:
        core.set_mode(mode)
        core.reset()
    for step in range(40):
        frames = ale.getFrameNumber(), ale.getEpisodeFrameNumber()
        ram, reward = ale.getRAM(), ale.act(ale_py.Action(step % 18))
        for core in cores:
            assert (core.ram() == ram).all(), (core.name, step)
            assert (core.frame_number, core.episode_frame_number) == frames
            assert core.act(step % 18) == reward


def test_a_reset_that_plays_depends_on_it() -> None:
    """And so differs from that of `AtariEnv`, whose core has no frame skip."""
    cores = [NativeCore("berzerk", seed=0, frame_skip=skip, repeat_action_probability=0.0) for skip in (1, 4)]
    env = atari.AtariEnv("berzerk", frameskip=4, repeat_action_probability=0.0)
    env.reset(seed=0)
    for core in cores:
        core.reset()
    assert [core.episode_frame_number for core in (*cores, env.core)] == [20, 80, 20]
