import gymnasium
import numpy as np
import pytest

from atari.wrappers import DqnPreprocessing, EpisodicLife


def lives(t):
    """Three lives; one is lost at frame 3, one at 6, the last at 9, and the game is over at 12."""
    return 3 - t // 3 if t < 9 else 0


def episode(env, steps=20):
    """Frame numbers at which an episode ended, and what the flags were."""
    for _ in range(steps):
        _, _, terminated, truncated, info = env.step(2)
        if terminated or truncated:
            return info["frame"], terminated, truncated
    raise AssertionError("no end")


@pytest.fixture
def env(scripted):
    return scripted(lives=lives, ends=12)


def test_ends_at_each_lost_life_and_goes_on_with_a_noop(env):
    env = EpisodicLife(env)
    env.reset(seed=0)
    assert episode(env) == (3, True, False)
    observation, info = env.reset()
    assert info["frame"] == 4
    assert observation.max() == 4
    assert env.unwrapped.actions[-1] == 0
    assert episode(env) == (6, True, False)
    env.reset()
    assert episode(env) == (12, True, False), "the loss of the last life is not an end, the end of the game is"
    _, info = env.reset()
    assert info["frame"] == 0
    assert len(env.unwrapped.resets) == 2


def test_continue_plays_nothing(env):
    env = EpisodicLife(env, "continue")
    env.reset()
    episode(env)
    observation, info = env.reset()
    assert info["frame"] == 3
    assert observation.max() == 3
    assert env.same_game
    assert episode(env) == (6, True, False)


def test_new_game_starts_anew(env):
    env = EpisodicLife(env, "new_game")
    env.reset()
    assert episode(env) == (3, True, False)
    assert env.reset()[1]["frame"] == 0
    assert not env.same_game
    assert episode(env) == (3, True, False)


def test_last_life(env):
    env = EpisodicLife(env, "continue", last_life=True)
    env.reset()
    ends = []
    for _ in range(4):
        ends.append(episode(env)[0])
        env.reset()
    assert ends == [3, 6, 9, 12]
    assert env.unwrapped.frame == 0


@pytest.mark.parametrize("arguments", [{"seed": 5}, {"options": {"new_game": True}}])
def test_a_new_game_can_be_requested(env, arguments):
    env = EpisodicLife(env)
    env.reset()
    episode(env)
    assert env.life_lost
    assert env.reset(**arguments)[1]["frame"] == 0
    assert not env.life_lost
    assert episode(env) == (3, True, False)


@pytest.mark.parametrize(
    ("script", "ended", "frame"),
    [
        ({"lives": lives, "limit": 3}, (3, True, True), 0),  # truncation ends the game, too
        ({"lives": lives, "ends": 4}, (3, True, False), 0),  # by the NOOP of the reset
        ({"lives": lambda t: {0: 2, 1: 3, 2: 3}.get(t, 2)}, (3, True, False), 4),  # an extra life is no loss
        ({"ends": 5}, (5, True, False), 0),  # without lives
    ],
)
def test_ends(scripted, script, ended, frame):
    env = EpisodicLife(scripted(**script))
    env.reset()
    env.step(2)
    assert env.reset()[1]["frame"] == 0, "in the middle of an episode, a new game begins"
    assert episode(env) == ended
    assert env.reset()[1]["frame"] == frame
    assert env.same_game == (frame > 0)


@pytest.mark.parametrize("reduced", [False, True], ids=["NOOP is an action", "NOOP is no action"])
def test_outside_of_a_frame_skip_the_noop_is_a_whole_one(game_env, reduced):
    inner, twin = game_env("breakout"), DqnPreprocessing(game_env("breakout"))
    if reduced:
        inner.driver.actions = inner.driver.actions[1:]
        inner.action_space = gymnasium.spaces.Discrete(3)
    env = EpisodicLife(DqnPreprocessing(inner))
    env.reset(seed=0)
    twin.reset(seed=0)
    terminated = False
    while not terminated:
        *_, terminated, _, info = env.step(2 - reduced)
        twin.step(2)
        if info["episode_frame_number"] < 8:
            env.step(1 - reduced)
            twin.step(1)
    observation, info = env.reset()
    expected, *_, expected_info = twin.step(0)
    np.testing.assert_array_equal(observation, expected)
    assert info == expected_info
    np.testing.assert_array_equal(env.step(2 - reduced)[0], twin.step(2)[0])
