"""`ActionDelay` and the field `action_delay`: what the console gets in each frame."""

from typing import Any

import numpy as np
import pytest
from env_tools import Observer
from tasks import nested

import atari
from atari import wrappers
from atari.env import AtariEnv
from atari.task import Task

LEFT, RIGHT, NOOP, FIRE = 4, 3, 0, 1  # ALE numbers


def console(env: Any) -> Observer:
    """Keeps the ALE actions that the console gets."""
    return Observer(env, lambda action, reward: action)


def made(task: Task, kind: str) -> tuple[Any, Observer]:
    env = nested(task) if kind == "nested" else atari.make(task)
    return env, console(env)


BREAKOUT: dict[str, Any] = {"game": "breakout", "repeat_action_probability": 0.0}


@pytest.mark.parametrize("kind", ["nested", "one object"])
class TestFrames:
    def test_a_delay_counts_frames_inside_a_skip(self, kind: str) -> None:
        env, console = made(Task(**BREAKOUT, action_delay=2), kind)
        env.reset(seed=0)
        assert console.take() == []
        for index, wanted in ((2, [NOOP, NOOP, 3, 3]), (3, [3, 3, 4, 4]), (0, [4, 4, 0, 0])):
            env.step(index)
            assert console.take() == wanted

    def test_a_delay_may_be_longer_than_a_step(self, kind: str) -> None:
        env, console = made(Task(**BREAKOUT, action_delay=9, frameskip=4), kind)
        env.reset(seed=0)
        for index in (2, 3, 2, 3):
            env.step(index)
        assert console.take() == [NOOP] * 9 + [RIGHT] * 4 + [LEFT] * 3

    def test_the_beginning_is_not_delayed(self, kind: str) -> None:
        options: dict[str, Any] = {"fire": "after_noops", "fire_unit": "skip", "third_action": True, "noops": (2, 2)}
        env, console = made(Task(**BREAKOUT, **options, action_delay=3), kind)
        env.reset(seed=0)
        assert console.take() == [NOOP] * 2 + [FIRE] * 4 + [RIGHT] * 4
        env.step(3)
        assert console.take() == [NOOP] * 3 + [LEFT]

    def test_a_reset_drops_the_actions_on_their_way(self, kind: str) -> None:
        env, console = made(Task(**BREAKOUT, action_delay=4), kind)
        for _ in range(2):
            env.reset(seed=0)
            console.take()
            env.step(2)
            assert console.take() == [NOOP] * 4

    @pytest.mark.parametrize(("seamless", "goes_on"), [(False, False), (True, True)])
    def test_a_lost_life_keeps_the_line_with_the_stack(self, kind: str, seamless: bool, goes_on: bool) -> None:
        lives: dict[str, Any] = {"episodic_life": True, "on_reset": "continue", "seamless_lives": seamless}
        task = Task(**BREAKOUT, **lives, fire="after_noops", stack_num=4, action_delay=(20, 30))
        env, console = made(task, kind)
        env.reset(seed=0)
        terminated = False
        while not terminated:
            terminated = env.step(2)[2]
        console.take()
        env.reset()
        assert console.take() == [FIRE]
        for _ in range(8):
            env.step(3)
        assert (console.take()[:20] == [RIGHT] * 20) is goes_on

    def test_a_new_game_that_loses_a_life_in_its_noops_begins_a_new_line(self, kind: str) -> None:
        """The reset goes on after that life with the same game, which it has begun."""
        lives: dict[str, Any] = {"episodic_life": True, "on_reset": "continue", "seamless_lives": True}
        options: dict[str, Any] = {**BREAKOUT, "game": "ms_pacman", "noops": (1000, 1000), "action_delay": 20}
        env, console = made(Task(**options, **lives), kind)
        env.reset(seed=0)
        for _ in range(10):
            env.step(3)
        assert env.reset()[1]["lives"] < 3
        console.take()
        for _ in range(10):
            env.step(4)
        assert console.take() == [NOOP] * 20 + [env.unwrapped.task.action_set[4]] * 20

    def test_a_number_alone_draws_nothing(self, kind: str) -> None:
        starts = []
        for delay in (0, 5, (5, 5), (5, 6)):
            env, _ = made(Task(**BREAKOUT, noops=(0, 30), frameskip=(2, 9), action_delay=delay), kind)
            env.reset(seed=3)
            env.reset()
            starts.append(env.step(0)[4]["frame_number"])
        assert starts[0] == starts[1] == starts[2] != starts[3]

    def test_a_range_is_drawn_after_the_noops(self, kind: str) -> None:
        env, console = made(Task(**BREAKOUT, noops=(0, 30), action_delay=(1, 60)), kind)
        env.reset(seed=3)
        generator = np.random.Generator(np.random.PCG64(int(np.random.SeedSequence(3).generate_state(1)[0])))
        assert len(console.take()) == generator.integers(0, 31)
        delay = int(generator.integers(1, 61))
        for _ in range(20):
            env.step(2)
        assert console.take() == [NOOP] * delay + [RIGHT] * (80 - delay)

    def test_continuous_actions_begin_with_the_stick_at_rest(self, kind: str) -> None:
        env, console = made(Task(**BREAKOUT, continuous=True, action_delay=5), kind)
        env.reset(seed=0)
        env.step(np.array([1, 0, 0], np.float32))
        env.step(np.array([0, 0, 1], np.float32))
        assert console.take() == [NOOP] * 5 + [RIGHT] * 3


def test_lanes_and_their_videos_get_the_delayed_actions(tmp_path: Any) -> None:
    envs: Any = atari.AtariVectorEnv(Task(**BREAKOUT, action_delay=3), 2)
    lane = envs.lanes[1]
    filmed: Any = atari.recording.RecordVideo(envs, tmp_path, episode_trigger=lambda _: True, format="gif")
    filmed.reset(seed=0)
    shadow = filmed._shadows[1]
    shadow.synchronize()
    played = []
    for index in (2, 3):
        shadow.synchronize()
        lane.record_moves()
        info = envs.step(np.array([0, index]))[4]
        played += [action for action, _ in shadow.moves(info)]
    assert played == [NOOP] * 3 + [RIGHT] * 4 + [LEFT]
    for _ in range(20):
        filmed.step(np.array([2, 3]))
        assert (shadow.core.ram() == lane.ram()).all()
    filmed.close()


@pytest.mark.parametrize("core", ["native", "ale"])
def test_around_an_environment_with_a_skip_of_its_own(core: str) -> None:
    env = wrappers.ActionDelay(AtariEnv("breakout", frameskip=4, repeat_action_probability=0.0, core=core), 2)
    played = console(env)
    env.reset(seed=0)
    env.step(2)
    env.step(3)
    assert played.take() == [NOOP, NOOP, RIGHT, RIGHT, RIGHT, RIGHT, LEFT, LEFT]
    assert env.unwrapped.driver.convert is None  # type: ignore[attr-defined]


def test_an_action_that_does_not_exist_is_refused_when_it_is_given() -> None:
    env = atari.make("pong", action_delay=3)
    env.reset(seed=0)
    with pytest.raises(ValueError, match="6"):
        env.step(6)
    nest = nested(Task("pong", action_delay=3))
    nest.reset(seed=0)
    with pytest.raises(ValueError, match="6"):
        nest.step(6)
    assert nest.unwrapped.driver.convert is None


def test_equal_delays_are_equal_tasks() -> None:
    assert Task("pong", action_delay=(5, 5)) == Task("pong", action_delay=5)
    task = Task.from_json(Task("pong", action_delay=(2, 5)).to_json())
    assert task.action_delay == (2, 5)
    assert "they arrive (2, 5) frames later" in str(task)
