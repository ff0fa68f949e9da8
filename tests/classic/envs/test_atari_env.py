"""`gym.envs.atari.AtariEnv`: Gym's constructor and attributes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from env_tools import AroundAle

import atari
import atari.classic as gym
from atari.classic.envs.atari import AtariEnv


def test_the_defaults_are_gyms() -> None:
    env = AtariEnv()
    assert (env.game, env.frameskip, env.reset().shape) == ("pong", (2, 5), (128,))
    assert env.modern.unwrapped.task.repeat_action_probability == 0.0  # type: ignore[attr-defined]
    assert env.modern.unwrapped.task.max_num_frames_per_episode is None  # type: ignore[attr-defined]
    np.testing.assert_array_equal(env._get_ram(), env.ale.getRAM())


def test_it_plays_as_the_environment_of_this_package() -> None:
    env = AtariEnv("breakout", obs_type="image", frameskip=4, full_action_space=True)
    other = atari.AtariEnv("breakout", frameskip=4, repeat_action_probability=0.0, full_action_space=True)
    env.seed(7)
    np.testing.assert_array_equal(env.reset(), other.reset(seed=7)[0])
    for action in (1, 17, 3):
        observation, reward, done, _ = env.step(action)
        expected = other.step(action)
        np.testing.assert_array_equal(observation, expected[0])
        assert (reward, done) == expected[1:3]


def test_an_assigned_frame_skip_is_played() -> None:
    """Also one with which the environment was not made; a range draws from Gym's generator."""
    env = AtariEnv("pong", frameskip=4)
    twin = AtariEnv("pong", frameskip=3)
    env.frameskip = 3
    for each in (env, twin):
        each.seed(1)
        each.reset()
    for action in (2, 0, 3):
        np.testing.assert_array_equal(env.step(action)[0], twin.step(action)[0])
    env.frameskip = (2, 5)
    env.seed(1)
    draws = gym.utils.seeding.np_random(1)[0]
    before = env.ale.getEpisodeFrameNumber()
    for _ in range(6):
        env.step(0)
        frames, before = env.ale.getEpisodeFrameNumber() - before, env.ale.getEpisodeFrameNumber()
        assert frames == draws.randint(2, 5)
    assert (env.frameskip, twin.frameskip) == ((2, 5), 3)


@pytest.mark.parametrize("wrong", [0, -1, 1.5, "four", (5, 2)])
def test_a_wrong_frame_skip_changes_nothing(wrong: Any) -> None:
    env = AtariEnv("pong", frameskip=4)
    with pytest.raises((TypeError, ValueError), match="frameskip"):
        env.frameskip = wrong
    assert env.frameskip == 4


def test_the_emulator_takes_texts_as_bytes(tmp_path: Path) -> None:
    env: Any = AtariEnv("pong")
    env.reset()
    env.ale.setFloat(b"repeat_action_probability", 0.5)
    assert env.ale.getFloat("repeat_action_probability") == env.ale.getFloat(b"repeat_action_probability") == 0.5
    env.ale.setInt(b"random_seed", 5)
    np.testing.assert_array_equal(env.ale.getScreenRGB2(), env._get_image())
    env.ale.saveScreenPNG(str(tmp_path / "screen.png").encode())
    assert (tmp_path / "screen.png").stat().st_size > 100
    gray, before = np.zeros((210, 160), np.uint8), env.ale.getRAM()
    env.ale.getScreenGrayscale(gray)
    assert gray.max() > 0
    env.ale.act(env._action_set[1])
    assert (env.ale.getRAM() != before).any()
    with pytest.raises(AttributeError, match="nothing"):
        env.ale.nothing()


def test_options_of_make_have_gyms_names() -> None:
    env: Any = gym.make("Pong-ram-v0", obs_type="image", frameskip=2).unwrapped
    assert (env.reset().shape, env.frameskip) == ((210, 160, 3), 2)
    assert isinstance(env, AtariEnv)
    assert (env.step(0)[3]["frame_number"], isinstance(gym.make("CartPole-v1").unwrapped, AtariEnv)) == (2, False)
    with pytest.raises(TypeError):
        gym.make("Pong-v0", framskip=2)


def test_keys_and_numbers_of_actions() -> None:
    env: Any = gym.make("Pong-v0").unwrapped
    assert env.get_keys_to_action() == {(): 0, (32,): 1, (100,): 2, (97,): 3, (32, 100): 4, (32, 97): 5}
    assert [int(env._action_set[action]) for action in range(3)] == [0, 1, 3]


def test_a_state_brings_the_game_back() -> None:
    env: Any = gym.make("Breakout-v0").unwrapped
    env.seed(0)  # sticky actions of another seed can keep the paddle where it is
    env.reset()
    env.step(1)
    for clone, restore in ((env.clone_full_state, env.restore_full_state), (env.clone_state, env.restore_state)):
        state, image = clone(), env._get_image()
        env.step(2)
        assert (env._get_image() != image).any()
        restore(state)
        np.testing.assert_array_equal(env._get_image(), image)


@pytest.mark.parametrize("wrong", [{"game": "pnog"}, {"obs_type": "picture"}, {"frameskip": 0}])
def test_wrong_arguments(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r".{10}"):
        AtariEnv(**wrong)


def test_an_object_around_the_emulator_can_be_assigned() -> None:
    class Dark(AroundAle):
        def getScreenRGB(self, *buffer: Any) -> Any:
            return self.inner.getScreenRGB(*buffer) // 2

    env, twin = AtariEnv("pong", obs_type="image", frameskip=4), AtariEnv("pong", obs_type="image", frameskip=4)
    own = env.ale
    env.unwrapped.ale = Dark(env.unwrapped.ale)  # type: ignore[attr-defined]
    for each in (env, twin):
        each.seed(0)
    np.testing.assert_array_equal(env.reset(), twin.reset() // 2)
    np.testing.assert_array_equal(env.step(2)[0], twin.step(2)[0] // 2)
    np.testing.assert_array_equal(env.ale.getScreenRGB2(), twin.ale.getScreenRGB2() // 2)
    env.ale = own
    np.testing.assert_array_equal(env.step(2)[0], twin.step(2)[0])
