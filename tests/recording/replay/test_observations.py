"""`Replay.observations`: the observations of the recorded environment to the bit, and those of an agent that watches."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from field_values import CASES

import atari
from atari.recording import RecordReplay, Replay
from atari.task import Task

STEPS = 150
DRAWN = {"observation_delay"}  # the replay does not have the number
ENDS_IN_A_RESET = {"fire_again"}  # the case's limit of frames ends the game in the no-ops


def copied(observation: Any) -> Any:
    if isinstance(observation, dict):
        return {name: np.array(part) for name, part in observation.items()}
    return np.array(observation)


def equal(one: Any, other: Any) -> bool:
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(np.array_equal(one[name], other[name]) for name in one)
    return np.array_equal(one, other)


def first_of(observations: Any) -> Any:
    """The observation of the first lane of a vector."""
    if isinstance(observations, dict):
        return {name: np.array(part[0]) for name, part in observations.items()}
    return np.array(observations[0])


def played(task: Task, path: Path, seed: int = 5) -> list[tuple[Any, int]]:
    """Record random play, and return the observation and the ALE action of each step."""
    env = RecordReplay(atari.make(task), path)
    generator, found = np.random.default_rng(0), []
    seen, _ = env.reset(seed=seed)
    for _ in range(STEPS):
        action = int(generator.integers(len(task.action_set)))
        found.append((copied(seen), int(task.action_set[action])))
        seen, _, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            seen, _ = env.reset()
    env.close()
    return found


def played_by_vector(task: Task, path: Path, seed: int = 5) -> list[tuple[Any, int]]:
    """The same in a lane of a vector."""
    envs = RecordReplay(atari.AtariVectorEnv(task, 1, autoreset_mode="Disabled", num_threads=1), path)
    generator, found = np.random.default_rng(0), []
    seen, _ = envs.reset(seed=seed)
    for _ in range(STEPS):
        action = generator.integers(0, len(task.action_set), 1)
        found.append((first_of(seen), int(task.action_set[action[0]])))
        seen, _, terminated, truncated, _ = envs.step(action)
        if terminated[0] or truncated[0]:
            seen, _ = envs.reset(options={"reset_mask": np.ones(1, np.bool_)})
    envs.close()
    return found


def check(task: Task, path: Path, expected: list[tuple[Any, int]], delayed: bool = False) -> None:
    steps = list(Replay.load(path).observations(task))
    assert len(steps) == len(expected)
    wrong = [number for number, step in enumerate(steps) if not equal(step.observation, expected[number][0])]
    assert wrong == []
    assert delayed or [step.action for step in steps] == [action for _, action in expected]


PLAYED = [name for name in atari.PRESETS if name != "multiplayer_dqn"]


@pytest.mark.parametrize("preset", PLAYED)
def test_observations_of_presets(preset: str, tmp_path: Path) -> None:
    life: dict[str, Any] = {} if preset == "gymnasium" else {"episodic_life": True}
    task = Task.of("breakout", preset=preset, **life)
    check(task, tmp_path / "a.a26r", played(task, tmp_path / "a.a26r"))
    check(task, tmp_path / "b.a26r", played_by_vector(task, tmp_path / "b.a26r"))


FIELDS = [name for name in CASES if name not in {"game", "players", "continuous", "continuous_action_threshold"}]


@pytest.mark.parametrize(
    "name", [name for name in FIELDS if "one" not in CASES[name].lacked_by and name != "sound_obs"]
)
def test_observations_with_each_field(name: str, tmp_path: Path) -> None:
    case = CASES[name]
    options = {**case.needs, **case.seen, name: case.value}
    task = Task.of(options.pop("game", "breakout"), **options)
    expected = played(task, tmp_path / "a.a26r")
    if name in DRAWN | ENDS_IN_A_RESET:
        with pytest.raises(ValueError, match=r"observation_delay=.* was drawn|recorded before frame"):
            check(task, tmp_path / "a.a26r", expected)
    else:
        check(task, tmp_path / "a.a26r", expected, delayed=name == "action_delay")


@pytest.mark.parametrize("env_id", ["ALE/Breakout-v5", "Breakout-v0", "BreakoutNoFrameskip-v4", "Breakout-ram-v0"])
def test_observations_of_ids(env_id: str, tmp_path: Path) -> None:
    task = Task.of(env_id)
    check(task, tmp_path / "a.a26r", played(task, tmp_path / "a.a26r"))


def test_other_observations_of_the_recorded_steps(tmp_path: Path) -> None:
    """The same game by the same rules, of an environment whose agent sees other images."""
    task, other = Task.of("breakout", preset="baselines"), Task.of("breakout", preset="baselines", img_height=42)
    expected = [(observation, action) for observation, action in played(other, tmp_path / "other.a26r")]
    played(task, tmp_path / "a.a26r")
    check(other, tmp_path / "a.a26r", expected)


def test_an_agent_watches_a_person(tmp_path: Path) -> None:
    """Of single frames, an agent of a frame skip of 4 sees the frames that an environment of that skip shows."""
    task = Task.of("breakout", preset="dqn2015", noops=(0, 0), episodic_life=False)
    skipped = RecordReplay(atari.make(task), tmp_path / "skipped.a26r")
    frames = RecordReplay(atari.AtariEnv("breakout", frameskip=1, repeat_action_probability=0.0), tmp_path / "one.a26r")
    generator, expected = np.random.default_rng(1), []
    seen, _ = skipped.reset(seed=3)
    frames.reset(seed=3)
    for _ in range(100):
        action = int(generator.integers(4))
        expected.append((np.array(seen), int(task.action_set[action])))
        seen, *_ = skipped.step(action)
        for _ in range(4):
            frames.step(action)
    skipped.close()
    frames.close()
    check(task, tmp_path / "one.a26r", expected)
    steps = list(Replay.load(tmp_path / "one.a26r").observations(task))
    assert [step.frame for step in steps] == list(range(0, 400, 4))
    assert [step.begins for step in steps] == [True] + [False] * 99


def test_lost_lives_begin_stacks_and_resets_begin_episodes(tmp_path: Path) -> None:
    """Of a person's games that a person begins anew, some of them in the middle."""
    with RecordReplay(atari.AtariEnv("breakout", frameskip=1), tmp_path / "a.a26r") as env:
        for game in range(2):
            env.reset(seed=game)
            for step in range(400):
                env.step(1 if step % 50 == 0 else 0)
    steps = list(Replay.load(tmp_path / "a.a26r").observations(Task.of("breakout", preset="baselines")))
    assert {step.episode for step in steps} == {0, 1}
    begins = [sum(step.begins for step in steps if step.episode == game) for game in range(2)]
    assert all(2 <= count <= 5 for count in begins)
    lives = [step for step in steps if step.begins]
    assert all(not step.observation[0].any() or (step.observation == step.observation[-1]).all() for step in lives)


def test_a_restored_snapshot_begins_anew(tmp_path: Path) -> None:
    task = Task.of("pong", preset="dqn2015", noops=(0, 0))
    with RecordReplay(atari.AtariEnv("pong", frameskip=4, repeat_action_probability=0.0), tmp_path / "a.a26r") as env:
        env.reset(seed=0)
        env.step(2)
        saved = env.unwrapped.snapshot()  # type: ignore[attr-defined]
        env.step(3)
        env.unwrapped.restore(saved)  # type: ignore[attr-defined]
        env.step(4)
    steps = list(Replay.load(tmp_path / "a.a26r").observations(task))
    assert [step.begins for step in steps] == [True, False, True]
    assert [step.episode for step in steps] == [0, 0, 1]


def test_what_is_refused(tmp_path: Path) -> None:
    with RecordReplay(atari.make("breakout"), tmp_path / "a.a26r") as env:
        env.reset(seed=0)
        env.step(1)
    replay = Replay.load(tmp_path / "a.a26r")
    with pytest.raises(ValueError, match="a replay of breakout, and the task is one of pong"):
        replay.observations(Task.of("pong"))
    with pytest.raises(ValueError, match="sound_obs=True adds sound"):
        replay.observations(Task.of("breakout", sound_obs=True))


def test_frames_of_wrappers_outside_of_the_task_are_refused(tmp_path: Path) -> None:
    from atari.wrappers import NoopReset

    with RecordReplay(NoopReset(atari.make("breakout"), 20, 10), tmp_path / "a.a26r") as env:
        env.reset(seed=0)
        env.step(1)
    with pytest.raises(ValueError, match=r"plays other frames than those recorded before frame"):
        list(Replay.load(tmp_path / "a.a26r").observations())
