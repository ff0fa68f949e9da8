"""`ObservationDelay` and the field `observation_delay`: the frames of which observations are made."""

from typing import Any

import numpy as np
import pytest
from env_tools import Observer
from tasks import nested

import atari
from atari import wrappers
from atari.env import AtariEnv
from atari.task import Task


class Frames(Observer):
    """The RAM and the screen after each frame since the last reset; the first are those that the reset shows."""

    def __init__(self, env: Any) -> None:
        core = env.unwrapped.core
        self.show = lambda *frame: (core.ram(), core.screen_grayscale())
        super().__init__(env, self.show)

    def begin(self) -> None:
        self.seen = [self.show()]

    def ram(self, t: int) -> Any:
        """The RAM after frame t; the first one is held."""
        return self.seen[max(t, 0)][0]

    def screen(self, t: int) -> Any:
        """The screen after frame t."""
        return self.seen[max(t, 0)][1]


KINDS = ("nested", "one object")


def made(task: Task, kind: str) -> Any:
    return nested(task) if kind == "nested" else atari.make(task)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("delay", [1, 2, 5, 9])
@pytest.mark.parametrize("frameskip", [1, 4, (2, 6)])
def test_observations_are_those_of_earlier_frames(kind: str, delay: int, frameskip: Any) -> None:
    """The maximum of two frames beside RAM."""
    fields: dict[str, Any] = {"obs_type": "dict", "maxpool": True, "frameskip": frameskip, "noops": (3, 9)}
    env = made(Task("ms_pacman", **fields, observation_delay=delay), kind)
    frames, generator = Frames(env), np.random.default_rng(0)
    for _ in range(2):
        seen, info = env.reset(seed=0)
        frames.begin()
        np.testing.assert_array_equal(seen["ram"], frames.ram(0))
        np.testing.assert_array_equal(seen["image"], frames.screen(0))
        for _ in range(30):
            before = len(frames.seen) - 1
            seen, _, _, _, info = env.step(int(generator.integers(9)))
            now = len(frames.seen) - 1
            np.testing.assert_array_equal(seen["ram"], frames.ram(now - delay))
            parts = [frames.screen(now - delay - back) for back in range(1 if now == before + 1 else 2)]
            np.testing.assert_array_equal(seen["image"], np.maximum.reduce(parts))
            assert info["lives"] == env.unwrapped.core.lives


@pytest.mark.parametrize("obs_type", ["rgb", "grayscale", "ram", "rgb_dict"])
def test_lanes_show_earlier_frames(obs_type: Any) -> None:
    """A vector of single frames equals one without a delay, some steps earlier."""
    options: dict[str, Any] = {"obs_type": obs_type, "frameskip": 1, "repeat_action_probability": 0.0}
    late, plain = (
        atari.AtariVectorEnv(Task("pong", **options, observation_delay=delay), 2, num_threads=1) for delay in (3, 0)
    )
    seen = [[envs.reset(seed=0)[0]] for envs in (late, plain)]
    for action in np.random.default_rng(0).integers(6, size=(40, 2)):
        for one, envs in zip(seen, (late, plain), strict=True):
            observation = envs.step(action)[0]
            one.append({k: v.copy() for k, v in observation.items()} if isinstance(observation, dict) else observation)
    for t, observation in enumerate(seen[0]):
        wanted: Any = seen[1][max(t - 3, 0)]
        for name in observation if isinstance(observation, dict) else [None]:
            one, other = (observation, wanted) if name is None else (observation[name], wanted[name])
            np.testing.assert_array_equal(one, other)


def test_results_are_not_delayed() -> None:
    late, plain = (atari.make(Task("breakout", observation_delay=delay)) for delay in (7, 0))
    late.reset(seed=0)
    plain.reset(seed=0)
    for action in np.random.default_rng(0).integers(4, size=300):
        one, other = late.step(int(action)), plain.step(int(action))
        assert one[1:4] == other[1:4]
        assert one[4]["frame_number"] == other[4]["frame_number"]
        if one[2]:
            break


def test_the_final_observation_of_a_lane_is_delayed() -> None:
    task = Task("pong", obs_type="dict", frameskip=1, max_num_frames_per_episode=20, observation_delay=5)
    envs: Any = atari.AtariVectorEnv(task, 1, autoreset_mode="SameStep", num_threads=1)
    envs.reset(seed=0)
    lane, rams = envs.lanes[0], []
    for _ in range(20):
        rams.append(lane.ram())
        info = envs.step(np.array([2]))[4]
    assert info["_final_obs"][0]
    np.testing.assert_array_equal(
        info["final_obs"]["ram"][0] if isinstance(info["final_obs"], dict) else info["final_obs"][0]["ram"], rams[15]
    )


@pytest.mark.parametrize("kind", KINDS)
def test_the_range_is_drawn_after_that_of_actions(kind: str) -> None:
    task = Task("pong", obs_type="ram", frameskip=1, noops=(0, 30), action_delay=(0, 60), observation_delay=(1, 60))
    env = made(task, kind)
    frames = Frames(env)
    seen, _ = env.reset(seed=3)
    noops = len(frames.seen)
    frames.begin()
    generator = np.random.Generator(np.random.PCG64(int(np.random.SeedSequence(3).generate_state(1)[0])))
    assert noops == generator.integers(0, 31)
    generator.integers(0, 61)
    delay = int(generator.integers(1, 61))
    for t in range(1, 80):
        seen = env.step(2)[0]
        np.testing.assert_array_equal(seen, frames.ram(t - delay))


@pytest.mark.parametrize("obs_type", ["dict", "ram", "rgb_dict"])
def test_frames_go_on_with_the_stack_after_a_lost_life(obs_type: Any) -> None:
    """The beginning after the lost life is not shown: its first observation is the last one's."""
    lives: dict[str, Any] = {"episodic_life": True, "on_reset": "noop", "seamless_lives": True}
    task = Task("breakout", **lives, obs_type=obs_type, fire="after_noops", noops=(5, 9), observation_delay=(7, 20))
    envs, seen = [made(task, kind) for kind in KINDS], []
    for env in envs:
        env.reset(seed=0)
        terminated = False
        while not terminated:
            last, _, terminated, _, _ = env.step(2)
        seen.append((last, env.reset()[0], env.step(2)[0]))
    for one, other in zip(*seen, strict=True):
        parts = (one, other) if isinstance(one, dict) else ({"": one}, {"": other})
        for name in parts[0]:
            np.testing.assert_array_equal(parts[0][name], parts[1][name])
    rams = [one["ram"] if isinstance(one, dict) else one for one in seen[0]]
    np.testing.assert_array_equal(rams[0], rams[1])
    assert (rams[1] != rams[2]).any()


def test_sound_is_delayed_by_the_wrapper() -> None:
    env: Any = wrappers.ObservationDelay(AtariEnv("pong", sound_obs=True, frameskip=1), 4)
    seen = [env.reset(seed=0)[0]]
    true = [seen[0]["sound"]]
    for action in np.random.default_rng(0).integers(6, size=200):
        seen.append(env.step(int(action))[0])
        true.append(env.unwrapped.core.audio())
    for t, observation in enumerate(seen):
        np.testing.assert_array_equal(observation["sound"], true[max(t - 4, 0)])
    assert len({one.tobytes() for one in true}) > 2


@pytest.mark.parametrize("core", ["native", "ale"])
def test_around_wrappers_of_single_frames(core: str) -> None:
    env: Any = AtariEnv("pong", obs_type="grayscale", frameskip=1, repeat_action_probability=0.0, core=core)
    env = wrappers.ObservationDelay(wrappers.FrameSkip(env, 2), 3)
    frames = Frames(env)
    env.reset(seed=0)
    frames.begin()
    for _ in range(10):
        seen = env.step(2)[0]
        now = len(frames.seen) - 1
        parts = [frames.screen(now - 3 - back) for back in (0, 1)]
        np.testing.assert_array_equal(seen, np.maximum(*parts))
    assert env.unwrapped.driver.delayed is None


def test_a_snapshot_of_the_wrapper_has_the_frames_that_have_not_arrived() -> None:
    env: Any = wrappers.ObservationDelay(AtariEnv("pong", obs_type="ram"), 3)
    env.reset(seed=0)
    for action in (2, 3, 2):
        env.step(action)
    saved = env.snapshot()
    seen = [env.step(3)[0] for _ in range(5)]
    env.reset(seed=1)
    env.restore(saved)
    for before in seen:
        np.testing.assert_array_equal(env.step(3)[0], before)
