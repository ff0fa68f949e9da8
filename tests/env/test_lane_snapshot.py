"""Snapshots travel: from a lane of a vector into the single environment of its task, and back."""

import pickle
import re
from typing import Any

import numpy as np
import pytest

import atari
from atari.env.lane_snapshot import LaneSnapshot

CASES: dict[str, dict[str, Any]] = {
    "dqn2015": {"preset": "dqn2015"},
    "sticky, drawn skips": {"preset": "gymnasium", "repeat_action_probability": 0.25, "frameskip": (2, 5)},
    "lives": {"preset": "baselines", "episodic_life": True},
    "seamless lives": {"preset": "envpool", "episodic_life": True},
    "ale-py's seeding": {"preset": "ale_vector"},
    "RAM": {"preset": "dqn2015", "obs_type": "ram", "stack_num": 3},
    "dict": {"preset": "dqn2015", "obs_type": "dict"},
    "delays": {"preset": "dqn2015", "action_delay": (1, 4), "observation_delay": 2},
    "reward": {"preset": "dqn2015", "reward": "reward - 5 * lives_lost"},
    "interventions": {"preset": "dqn2015", "interventions": ["infinite_lives"]},
    "limit": {"preset": "dqn2015", "max_episode_steps": 150},
}
ALONE: dict[str, dict[str, Any]] = {
    "an ID": {},
    "gray, drawn skips": {"obs_type": "grayscale", "frameskip": (2, 5)},
    "RAM, another mode": {"obs_type": "ram", "mode": 4, "difficulty": 1},
}


def pair(**options: Any) -> tuple[atari.AtariVectorEnv, Any]:
    """A vector of two lanes and the single environment of its task."""
    task = atari.Task.of("ALE/Breakout-v5", **options)
    return atari.AtariVectorEnv(task, 2, autoreset_mode="Disabled"), atari.make(task)


def play_some(envs: atari.AtariVectorEnv) -> None:
    """Play some steps, with the resets that follow an end."""
    envs.reset(seed=5)
    for action in np.random.default_rng(1).integers(4, size=(90, 2)):
        *_, terminated, truncated, _ = envs.step(action)
        envs.reset(options={"reset_mask": terminated | truncated})


def assert_same_result(of_lane: Any, single: Any, lane: int = 1) -> None:
    observation, reward, terminated, truncated, info = of_lane
    if isinstance(single[0], dict):
        assert all(np.array_equal(observation[name][lane], single[0][name]) for name in single[0])
    else:
        assert np.array_equal(np.squeeze(observation[lane]), np.squeeze(single[0]))
    assert (reward[lane], terminated[lane], truncated[lane]) == single[1:4]
    for name in single[4].keys() & info.keys() - {"episode"}:
        assert info[name][lane] == single[4][name], name
    if "episode" in single[4]:
        assert info["_episode"][lane]
        assert (info["episode"]["r"][lane], info["episode"]["l"][lane]) == (
            single[4]["episode"]["r"],
            single[4]["episode"]["l"],
        )


def assert_play_alike(envs: atari.AtariVectorEnv, env: Any, steps: int, resets: bool = True) -> int:
    """Play lane 1 and the single environment by equal actions; returns the number of episodes that ended."""
    rng, ends = np.random.default_rng(steps), 0
    for action in rng.integers(4, size=steps).tolist():
        result, single = envs.step([0, action]), env.step(action)
        assert_same_result(result, single)
        if single[2] or single[3]:
            if not resets:
                break
            ends += 1
            mask = np.array([False, True])
            observation, info = envs.reset(options={"reset_mask": mask})
            first = env.reset()
            nothing = np.zeros(2), np.zeros(2, bool), np.zeros(2, bool)
            assert_same_result((observation, *nothing, info), (first[0], 0.0, False, False, first[1]))
    return ends


@pytest.mark.parametrize("case", CASES)
def test_a_lane_continues_in_a_single_environment_and_back(case: str) -> None:
    options = CASES[case]
    envs, env = pair(**options)
    play_some(envs)
    (snapshot,) = envs.snapshot([1])
    env.restore(pickle.loads(pickle.dumps(snapshot)))
    ends = assert_play_alike(envs, env, 260)
    assert ends or case == "interventions"
    back = env.snapshot()
    other, _ = pair(**options)
    other.reset(seed=9)
    other.restore([1], [back])
    assert other.lanes[1].ram().tolist() == envs.lanes[1].ram().tolist()
    assert other.snapshot([1])[0].state.__getstate__() == envs.snapshot([1])[0].state.__getstate__()
    assert_play_alike(other, env, 200)


@pytest.mark.parametrize("case", ALONE)
def test_environments_without_wrappers(case: str) -> None:
    envs, env = pair(**ALONE[case])
    play_some(envs)
    env.reset(seed=0)
    env.unwrapped.restore(envs.snapshot([1])[0])
    assert_play_alike(envs, env, 200)
    other, _ = pair(**ALONE[case])
    other.reset(seed=9)
    other.restore([1], [env.unwrapped.snapshot()])
    assert np.array_equal(np.squeeze(other.observe()[0][1]), np.squeeze(envs.observe()[0][1]))
    assert_play_alike(other, env, 200)


@pytest.mark.parametrize("options", [{"preset": "baselines", "episodic_life": True}, {}])
def test_an_ended_episode_stays_ended(options: dict[str, Any]) -> None:
    envs, env = pair(**options, max_num_frames_per_episode=200)
    other, single = pair(**options, max_num_frames_per_episode=200)
    for seed, made in enumerate((envs, env, other, single), 5):
        made.reset(seed=seed)
    assert_play_alike(envs, env, 300, resets=False)
    assert envs.lanes[1].ended
    outer = single if options else single.unwrapped
    outer.restore(envs.snapshot([1])[0])
    other.restore([1], [outer.snapshot()])
    assert other.lanes[1].ended
    before, after = (vector.observe() for vector in (envs, other))
    assert np.array_equal(before[0][1], after[0][1])
    assert before[1]["frame_number"][1] == after[1]["frame_number"][1] == single.unwrapped.core.frame_number


@pytest.mark.parametrize("options", [{"preset": "dqn2015"}, {}])
def test_packed_snapshots_are_those_of_single_environments(options: dict[str, Any]) -> None:
    envs, env = pair(**options)
    play_some(envs)
    before = envs.ram()
    packed, plain = envs.snapshot(packed=True), envs.snapshot()
    single = env if options else env.unwrapped
    for data, snapshot in zip(packed, plain, strict=True):
        single.restore(snapshot)
        assert single.snapshot() == data
        assert len(data) < 12_000
    envs.step([2, 3])
    envs.restore([1, 0], [packed[1], packed[0]])
    assert np.array_equal(envs.ram(), before)
    if options:
        for one, other in zip(envs.snapshot(), plain, strict=True):
            assert one.state.__getstate__() == other.state.__getstate__()


def test_lists_may_mix_lanes_and_single_environments() -> None:
    envs, env = pair(preset="dqn2015")
    envs.reset(seed=0)
    env.reset(seed=3)
    envs.restore([0, 1], [env.snapshot(), envs.snapshot([0])[0]])
    frames = [lane.frame_number for lane in envs.lanes]
    assert frames[0] == env.unwrapped.core.frame_number != frames[1]
    assert np.array_equal(envs.observe()[0][0], env.reset(seed=3)[0])


def refused(call: Any, *parts: str) -> None:
    with pytest.raises(ValueError, match=".*".join(map(re.escape, parts))):
        call()


def test_other_tasks_cores_and_wrappers_are_refused() -> None:
    envs, env = pair(preset="dqn2015")
    envs.reset(seed=0)
    env.reset(seed=0)
    snapshot, saved = envs.snapshot()[0], env.snapshot()
    task = envs.task
    refused(lambda: atari.make("breakout", preset="baselines").restore(snapshot), "fire = 'never'")
    refused(lambda: atari.make("pong", preset="dqn2015").restore(snapshot), "game = 'breakout'")
    refused(lambda: env.unwrapped.restore(snapshot), "restore of the outermost wrapper")
    refused(lambda: atari.make(task, core="ale").restore(snapshot), "core='native'")
    refused(lambda: atari.wrappers.ClipReward(atari.wrappers.FrameStack(env, 2)).restore(snapshot), "FrameStack")
    refused(lambda: envs.restore([0], [env.unwrapped.snapshot()]), "environment 0 cannot", "without its wrappers")
    refused(lambda: envs.restore([0], [b"no snapshot"]), "environment 0 cannot", "not a snapshot")
    other = atari.AtariVectorEnv("breakout", 1, preset="baselines")
    other.reset(seed=0)
    refused(lambda: other.restore([0], [saved]), "environment 0 cannot", "fire")
    damaged = LaneSnapshot(snapshot.state.__class__.of_bytes(env.unwrapped.core, b"\0" * 99), snapshot.task)
    refused(lambda: env.restore(damaged), "damaged")
    assert env.snapshot() == saved
    atari.make(task, core="plain").restore(snapshot)
