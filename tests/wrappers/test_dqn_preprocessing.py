"""Every observation equals one computed in the simplest way, frame by frame."""

from typing import get_args

import cv2
import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.wrappers import RecordEpisodeStatistics, TimeLimit

from atari import PRESETS, AtariEnv, wrappers
from atari.wrappers import DqnPreprocessing, EpisodicLife, FireReset, FrameStack, NoopReset
from atari.wrappers.dqn_preprocessing import EndFrames

ACTIONS = [1, 2, 3, 0, 2, 2, 1, 3, 3, 0, 1, 2] * 3


class Through(gymnasium.Wrapper):
    """Passes each step on; an outer `DqnPreprocessing` has to call its `step`."""

    def step(self, action):
        return self.env.step(action)


def small(frame, size=(84, 84)):
    return cv2.resize(frame, size, interpolation=cv2.INTER_AREA)


def gray_of_rgb(frame):
    return cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY)


def play(env: AtariEnv, action, frames=4):
    """The gray screens and RGB screens of these frames, and their rewards."""
    gray, rgb, rewards = [], [], []
    for _ in range(frames):
        _, reward, terminated, truncated, _ = env.step(action)
        gray.append(env.core.screen_grayscale())
        rgb.append(env.core.screen_rgb())
        rewards.append(reward)
        if terminated or truncated:
            break
    return gray, rgb, rewards


PREPROCESSED = {
    "default": ({}, lambda gray, rgb: small(np.maximum(*gray[-2:]))),
    "not pooled": ({"max_pool": False}, lambda gray, rgb: small(gray[-1])),
    "every frame": ({"frame_skip": 1}, lambda gray, rgb: small(gray[-1])),
    "two frames": ({"frame_skip": 2}, lambda gray, rgb: small(np.maximum(*gray))),
    "pooled as RGB": ({"pool_rgb": True}, lambda gray, rgb: small(gray_of_rgb(np.maximum(*rgb[-2:])))),
    "colour": ({"grayscale": False}, lambda gray, rgb: small(np.maximum(*rgb[-2:]))),
    "tall": ({"screen_size": (84, 110)}, lambda gray, rgb: small(np.maximum(*gray[-2:]), (84, 110))),
    "full size": ({"screen_size": (160, 210)}, lambda gray, rgb: np.maximum(*gray[-2:])),
    "the screen's size": ({"screen_size": None}, lambda gray, rgb: np.maximum(*gray[-2:])),
    "the screen's rows": ({"screen_size": (84, None)}, lambda gray, rgb: small(np.maximum(*gray[-2:]), (84, 210))),
    "enlarged": ({"screen_size": (200, 300)}, lambda gray, rgb: small(np.maximum(*gray[-2:]), (200, 300))),
    "narrow, in colour": (
        {"screen_size": (7, 84), "grayscale": False},
        lambda gray, rgb: small(np.maximum(*rgb[-2:]), (7, 84)),
    ),
    "enlarged, pooled as RGB": (
        {"screen_size": 170, "pool_rgb": True},
        lambda gray, rgb: small(gray_of_rgb(np.maximum(*rgb[-2:])), (170, 170)),
    ),
    "the screen in colour": ({"screen_size": None, "grayscale": False}, lambda gray, rgb: np.maximum(*rgb[-2:])),
    "Gymnasium": ({"end_frames": "gymnasium"}, lambda gray, rgb: small(np.maximum(*gray[-2:]))),
    "Baselines": ({"end_frames": "baselines"}, lambda gray, rgb: small(np.maximum(*gray[-2:]))),
    "EnvPool": ({"end_frames": "envpool"}, lambda gray, rgb: small(np.maximum(*gray[-2:]))),
}


@pytest.mark.parametrize("name", PREPROCESSED)
@pytest.mark.parametrize("game", ["seaquest", "breakout"])
def test_frames_stacks_and_rewards(game_env, game, name):
    arguments, preprocessed = PREPROCESSED[name]
    env, raw = DqnPreprocessing(game_env(game), **arguments), game_env(game)
    observation, info = env.reset(seed=0)
    assert info == raw.reset(seed=0)[1]
    stack = [preprocessed([raw.core.screen_grayscale()] * 2, [raw.core.screen_rgb()] * 2)] * 4
    assert env.observation_space.shape == np.shape(stack)
    np.testing.assert_array_equal(observation, stack)
    for action in ACTIONS:
        observation, reward, terminated, truncated, info = env.step(action)
        gray, rgb, rewards = play(raw, action, env.frame_skip)
        stack = [*stack[1:], preprocessed(gray, rgb)]
        np.testing.assert_array_equal(observation, stack)
        assert (reward, terminated, truncated, info) == (sum(rewards), False, False, raw.driver.info())


def test_zero_padding(game_env):
    env = DqnPreprocessing(game_env("pong"), padding_type="zero")
    for _ in range(2):
        observation, _ = env.reset(seed=0)
        assert [int(frame.max()) > 0 for frame in observation] == [False, False, False, True]
        observation = env.step(0)[0]
        assert [int(frame.max()) > 0 for frame in observation] == [False, False, True, True]


def test_without_a_stack(game_env):
    env, stacked = DqnPreprocessing(game_env("pong"), stack_size=None), DqnPreprocessing(game_env("pong"))
    assert env.observation_space.shape == (84, 84)
    np.testing.assert_array_equal(env.reset(seed=0)[0], stacked.reset(seed=0)[0][-1])
    for action in ACTIONS:
        np.testing.assert_array_equal(env.step(action)[0], stacked.step(action)[0][-1])


def pooled(*frames):
    return np.maximum.reduce(frames)


class Shown:
    """The new frame of an observation after each skip, as `end_frames` describes it."""

    def __init__(self, mode, first):
        self.mode, self.image, self.late = mode, first, np.zeros_like(first)

    def after(self, frames, skip, ended):
        """The frame after these frames of a skip, the last of which ended the episode or not."""
        whole = len(frames) == skip
        last_two = whole or len(frames) == skip - 1
        if whole and not (ended and self.mode == "gymnasium"):
            self.late = frames[-1]
            self.image = pooled(*frames[-2:])
        elif self.mode == "last":
            self.image = frames[-1]
        elif self.mode == "gymnasium" and whole and skip > 1:
            self.image = pooled(frames[-2], self.image)
        elif self.mode == "baselines" and last_two:
            self.image = pooled(frames[-1], self.late)
        elif self.mode == "envpool" and last_two:
            self.image = frames[-1]
        return small(self.image)


@pytest.mark.parametrize("layer", [lambda env: env, Through], ids=["direct", "through"])
@pytest.mark.parametrize("mode", get_args(EndFrames))
@pytest.mark.parametrize("frame_skip", [(1, 3), (1, 5), (2, 4), (4, 5), (1, 2)])
def test_random_skips(game_env, frame_skip, mode, layer):
    """With limits that end the episode in the first steps, of which each is long or short."""
    ends = []
    for limit in range(1, 14):
        options = {"max_num_frames_per_episode": limit}
        env = DqnPreprocessing(layer(game_env("seaquest", **options)), frame_skip, end_frames=mode)
        raw = game_env("seaquest", **options)
        env.reset(seed=limit)
        raw.reset(seed=limit)
        shown = Shown(mode, raw.core.screen_grayscale())
        truncated = False
        while not truncated:
            skip = int(raw.np_random.integers(*frame_skip))
            frames = play(raw, 3, skip)[0]
            observation, *_, truncated, info = env.step(3)
            assert truncated == raw.core.truncated
            assert info == raw.driver.info()
            np.testing.assert_array_equal(observation[-1], shown.after(frames, skip, truncated))
        assert env.np_random.bit_generator.state == raw.np_random.bit_generator.state
        ends.append((len(frames), skip))
    assert len(set(ends)) >= (4 if frame_skip == (4, 5) else min(3, frame_skip[1] - 1))


def test_a_range_of_one_length_is_a_number(game_env):
    env = DqnPreprocessing(game_env("pong"), (3, 4))
    assert env.frame_skip == 3
    env.reset(seed=0)
    assert env.step(0)[4]["episode_frame_number"] == 3
    assert DqnPreprocessing(game_env("pong"), [2, 5]).frame_skip == (2, 5)


@pytest.mark.parametrize("mode", get_args(EndFrames))
def test_without_pooling_a_first_skip_that_is_cut_shows_the_reset_or_the_end(game_env, mode):
    env = DqnPreprocessing(game_env("seaquest", max_num_frames_per_episode=2), max_pool=False, end_frames=mode)
    first, _ = env.reset(seed=0)
    frame = env.step(3)[0][-1]
    last = small(env.unwrapped.core.screen_grayscale())
    assert not np.array_equal(first[-1], last)
    np.testing.assert_array_equal(frame, last if mode == "last" else first[-1])


@pytest.mark.parametrize("obs_type", ["rgb", "ram"])
@pytest.mark.parametrize("layer", [lambda env: env, Through], ids=["direct", "through"])
def test_ram(game_env, layer, obs_type):
    inner = FireReset(EpisodicLife(layer(game_env("breakout", obs_type=obs_type)), "continue"))
    env = DqnPreprocessing(inner, (2, 5), stack_size=None, obs_type="ram", max_frames=150)
    images = DqnPreprocessing(FireReset(EpisodicLife(game_env("breakout"), "continue")), (2, 5), max_frames=150)
    assert env.observation_space == game_env("breakout", obs_type="ram").observation_space
    ends = 0
    for seed in (3, 4, None):
        observation, info = env.reset(seed=seed)
        assert info == images.reset(seed=seed)[1]
        ended = False
        while not ended:
            np.testing.assert_array_equal(observation, images.unwrapped.core.ram())
            assert observation in env.observation_space
            observation, *rest = env.step(2)
            assert rest == list(images.step(2)[1:])
            ended = rest[1] or rest[2]
            ends += ended
    assert ends == 3


@pytest.mark.parametrize(
    ("layer", "padding", "core"),
    [
        (lambda env: env, "zero", "ale"),
        (Through, "reset", "ale"),
        (lambda env: env, "reset", "native"),
        (Through, "zero", "native"),
    ],
)
def test_stacks_of_ram(game_env, layer, padding, core):
    """They are those of `FrameStack` around single RAM vectors; with `seamless_lives` they go on."""

    def made(**arguments):
        inner = FireReset(EpisodicLife(layer(game_env("breakout", core=core)), "continue"))
        return DqnPreprocessing(inner, obs_type="ram", **arguments)

    env = made(stack_size=3, padding_type=padding)
    seamless = made(stack_size=3, padding_type=padding, seamless_lives=True)
    expected = FrameStack(made(stack_size=None), 3, padding)
    assert env.observation_space == expected.observation_space
    ends = 0
    observation, _ = env.reset(seed=3)
    np.testing.assert_array_equal(observation, expected.reset(seed=3)[0])
    seamless.reset(seed=3)
    for step in range(200):
        observation, _, terminated, _, _ = env.step(1 if step % 20 == 0 else 2)
        np.testing.assert_array_equal(observation, expected.step(1 if step % 20 == 0 else 2)[0])
        if terminated:
            ends += 1
            np.testing.assert_array_equal(env.reset()[0], expected.reset()[0])
    while not (result := seamless.step(2))[2]:
        pass
    np.testing.assert_array_equal(seamless.reset()[0][:2], result[0][1:])
    assert ends > 1


@pytest.mark.parametrize("name", PRESETS)
def test_driving_the_emulator_and_going_through_wrappers_give_the_same(game_env, name):
    for game, limit in (("breakout", None), ("bank_heist", 403)):
        options = {**wrappers.preset_options(name), "max_num_frames_per_episode": limit}
        direct = wrappers.preset(game_env(game, **options), name, episodic_life=True)
        through = wrappers.preset(Through(game_env(game, **options)), name, episodic_life=True)
        rng = np.random.default_rng(1)
        results = [direct.reset(seed=5), through.reset(seed=5)]
        assert data_equivalence(*results)
        ends = 0
        for _ in range(250):
            action = int(rng.integers(direct.action_space.n))
            results = [direct.step(action), through.step(action)]
            for result in results:
                result[4].get("episode", {}).pop("t", None)  # seconds
            assert data_equivalence(*results)
            if results[0][2] or results[0][3]:
                ends += 1
                assert data_equivalence(direct.reset(), through.reset())
        assert ends > 1
        assert direct.unwrapped.snapshot() == through.unwrapped.snapshot()


def test_actions_with_strength(game_env):
    env, raw = DqnPreprocessing(game_env("pong", continuous=True)), game_env("pong", continuous=True)
    env.reset(seed=0)
    raw.reset(seed=0)
    for angle in np.linspace(-3, 3, 20, dtype=np.float32):
        action = np.array([0.7, angle, 1.0], np.float32)
        observation = env.step(action)[0]
        np.testing.assert_array_equal(observation[-1], small(np.maximum(*play(raw, action)[0][-2:])))


@pytest.mark.parametrize("layer", [lambda env: env, Through], ids=["direct", "through"])
def test_max_frames(game_env, layer):
    env = DqnPreprocessing(NoopReset(layer(game_env("pong"))), max_frames=10)
    for _ in range(2):
        env.reset(options={"noops": 7})
        flags = [env.step(0)[2:4] for _ in range(3)]
        assert flags == [(False, False), (False, False), (False, True)]
        assert env.unwrapped.core.episode_frame_number == 17


@pytest.mark.parametrize("layer", [lambda env: env, Through], ids=["direct", "through"])
def test_a_life_lost_in_an_inner_wrapper_ends_the_skip_at_that_frame(game_env, layer):
    env = DqnPreprocessing(EpisodicLife(layer(game_env("breakout")), "continue"))
    frame, _ = lose_a_life(env)
    assert frame % 4 != 0
    assert env.reset()[1]["episode_frame_number"] == frame
    assert env.step(0)[4]["episode_frame_number"] == frame + 4


@pytest.mark.parametrize("layer", [lambda env: env, Through], ids=["direct", "through"])
def test_seamless_lives_play_the_skip_to_its_end_and_keep_the_stack(game_env, layer):
    started = FireReset(EpisodicLife(layer(game_env("breakout")), "continue"))
    env = DqnPreprocessing(started, seamless_lives=True)
    frame, before = lose_a_life(env)
    assert frame % 4 == 1, "one of FIRE, and whole skips"
    after, info = env.reset()
    assert info["episode_frame_number"] == frame + 1
    np.testing.assert_array_equal(after[:3], before[1:])
    np.testing.assert_array_equal(after[3], small(env.unwrapped.core.screen_grayscale()))


def lose_a_life(env):
    """Play until the first life is lost; return the frame at which the step ended, and its observation."""
    env.reset(seed=0)
    lives = env.unwrapped.core.lives
    for step in range(200):
        observation, _, terminated, truncated, info = env.step(1 if step == 0 else 2)
        assert not truncated
        assert terminated == (info["lives"] < lives)
        if terminated:
            return info["episode_frame_number"], observation
    raise AssertionError("no life was lost")


def test_the_limit_ends_the_game_for_an_inner_episodic_life(game_env):
    env = DqnPreprocessing(EpisodicLife(game_env("breakout"), "continue"), max_frames=300)
    env.reset(seed=0)
    env.step(1)
    truncated = False
    lost = 0
    while not truncated:
        _, _, terminated, truncated, _ = env.step(2)
        if terminated and not truncated:
            lost += 1
            env.reset()
    assert lost >= 1
    assert env.unwrapped.core.lives < 5
    assert env.reset()[1]["lives"] == 5


def test_inner_wrappers_are_respected(game_env):
    env = DqnPreprocessing(RecordEpisodeStatistics(TimeLimit(game_env("pong"), 10)))
    env.reset(seed=0)
    assert [env.step(0)[3] for _ in range(2)] == [False, False]
    *_, truncated, info = env.step(0)
    assert truncated
    assert info["episode"]["l"] == 10


def test_rendering_sees_every_frame(game_env):
    env = DqnPreprocessing(game_env("pong", render_mode="rgb_array_list"))
    env.reset(seed=0)
    env.step(0)
    env.step(0)
    frames = env.render()
    assert len(frames) == 9
    np.testing.assert_array_equal(frames[-1], env.unwrapped.core.screen_rgb())


def test_step_needs_a_reset_and_an_action_of_the_space(game_env):
    env = DqnPreprocessing(game_env("pong"))
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(0)
    env.reset(seed=0)
    state = env.unwrapped.snapshot()
    with pytest.raises(ValueError, match=r"action 6 is not within 0..5"):
        env.step(6)
    with pytest.raises(TypeError, match="an action is an integer"):
        env.step("UP")
    assert env.unwrapped.snapshot() == state
