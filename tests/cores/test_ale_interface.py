"""`env.unwrapped.ale`: a core under the names of ale-py's `ALEInterface`, and the wrappers that rely on it."""

from __future__ import annotations  # the classes of ale-py 0.8.1 have other names

import ale_py.env
import gymnasium
import numpy as np
import pytest
from env_tools import needs_new_ale_py
from gymnasium.wrappers import AtariPreprocessing

from atari import AtariEnv

pytestmark = needs_new_ale_py


@pytest.fixture
def pair() -> tuple[AtariEnv, ale_py.env.AtariEnv]:
    """The same state of the same game, in our core and in ale-py."""
    ours, theirs = AtariEnv("seaquest", sound_obs=True), ale_py.env.AtariEnv("seaquest", sound_obs=True)
    for env in (ours, theirs):
        env.reset(seed=1)
        for action in (1, 2, 3, 4) * 5:
            env.step(action)
    return ours, theirs


@pytest.mark.parametrize(
    "method",
    [
        "lives",
        "game_over",
        "game_truncated",
        "getFrameNumber",
        "getEpisodeFrameNumber",
        "getRAMSize",
        "getScreenDims",
        "getAvailableModes",
        "getAvailableDifficulties",
    ],
)
def test_facts_are_those_of_ale_py(pair: tuple[AtariEnv, ale_py.env.AtariEnv], method: str) -> None:
    ours, theirs = (getattr(env.ale, method)() for env in pair)
    assert ours == theirs
    assert type(ours) is type(theirs)


@pytest.mark.parametrize("method", ["getRAM", "getScreen", "getScreenRGB", "getScreenGrayscale", "getAudio"])
def test_arrays_are_those_of_ale_py(pair: tuple[AtariEnv, ale_py.env.AtariEnv], method: str) -> None:
    ours, theirs = (getattr(env.ale, method)() for env in pair)
    assert np.array_equal(ours, theirs)
    buffer = np.zeros_like(ours)
    getattr(pair[0].ale, method)(buffer)
    assert np.array_equal(buffer, theirs)


@pytest.mark.parametrize("method", ["getMinimalActionSet", "getLegalActionSet"])
def test_action_sets_are_those_of_ale_py(pair: tuple[AtariEnv, ale_py.env.AtariEnv], method: str) -> None:
    ours, theirs = (getattr(env.ale, method)() for env in pair)
    assert [(action.name, action.value) for action in ours] == [(action.name, action.value) for action in theirs]
    assert ours == [action.value for action in theirs]


def test_acts_and_pokes_reach_the_core() -> None:
    env = AtariEnv("breakout", repeat_action_probability=0.0)
    env.reset(seed=0)
    env.ale.setRAM(0x4D, 0x07)
    assert env.ale.act(0) == 7
    assert env.core.frame_number == 1
    env.ale.reset_game()
    assert env.core.episode_frame_number == 0


def test_game_over_counts_truncation_unless_disabled() -> None:
    env = AtariEnv("pong", max_num_frames_per_episode=4)
    env.reset(seed=0)
    env.step(0)
    assert env.ale.game_over() is True
    assert env.ale.game_over(with_truncation=False) is False


def test_wrong_calls_raise_as_on_the_core() -> None:
    env = AtariEnv("pong")
    with pytest.raises(ValueError, match=r"an ALE action number is within 0\.\.17, got 99"):
        env.ale.act(99)
    with pytest.raises(ValueError, match=r"index must be within 0\.\.127, got 128"):
        env.ale.setRAM(128, 0)


@pytest.mark.parametrize("game", ["pong", "breakout", "space_invaders"])
def test_gymnasiums_preprocessing_gives_what_it_gives_on_ale_py(game: str) -> None:
    ours, theirs = AtariEnv(game, frameskip=1), ale_py.env.AtariEnv(game, frameskip=1)
    first, second = (AtariPreprocessing(env, terminal_on_life_loss=True) for env in (ours, theirs))
    assert np.array_equal(first.reset(seed=2)[0], second.reset(seed=2)[0])
    rng = np.random.default_rng(0)
    for _ in range(100):
        action = int(rng.integers(len(ours.get_action_meanings())))
        mine, other = first.step(action), second.step(action)
        assert np.array_equal(mine[0], other[0])
        assert mine[1:] == other[1:]
        if mine[2] or mine[3]:
            assert np.array_equal(first.reset()[0], second.reset()[0])


def test_gymnasiums_preprocessing_still_refuses_a_double_frame_skip() -> None:
    with pytest.raises(ValueError, match="Disable frame-skipping in the original env"):
        AtariPreprocessing(gymnasium.make("ALE/Pong-v5"))
