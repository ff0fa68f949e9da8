"""`Poke` writes bytes once: at a frame, at a condition, or at the next frame."""

from functools import partial

import numpy as np
import pytest
from env_tools import started

import atari
from atari.lab import Poke

UNUSED, BALL_X, SCORE = 100, 49, 14


playing = partial(started, "pong", frameskip=1)


def ram_after(env: atari.AtariEnv, frames: int, index: int) -> list[int]:
    values = []
    for _ in range(frames):
        env.step(0)
        values.append(int(env.core.ram()[index]))
    return values


def test_without_a_condition_it_is_the_next_frame() -> None:
    env, twin = playing(), playing()
    Poke(env, {BALL_X: 200})
    assert env.core.ram()[BALL_X] == twin.core.ram()[BALL_X]
    assert ram_after(env, 1, BALL_X) == [200]
    twin.step(0)
    twin.core.set_ram(BALL_X, 200)  # from here on all is equal
    assert ram_after(env, 30, BALL_X) == ram_after(twin, 30, BALL_X)


@pytest.mark.parametrize("core", ["native", "plain"])
def test_a_frame_of_the_episode(core: str) -> None:
    env, twin = playing(core=core), playing(core=core)
    Poke(env, {BALL_X: 7}, frame=5)
    assert ram_after(env, 4, BALL_X) == ram_after(twin, 4, BALL_X)
    assert ram_after(env, 1, BALL_X) == [7] != ram_after(twin, 1, BALL_X)
    env.reset()
    twin.reset()
    assert ram_after(env, 10, BALL_X) == ram_after(twin, 10, BALL_X)  # once, not in each episode


def test_a_condition() -> None:
    env = playing(repeat_action_probability=0.0)
    Poke(env, {"ball_x": 10}, when="ball_x > 100")
    values = [value - 49 for value in ram_after(env, 300, BALL_X)]
    first = values.index(10)
    assert max(values[:first]) <= 100
    assert max(values[first:]) > 100  # afterwards the ball passes again


def test_within_a_frame_skip() -> None:
    env = atari.AtariEnv("pong", frameskip=4)
    env.reset(seed=0)
    Poke(env, {SCORE: 3}, frame=2)
    assert env.step(0)[1] == 3.0


def test_a_poke_of_the_score_pays_unless_it_is_not_paid() -> None:
    for paid, reward in ((True, 5.0), (False, 0.0)):
        env = playing()
        Poke(env, {"score_player": 5}, paid=paid)
        assert [env.step(0)[1] for _ in range(3)] == [reward, 0.0, 0.0]
        assert env.core.ram()[SCORE] == 5


def test_a_poke_can_end_a_game_without_pay() -> None:
    env = playing()
    Poke(env, {"score_enemy": 21}, paid=False)
    _, reward, terminated, _, _ = env.step(0)
    assert (reward, terminated) == (0.0, True)


def test_release_before_it_is_done() -> None:
    env, twin = playing(), playing()
    poke = Poke(env, {BALL_X: 7}, frame=5)
    poke.release()
    assert ram_after(env, 10, BALL_X) == ram_after(twin, 10, BALL_X)


def test_a_snapshot_says_whether_it_is_done() -> None:
    env = playing()
    Poke(env, {BALL_X: 200}, frame=3)
    before = env.snapshot()
    state = env.clone_state()
    played = ram_after(env, 6, BALL_X)
    after = env.snapshot()
    for restore in (lambda: env.restore(before), lambda: env.restore_state(state)):
        restore()
        assert ram_after(env, 6, BALL_X) == played
    env.restore(after)
    env.core.set_ram(BALL_X, 60)
    assert 200 not in ram_after(env, 1, BALL_X)


def test_lanes_of_a_vector() -> None:
    envs = atari.AtariVectorEnv("pong", 2, reward_clipping=False, noop_max=1, use_fire_reset=False)
    envs.reset(seed=0)
    Poke(envs, {"score_player": np.array([2, 5])}, frame=9)
    rewards = [envs.step(np.zeros(2, int))[1].tolist() for _ in range(4)]
    assert rewards == [[0, 0], [0, 0], [2, 5], [0, 0]]
