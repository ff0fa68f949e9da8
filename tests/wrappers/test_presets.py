"""Presets equal the implementations that they are named after, to the byte; and the rules about options and names.

This file compares Gymnasium and ale-py; `tests/peers` compares the other implementations.
"""

import warnings
from typing import Any

import ale_py
import cv2
import gymnasium
import numpy as np
import pytest

import atari
from atari import PRESETS, Action, games
from atari.wrappers import ClipReward, DqnPreprocessing, EpisodicLife, NoopReset, preset, preset_options
from atari.wrappers.layers import layers_of, wrap

# Lives lost, several ends of game, no FIRE (ms_pacman, bank_heist), lives at 0 before the end (bank_heist, frogger), a
# screen of 214 lines (carnival) and of 250 (pacman).
GAMES = {"breakout": 210, "ms_pacman": 200, "bank_heist": 180, "frogger": 260, "carnival": 400, "pacman": 270}
"""The games, each with steps in which an episode of a life ends; in Breakout, all five lives are lost."""
INFO = ("lives", "episode_frame_number", "frame_number")


@pytest.mark.parametrize("game", GAMES)
@pytest.mark.parametrize(
    ("episodic_life", "probability", "limit", "steps"),
    [(False, 0.0, None, 120), (True, 0.25, None, None), (True, 0.25, 402, 110)],
)
def test_gymnasium(game_env, game, episodic_life, probability, limit, steps):
    options = {"repeat_action_probability": probability, "max_num_frames_per_episode": limit}
    theirs = gymnasium.wrappers.FrameStackObservation(
        gymnasium.wrappers.AtariPreprocessing(
            ale_py.AtariEnv(game, frameskip=1, **options), terminal_on_life_loss=episodic_life
        ),
        4,
    )
    ours = preset(game_env(game, **options), "gymnasium", episodic_life=episodic_life)
    assert ours.observation_space == theirs.observation_space
    rng = np.random.default_rng(7)
    expected, info = theirs.reset(seed=7)
    observation, own_info = ours.reset(seed=7)
    ends = 0
    for _ in range(steps or GAMES[game]):
        np.testing.assert_array_equal(observation, expected)
        assert [own_info[key] for key in INFO] == [info[key] for key in INFO]
        action = int(rng.integers(ours.action_space.n))
        expected, *signals, info = theirs.step(action)
        observation, *own_signals, own_info = ours.step(action)
        assert own_signals == signals
        if signals[1] or signals[2]:
            ends += 1
            np.testing.assert_array_equal(observation, expected)
            expected, info = theirs.reset()
            observation, own_info = ours.reset()
    assert ends > 0 or not (episodic_life or limit)


@pytest.mark.parametrize("game", GAMES)
@pytest.mark.parametrize(
    ("episodic_life", "probability", "limit", "steps"),
    [(False, 0.0, 108_000, 120), (True, 0.25, 108_000, None), (False, 0.25, 403, 110)],
)
def test_ale_vector(game_env, game, episodic_life, probability, limit, steps):
    theirs = ale_py.AtariVectorEnv(
        game, 1, episodic_life=episodic_life, repeat_action_probability=probability, max_num_frames_per_episode=limit
    )
    env = game_env(game, **{**preset_options("ale_vector"), "repeat_action_probability": probability})
    ours = limited(env, "ale_vector", limit, episodic_life=episodic_life)
    env.reset()
    before = env.core.episode_frame_number + ("FIRE" in env.get_action_meanings())

    def reset(info):
        """The same start as ale-py's; the frame number determines the number of no-ops."""
        return ours.reset(options={"noops": max(int(info["episode_frame_number"][0]) - before, 0)})

    rng = np.random.default_rng(7)
    expected, info = theirs.reset(seed=11)
    env.core.seed(11)  # ale-py's seeds are the emulator's own
    observation, own_info = reset(info)
    ended = False
    ends = 0
    for _ in range(steps or GAMES[game]):
        np.testing.assert_array_equal(observation, expected[0])
        assert [own_info[key] for key in INFO] == [info[key][0] for key in INFO]
        action = int(rng.integers(env.action_space.n))
        expected, *signals, info = theirs.step(np.array([action]))
        if ended:  # ale-py's step was the reset
            ends += 1
            observation, own_info = reset(info)
            own_signals = [0, False, False]
        else:
            observation, *own_signals, own_info = ours.step(action)
        assert own_signals == [signal[0] for signal in signals]
        ended = own_signals[1] or own_signals[2]
    assert ends > 0 or game == "carnival" or not (episodic_life or limit < 1000)


def limited(env, name, limit, **changes):
    """A preset with another `max_frames`, to reach it soon."""
    preset(env, name, **changes)
    return wrap(env, env.task.replace(max_frames=limit))


@pytest.mark.parametrize(("name", "low", "high"), [("ale_vector", 0, 29), ("envpool", 1, 30)])
def test_fire_is_one_of_the_noops(game_env, name, low, high):
    drawn = {seed: drawn_noops(game_env("ms_pacman"), seed, low, high) for seed in range(5)}
    without_fire, with_fire = preset(game_env("ms_pacman"), name), preset(game_env("breakout"), name)
    for seed, noops in drawn.items():
        assert without_fire.reset(seed=seed)[1]["episode_frame_number"] == noops
        assert with_fire.reset(seed=seed)[1]["episode_frame_number"] == max(noops, 1)


def drawn_noops(env, seed, low, high):
    """The first number that a seeded environment draws."""
    env.reset(seed=seed)
    return int(env.np_random.integers(low, high + 1))


class TestProtocols:
    """The values in the publications; no program defines this preset."""

    def test_dqn2015(self, game_env):
        env, raw = preset(game_env("seaquest"), "dqn2015"), game_env("seaquest")
        observation, _ = env.reset(seed=1, options={"noops": 9})
        raw.reset(seed=1)
        for _ in range(9):
            raw.step(0)
        assert [frame.any() for frame in observation] == [False, False, False, True]
        np.testing.assert_array_equal(observation[3], luminance(raw.core.screen_rgb()))
        for action in (2, 5, 3, 4) * 5:
            screens = [raw.step(action)[0] for _ in range(4)]
            observation = env.step(action)[0]
            np.testing.assert_array_equal(observation[3], luminance(np.maximum(*screens[2:])))

    def test_dqn2015_after_a_lost_life(self, game_env):
        env = preset(game_env("breakout"), "dqn2015")
        env.reset(seed=1)
        frame = play_until_the_end(env)
        assert env.unwrapped.core.lives == 4
        assert not env.unwrapped.core.game_over
        _, info = env.reset(options={"noops": 12})
        assert info["episode_frame_number"] == frame + 12

    @pytest.mark.parametrize("name", ["dopamine", "atari100k"])
    def test_a_new_episode_in_the_same_game_shows_the_screen_alone(self, game_env, name):
        env = preset(game_env("breakout", **preset_options(name)), name, episodic_life=True)
        env.reset(seed=1)
        frame = play_until_the_end(env)
        observation, info = env.reset()
        assert info["episode_frame_number"] == frame
        assert [frame.any() for frame in observation] == [False, False, False, True]

    def test_machado2018(self, game_env):
        env = preset(game_env("breakout", **preset_options("machado2018")), "machado2018")
        assert env.action_space.n == 18
        env.reset(seed=1)
        assert env.unwrapped.core.episode_frame_number == 0
        play_until_the_end(env)
        assert env.unwrapped.core.game_over

    @pytest.mark.parametrize("name", PRESETS)
    def test_rewards(self, game_env, name):
        """Invaders score 5 to 30 points, 1 after clipping."""
        env = preset(game_env("space_invaders", **preset_options(name)), name, episodic_life=False)
        env.reset(seed=1)
        rng = np.random.default_rng(0)
        highest = max(env.step(int(rng.integers(env.action_space.n)))[1] for _ in range(150))
        assert highest == 1.0 if PRESETS[name].fields["reward_clipping"] else highest >= 5.0


def luminance(rgb):
    return cv2.resize(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), (84, 84), interpolation=cv2.INTER_AREA)


def play_until_the_end(env):
    for step in range(3000):
        _, _, terminated, truncated, info = env.step(1 if step % 10 == 0 else 2)
        assert not truncated
        if terminated:
            return info["episode_frame_number"]
    raise AssertionError("no end")


def test_switches_for_training_and_evaluation(game_env):
    def kinds(**changes):
        env = preset(game_env("breakout"), "baselines", **changes)
        return [kind for kind, _ in layers_of(env.unwrapped.task)]

    assert EpisodicLife in kinds()
    assert ClipReward in kinds()
    assert not {EpisodicLife, ClipReward} & set(kinds(episodic_life=False, clip_reward=False))
    assert {DqnPreprocessing, NoopReset} <= set(kinds(episodic_life=False, clip_reward=False))


def test_every_game_has_the_actions_that_baselines_presses():
    """Action 2 after FIRE: `preset` would raise for a game with fewer."""
    assert all(len(game.minimal_actions) > 2 for game in games.playable() if Action.FIRE in game.minimal_actions)


def test_the_set_of_actions_counts_not_the_option(game_env):
    assert len(games["boxing"].minimal_actions) == 18
    preset(game_env("boxing", full_action_space=False, repeat_action_probability=0.25), "machado2018")
    preset(game_env("boxing", full_action_space=True), "dqn2015")


def test_ram(game_env):
    env = preset(game_env("pong", obs_type="ram"), "gymnasium")
    assert env.reset(seed=0)[0].shape == (128,)


def test_options_are_a_copy(game_env):
    preset_options("dqn2015")["frameskip"] = 4
    assert preset_options("dqn2015")["frameskip"] == 1


def standing(game: str, action: int, steps: int, **options: Any) -> list[str]:
    """The warnings of an agent that always does the same."""
    env = atari.make(game, preset="baselines", **options)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        env.reset(seed=0)
        for _ in range(steps):
            *_, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()
    return [str(warning.message) for warning in caught]


def test_an_evaluation_that_never_presses_fire_warns_once() -> None:
    """Without `episodic_life`, the reset presses FIRE for the first ball only."""
    (text,) = standing("breakout", 0, 5_000, episodic_life=False)
    assert "breakout gave no reward and took no life for 2250 steps; it may wait for FIRE" in text
    assert standing("breakout", 1, 5_000, episodic_life=False) == []
    assert standing("breakout", 0, 5_000, episodic_life=True) == []
    assert standing("freeway", 0, 5_000) == []
