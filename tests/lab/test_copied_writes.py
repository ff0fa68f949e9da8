"""Copies of environments and vectors by `pickle` and `copy.deepcopy` keep the writes of `Freeze` and `Poke`."""

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from env_tools import playing

import atari
from atari.lab import Freeze, Poke

RIGHT, BALL_X, PLAYER_Y = 2, 49, 51

Copier = Callable[[Any], Any]
COPIERS = pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda value: pickle.loads(pickle.dumps(value))])


def vector(**options: Any) -> atari.AtariVectorEnv:
    envs = atari.AtariVectorEnv("pong", 3, **options)
    envs.reset(seed=0)
    for _ in range(30):
        envs.step(np.full(3, RIGHT))
    return envs


def plays_alike(first: atari.AtariVectorEnv, second: atari.AtariVectorEnv, steps: int = 40) -> bool:
    actions = np.random.default_rng(0).integers(0, 6, (steps, 3))
    for row in actions:
        first.step(row)
        second.step(row)
        if not (first.ram() == second.ram()).all():
            return False
    return True


@COPIERS
@pytest.mark.parametrize("core", ["native", "plain"])
def test_a_copy_of_an_environment_is_frozen(duplicate: Copier, core: str) -> None:
    env = playing(core=core, interventions=["lazy_enemy"])
    with Freeze(env, {BALL_X: 120}):
        twin = duplicate(env)
        assert len(twin.core.writes) == len(env.core.writes)
    for _ in range(5):
        twin.step(RIGHT)
        assert twin.core.ram()[BALL_X] == 120
    twin.reset()
    assert twin.core.ram()[BALL_X] == 120
    env.step(RIGHT)
    assert env.core.ram()[BALL_X] != 120


@COPIERS
def test_a_copy_of_a_vector_is_frozen(duplicate: Copier) -> None:
    envs = vector(interventions=["lazy_enemy"])
    Freeze(envs, {BALL_X: np.array([100, 110, 120])})
    Freeze(envs, {PLAYER_Y: "old"}, index=1, paid=False)
    twin = duplicate(envs)
    assert plays_alike(envs, twin)
    assert twin.ram()[:, BALL_X].tolist() == [100, 110, 120]
    again = duplicate(twin)
    twin.close()
    twin.reset()
    assert twin.ram()[:, BALL_X].tolist() == again.ram()[:, BALL_X].tolist() == [100, 110, 120]


@COPIERS
@pytest.mark.parametrize("released", [False, True])
def test_a_poke_that_is_done_stays_done(duplicate: Copier, released: bool) -> None:
    envs = vector()
    first = Freeze(envs, {PLAYER_Y: 66}, index=0)
    done, waits = Poke(envs, {BALL_X: 120}, index=0), Poke(envs, {BALL_X: 90}, when="ball_x < 70", index=0)
    if released:
        first.release()  # its slot is free, that of the others stays
    envs.step(np.full(3, RIGHT))
    twin = duplicate(envs)
    assert plays_alike(envs, twin, 200)
    open_one = duplicate(envs)
    envs.close()
    for each in (envs, open_one):
        each.reset()
    assert plays_alike(envs, open_one)
    assert done is not waits


@COPIERS
def test_a_poke_of_an_environment_stays_done(duplicate: Copier) -> None:
    env = playing()
    Poke(env, {BALL_X: 120})
    env.step(RIGHT)
    twin = duplicate(env)
    for each in [env, twin] * 4:
        each.step(RIGHT)
    assert twin.core.ram()[BALL_X] == env.core.ram()[BALL_X] != 120


@COPIERS
def test_a_copy_of_both_releases_the_copy(duplicate: Copier) -> None:
    env = playing()
    other = Freeze(env, {PLAYER_Y: 60})
    freeze = Freeze(env, {BALL_X: 120})
    other.release()
    twin, held = duplicate((env, freeze))
    held.release()
    for each in (env, twin):
        each.step(RIGHT)
    assert env.core.ram()[BALL_X] == 120
    assert twin.core.ram()[BALL_X] != 120


@COPIERS
def test_a_copy_of_a_vector_and_its_freeze(duplicate: Copier) -> None:
    envs = vector(interventions=["lazy_enemy"])
    kept = Freeze(envs, {PLAYER_Y: 60})
    freeze = Freeze(envs, {BALL_X: 120}, index=1)
    twin, held = duplicate((envs, freeze))
    held.release()
    for each in (envs, twin):
        each.lanes[1].set_ram(BALL_X, 60)
        each.step(np.full(3, RIGHT))
    assert envs.ram()[1, BALL_X] == 120
    assert twin.ram()[1, BALL_X] != 120
    assert twin.ram()[:, PLAYER_Y].tolist() == [60, 60, 60]
    assert kept is not None


def test_a_wrapper_that_has_a_freeze_is_copied() -> None:
    env = playing()
    freeze = Freeze(env, {BALL_X: 120})
    freeze.release()
    held: list[Any] = copy.deepcopy([freeze, env])
    held[0].release()
    held[1].step(RIGHT)
    assert held[1].core.ram()[BALL_X] != 120


def test_a_setting_of_ale_keeps_the_writes() -> None:
    env = playing()
    Freeze(env, {BALL_X: 120})
    poke = Poke(env, {PLAYER_Y: 66})
    env.step(RIGHT)
    env.ale.setFloat("repeat_action_probability", 0.0)
    env.reset(seed=3)
    env.step(RIGHT)
    plain = atari.AtariEnv("pong", repeat_action_probability=0.0)
    Freeze(plain, {BALL_X: 120})
    plain.reset(seed=3)
    plain.step(RIGHT)
    assert env.core.ram()[BALL_X] == 120
    assert env.core.ram().tolist() == plain.core.ram().tolist()
    assert poke is not None
