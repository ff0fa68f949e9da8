"""`Driver`: frames without observations, for wrappers."""

from functools import partial

import gymnasium
import numpy as np
import pytest
from env_tools import needs_gymnasium_1, started

from atari import Action, AtariEnv
from atari.cores.ale_random import AleRandom

made = partial(started, frameskip=1, repeat_action_probability=0.0)


def test_frames_before_a_reset_are_refused() -> None:
    driver = AtariEnv("pong").driver
    assert driver.phase == "new"
    with pytest.raises(gymnasium.error.ResetNeeded):
        driver.play_frames(0, frames=1)


def test_play_frames_is_that_many_steps() -> None:
    driven, stepped = made(), made()
    assert driven.driver.play_frames(Action.FIRE, frames=3) == sum(stepped.step(1)[1] for _ in range(3))
    assert (driven.observe() == stepped.observe()).all()
    assert driven.driver.info() == {
        "lives": 5,
        "episode_frame_number": stepped.core.episode_frame_number,
        "frame_number": stepped.core.frame_number,
    }


@pytest.mark.parametrize(("core", "frames"), [("native", 500), ("plain", 500), ("ale", 1)])
def test_play_until_ends_with_a_lost_life(core: str, frames: int) -> None:
    driver = made(core=core).driver
    driver.play_frames(Action.FIRE, frames=4)
    played = 0
    while driver.core.lives == 5:
        _, more = driver.play_until(Action.NOOP, frames=500)
        assert more <= frames
        played += more
    assert driver.core.lives == 4
    assert played == driver.info()["episode_frame_number"] - made().core.episode_frame_number - 4


def test_actions_are_those_of_the_action_space() -> None:
    env = made()
    assert [env.driver.ale_action(index)[0] for index in range(4)] == list(env.driver.actions)
    with pytest.raises(ValueError, match="breakout"):
        env.driver.ale_action(4)
    env.driver.replacement = Action.UP
    assert env.driver.ale_action(99) == (Action.UP, 1.0)


def test_a_continuous_action_has_a_strength() -> None:
    driver = made(continuous=True).driver
    action, strength = driver.ale_action(np.array([0.75, 0.0, 1.0], np.float32))
    assert (action, strength) == (Action.RIGHTFIRE, 0.75)
    with pytest.raises(TypeError, match="three floats"):
        driver.ale_action(2)


@needs_gymnasium_1
def test_the_generator_draws_for_the_environment() -> None:
    env = made()
    env.np_random = np.random.default_rng(5)
    assert env.driver.draw(0, 1000) == np.random.default_rng(5).integers(0, 1000)
    assert env.np_random_seed == -1
    env.driver.ale_random = generator = AleRandom()
    generator.seed(3)
    twin = AleRandom()
    twin.seed(3)
    assert env.driver.draw(10, 20) == 10 + twin.below(10)


def test_played_counts_the_game() -> None:
    driver = made("pong").driver
    while driver.phase == "playing":
        driver.play_frames(Action.NOOP, frames=60)
    assert driver.ended is not None
    assert driver.ended["r"] == driver.played.score == -21.0
    driver.reset()
    assert (driver.phase, driver.played.score) == ("playing", 0.0)


@pytest.mark.parametrize("core", ["native", "ale"])
def test_a_function_may_convert_the_action_of_each_frame(core: str) -> None:
    converting, plain = made("pong", core=core), made("pong", core=core)
    given = []

    def convert(action: int, strength: float) -> tuple[int, float]:
        given.append((action, strength))
        return (Action.UP if len(given) % 2 else Action.DOWN), 1.0

    converting.driver.convert = convert
    assert not converting.driver.plays_several
    converting.step(0)
    converting.driver.play_frames(Action.FIRE, frames=2)
    assert converting.driver.play_until(Action.NOOP, frames=5) == (0.0, 1)
    assert given == [(0, 1.0), (1, 1.0), (1, 1.0), (0, 1.0)]
    for action in (Action.UP, Action.DOWN, Action.UP, Action.DOWN):
        plain.driver.play_frames(action, frames=1)
    assert (converting.core.ram() == plain.core.ram()).all()
    converting.driver.convert = None
    assert converting.driver.plays_several


@pytest.mark.parametrize("obs_type", ["rgb", "grayscale", "ram"])
def test_observations_may_be_made_of_another_object(obs_type: str) -> None:
    env, other = made("pong", obs_type=obs_type), made("pong", obs_type=obs_type)
    env.driver.delayed = other.core
    before = env.observe()
    for action in (2, 2, 3):
        seen = env.step(action)[0]
        assert (seen == before).all()
    assert (env.core.ram() != other.core.ram()).any()
