from dataclasses import replace

import gymnasium
import numpy as np
import pytest

from atari.games.catalog import games
from atari.wrappers import (
    DqnPreprocessing,
    EpisodicLife,
    FireReset,
    FrameSkip,
    FrameStack,
    Grayscale,
    NoopReset,
)
from atari.wrappers._checks import step_named


def number_of_noops(env, seed):
    before = len(env.unwrapped.actions)
    env.reset(seed=seed)
    return len(env.unwrapped.actions) - before


@pytest.mark.parametrize(("arguments", "low", "high"), [({}, 1, 30), ({"noop_max": 5, "noop_min": 3}, 3, 5)])
def test_draws_from_the_environments_generator_as_gymnasium_does(scripted, arguments, low, high):
    env = NoopReset(scripted(), **arguments)
    expected = [int(np.random.Generator(np.random.PCG64(seed)).integers(low, high + 1)) for seed in range(20)]
    assert [number_of_noops(env, seed) for seed in range(20)] == expected
    assert len(set(expected)) > 2


@pytest.mark.parametrize("noops", [0, 7, 100])
def test_the_number_can_be_chosen(scripted, noops):
    env = NoopReset(scripted())
    observation, info = env.reset(options={"noops": noops})
    assert env.unwrapped.actions == [0] * noops
    np.testing.assert_array_equal(observation, np.full((6, 4), noops))
    assert info == {"lives": 0, "frame": noops}


def test_noop_max_zero_draws_nothing(scripted):
    env = NoopReset(scripted(), noop_max=0)
    env.reset(seed=1)
    assert env.unwrapped.actions == []
    assert env.np_random.bit_generator.state == np.random.PCG64(1).state


def test_fire_counts_as_one_of_the_noops(scripted):
    with_fire = NoopReset(scripted(), noop_min=0, fire_counts=True)
    without = NoopReset(scripted(meanings=["NOOP", "UP"]), noop_min=0, fire_counts=True)
    drawn = [int(np.random.Generator(np.random.PCG64(seed)).integers(0, 31)) for seed in range(40)]
    assert 0 in drawn
    assert [number_of_noops(with_fire, seed) for seed in range(40)] == [max(n - 1, 0) for n in drawn]
    assert [number_of_noops(without, seed) for seed in range(40)] == drawn


@pytest.mark.parametrize("end", ["ends", "limit"])
def test_an_episode_that_ends_meanwhile_is_started_again(scripted, end):
    env = NoopReset(scripted(**{end: 4}))
    observation, info = env.reset(seed=9, options={"noops": 6})
    assert env.unwrapped.resets == [(9, None)] * 2
    assert info["frame"] == 2
    assert observation.max() == 2


def test_does_nothing_with_a_stick_at_rest(game_env):
    env = NoopReset(game_env("pong", continuous=True))
    still = game_env("pong")
    env.reset(seed=0, options={"noops": 20})
    still.reset(seed=0)
    for _ in range(20):
        still.step(0)
    np.testing.assert_array_equal(env.unwrapped.core.ram(), still.core.ram())


@pytest.mark.parametrize("game", ["backgammon", "video_checkers"])
def test_does_nothing_where_that_is_no_action(game_env, game):
    env, full = NoopReset(game_env(game)), game_env(game, full_action_space=True)
    assert "NOOP" not in env.unwrapped.get_action_meanings()
    observation, info = env.reset(seed=0, options={"noops": 20})
    full.reset(seed=0)
    for _ in range(20):
        expected, *_, expected_info = full.step(0)
    np.testing.assert_array_equal(observation, expected)
    np.testing.assert_array_equal(env.unwrapped.core.ram(), full.core.ram())
    assert {key: info[key] for key in expected_info} == expected_info


@pytest.mark.parametrize(
    ("layer", "arguments"),
    [(Grayscale, {}), (FrameSkip, {}), (FrameStack, {}), (DqnPreprocessing, {}), (DqnPreprocessing, {"frame_skip": 3})],
)
def test_where_that_is_no_action_each_layer_plays_it(game_env, layer, arguments):
    """Outside of a frame skip a no-op is a whole skip, and the observation is as after any other step."""
    env = NoopReset(layer(game_env("backgammon"), **arguments))
    full = layer(game_env("backgammon", full_action_space=True), **arguments)
    observation, info = env.reset(seed=0, options={"noops": 6})
    full.reset(seed=0)
    for _ in range(6):
        expected, *_, expected_info = full.step(0)
    assert observation in env.observation_space
    np.testing.assert_array_equal(observation, expected)
    assert {key: info[key] for key in expected_info} == expected_info
    for action in (0, 1, 2):  # which are again those of the game
        name = env.unwrapped.get_action_meanings()[action]
        expected = full.step(full.unwrapped.get_action_meanings().index(name))[0]
        np.testing.assert_array_equal(env.step(action)[0], expected)


def without_noop():
    """Breakout as a game that lacks NOOP."""
    game = games.find("breakout")
    return replace(game, minimal_actions=game.minimal_actions[1:])


def test_where_that_is_no_action_an_inner_episodic_life_does_not_see_it(game_env):
    """Lives lost in the no-ops are compared at the next step."""
    env = NoopReset(EpisodicLife(game_env(without_noop())))
    env.reset(seed=0, options={"noops": 3})
    env.unwrapped.core.set_ram(0x39, 4)  # a life less
    *_, terminated, truncated, info = step_named(env.env, "NOOP")
    assert (terminated, truncated, info["lives"], info["episode_frame_number"]) == (False, False, 4, 4)
    *_, terminated, truncated, info = env.step(0)
    assert (terminated, truncated, info["lives"], info["episode_frame_number"]) == (True, False, 4, 5)


def test_a_noop_that_fails_leaves_the_actions(game_env):
    env = NoopReset(game_env("backgammon"))
    with pytest.raises(gymnasium.error.ResetNeeded):
        step_named(env.env, "NOOP")
    with pytest.raises(ValueError, match="action 99 is not within"):
        env.unwrapped.step(99)


class TestFireAgain:
    """Breakout with a limit of 5 frames, which ends the episode in its no-ops."""

    def test_the_options_of_others_are_passed_on(self, scripted):
        env = NoopReset(FireReset(scripted(ends=3)), fire_again=False)
        env.reset(seed=4, options={"noops": 3, "mine": 1})
        assert env.unwrapped.actions == [1, 0, 0, 0]
        assert env.unwrapped.resets == [(4, {"mine": 1})] * 2
        env.reset()
        assert env.unwrapped.actions[4] == 1, "the next reset presses it"
