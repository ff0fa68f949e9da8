"""`Watch`: the logged values of environments and vectors, and the reported changes."""

import copy
from typing import Any

import gymnasium
import numpy as np
import pytest
from env_tools import needs_gymnasium_1
from gymnasium.vector import SyncVectorEnv

import atari
from atari.lab import Ram, Watch
from atari.lab.watch import VectorWatch


def make(**options: Any) -> atari.AtariEnv:
    return atari.AtariEnv("breakout", obs_type="ram", **options)


def test_each_step_is_logged() -> None:
    env = Watch(make(), "lives", 99, 0xB9)
    rows = [env.reset(seed=0)[0]]
    rows += [env.step(action)[0] for action in [1, 2, 3] * 20]
    ram = np.stack(rows)
    history = env.history
    assert history["lives"].dtype == np.int32
    assert np.array_equal(history[99], ram[:, 99])
    assert np.array_equal(history[0xB9], ram[:, 57])
    assert np.array_equal(np.diff(history["frame"][1:]), np.full(59, 4))
    env.clear()
    assert env.history["frame"].shape == (0,)


def test_each_emulated_frame_is_logged() -> None:
    env = Watch(make(frameskip=3), 99, each="frame")
    single = make(frameskip=1, repeat_action_probability=0.25)
    env.reset(seed=0)
    expected = [single.reset(seed=0)[0][99]]
    for action in [1, 2, 3] * 10:
        env.step(action)
        expected += [single.step(action)[0][99] for _ in range(3)]
    assert env.history[99].tolist() == expected
    env.stop()
    env.step(0)
    assert len(env.history[99]) == len(expected)
    assert not env.unwrapped.driver.observers


def test_changes_are_reported() -> None:
    seen: list[tuple[Any, ...]] = []
    env = Watch(make(), "lives", on_change=lambda *change: seen.append(change))
    env.reset(seed=0)
    before = Ram(env)["lives"]
    for _ in range(3):
        env.step(1)
    env.unwrapped.core.set_ram(57, 3)
    env.step(1)
    env.step(1)
    assert seen == [("lives", before, Ram(env)["lives"])]


def test_an_invisible_label_is_masked() -> None:
    name, label = next((name, label) for name, label in atari.games["breakout"].ram_labels.items() if label.visible)
    env = Watch(make(), name)
    env.reset(seed=0)
    for action in [1] * 110:
        env.step(action)
    assert np.ma.isMaskedArray(env.history[name])
    assert 0 < env.history[name].mask.sum() < 111, label


def error_of(env: Watch) -> str:
    try:
        env.step(1)
    except RuntimeError as error:
        return str(error)
    return ""


def test_an_error_of_the_callback_comes_after_the_step() -> None:
    def fail(*change: Any) -> None:
        raise RuntimeError("stop here")

    env = Watch(make(), 99, each="frame", on_change=fail)
    env.reset(seed=0)
    errors = [error_of(env) for _ in range(50)]
    assert "stop here" in errors
    assert len(env.history["frame"]) == 1 + 50 * 4  # the reset, and all frames of the steps


def test_vectors() -> None:
    seen: list[Any] = []
    envs = Watch(vector(3), "lives", 99, on_change=lambda *change: seen.append(change))
    assert type(envs) is VectorWatch
    rows = [envs.reset(seed=0)[0]] + [envs.step(np.full(3, action))[0] for action in [1, 2, 3] * 10]
    assert np.array_equal(envs.history[99], np.stack(rows)[..., 99])
    assert envs.history["lives"].shape == envs.history["frame"].shape == (31, 3)
    assert {name for name, _, _ in seen} >= {99}
    one = Watch(envs, 99, index=1)
    one.step(np.zeros(3, np.int64))
    assert one.history[99].shape == one.history["frame"].shape == (1,)
    assert one.history[99][0] == envs.history[99][-1, 1]
    envs.stop()
    envs.step(np.zeros(3, np.int64))
    assert len(envs.history["frame"]) == 32
    envs.close()


def test_a_watch_keeps_the_snapshots_of_the_stack() -> None:
    env = Watch(make(), 99)
    env.reset(seed=0)
    data = env.snapshot()
    first = env.step(1)[0]
    env.restore(data)
    assert np.array_equal(env.step(1)[0], first)


@pytest.mark.parametrize(
    ("what", "options", "error", "text"),
    [
        ((), {}, ValueError, "at least one"),
        (("balls_x",), {}, KeyError, "ball_x"),
        ((256,), {}, ValueError, "0..127"),
        (("lives",), {"each": "second"}, ValueError, "'step', 'frame'"),
    ],
)
def test_wrong_arguments(what: Any, options: Any, error: type[Exception], text: str) -> None:
    env = make()
    with pytest.raises(error, match=text):
        Watch(env, *what, **options)
    assert not env.driver.observers


def vector(lanes: int = 1) -> atari.AtariVectorEnv:
    return atari.AtariVectorEnv("breakout", lanes, obs_type="ram")


@needs_gymnasium_1
@pytest.mark.parametrize(
    ("make_env", "options", "error", "text"),
    [
        (lambda: gymnasium.make("CartPole-v1").unwrapped, {}, TypeError, "an AtariVectorEnv, got <CartPole"),
        (lambda: SyncVectorEnv([make]), {}, TypeError, "in another vector, wrap each environment"),
        (vector, {"each": "frame"}, ValueError, "a vector is logged by steps, each='step', got each='frame'"),
        (vector, {"index": 1}, IndexError, "the vector has 1 lanes"),
        (make, {"index": 0}, TypeError, "leave it out"),
    ],
)
def test_an_environment_of_the_other_kind(make_env: Any, options: Any, error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        Watch(make_env(), 1, **options)


def test_a_copied_watch_continues() -> None:
    env = Watch(make(), 99)
    env.reset(seed=0)
    other = copy.deepcopy(env)
    env.step(1)
    other.step(1)
    assert other.history[99].tolist() == env.history[99].tolist()
