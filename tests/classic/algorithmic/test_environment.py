"""The rules of all algorithmic tasks: movement, writing, reward, the end of an episode."""

import copy
import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest

from atari.classic.algorithmic import CopyEnv, DuplicatedInputEnv, ReversedAdditionEnv
from atari.registry.registration import ALGORITHMIC

LEFT, RIGHT, UP, DOWN = range(4)
BLANK = 2


@pytest.fixture
def env() -> CopyEnv:
    env = CopyEnv(base=2)
    assert env.reset(seed=0, options={"input": "AB"})[0] == 0
    return env


@pytest.mark.parametrize(
    ("actions", "results", "solved"),
    [
        ([(RIGHT, 1, 0), (LEFT, 1, 1)], [(1, 1.0, False, False), (0, 1.0, True, False)], True),
        ([(RIGHT, 1, 1)], [(1, -0.5, True, False)], False),
        ([(RIGHT, 1, 0), (RIGHT, 1, 0)], [(1, 1.0, False, False), (BLANK, -0.5, True, False)], False),
        ([(RIGHT, 0, 1)], [(1, 0.0, False, False)], False),
    ],
    ids=["right", "wrong", "the last wrong", "not written"],
)
def test_a_character_is_a_point_or_the_end(env: CopyEnv, actions: list[Any], results: list[Any], solved: bool) -> None:
    assert [env.step(action)[:4] for action in actions] == results
    assert (env.solved, env._info()["solved"]) == (solved, solved)
    assert env.write_head == sum(write for _, write, _ in actions)


def test_the_head_walks_off_the_tape_and_back(env: CopyEnv) -> None:
    moves = (LEFT, LEFT, RIGHT, RIGHT, RIGHT, RIGHT)
    assert [env.step((move, 0, 0))[0] for move in moves] == [BLANK, BLANK, BLANK, 0, 1, BLANK]
    assert env.read_head == (2, 0)


def test_the_head_walks_on_a_grid() -> None:
    env = ReversedAdditionEnv(rows=2, base=6, steps_per_column=9)
    assert env.reset(options={"input": "012\n345"})[0] == 0
    moves = (DOWN, UP, RIGHT, DOWN, DOWN, RIGHT, UP, UP, LEFT, UP)
    assert [env.step((move, 0, 0))[0] for move in moves] == [3, 0, 1, 4, 6, 6, 5, 2, 1, 6]


def test_running_out_of_time_costs_a_point(env: CopyEnv) -> None:
    assert env.time_limit == 2 + 2 + 4
    steps = [env.step((LEFT, 0, 0)) for _ in range(9)]
    assert [step[1] for step in steps] == [0.0] * 8 + [-1.0]
    assert [step[2] for step in steps] == [False] * 8 + [True]
    assert not steps[-1][3]


def test_the_last_character_may_come_too_late(env: CopyEnv) -> None:
    env.step((LEFT, 1, 0))
    for _ in range(7):
        env.step((LEFT, 0, 0))
    _, reward, terminated, _, info = env.step((LEFT, 1, 1))
    assert (reward, terminated, info["solved"], env.total_reward) == (-1.0, True, False, 0.0)


def test_info_has_the_state(env: CopyEnv) -> None:
    numbers = {"read_head": (1, 0), "write_head": 1, "time": 1, "time_limit": 8, "min_length": 2}
    assert env.step((RIGHT, 1, 0))[4] == {"input": "AB", "target": "AB", "solved": False, **numbers}


def test_an_input_can_be_given_again() -> None:
    env = ReversedAdditionEnv(rows=3)
    first, info = env.reset(seed=5)
    again, info_again = env.reset(options={"input": info["input"]})
    assert (again, info_again) == (first, info)
    assert env.reset(seed=6)[1]["input"] != info["input"]


def test_the_same_seed_and_actions_give_the_same_episodes() -> None:
    def play(env: CopyEnv) -> list[Any]:
        record: list[Any] = [env.reset(seed=3)]
        for _ in range(30):  # all solved, so the inputs grow on the way
            observation = record[-1][0]
            while env._playing:
                record.append(env.step((RIGHT, 1, observation)))
                observation = record[-1][0]
            record.append(env.reset())
        return record

    env = CopyEnv()
    first = play(env)
    assert env.min_length == 5
    assert play(env) == first
    assert play(CopyEnv()) == first


def test_copies_and_pickles_continue(env: CopyEnv) -> None:
    env.step((RIGHT, 1, 0))
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert other.step((RIGHT, 1, 1))[:3] == (BLANK, 1.0, True)
        other_next, env_next = other.reset()[1]["input"], copy.deepcopy(env).reset()[1]["input"]
        assert other_next == env_next


@pytest.mark.parametrize("env_id", ALGORITHMIC)
def test_vector_environments_take_them(env_id: str) -> None:
    envs = gymnasium.make_vec(env_id, num_envs=3, vectorization_mode="sync")
    single = gymnasium.make(env_id)
    observations, info = envs.reset(seed=7)
    firsts = [single.reset(seed=7 + index) for index in range(3)]
    assert observations.tolist() == [first for first, _ in firsts]
    assert info["input"].tolist() == [info["input"] for _, info in firsts]
    envs.action_space.seed(0)
    for _ in range(20):
        observations, rewards, *_ = envs.step(envs.action_space.sample())
    assert observations.shape == rewards.shape == (3,)
    envs.close()


# Mistakes


@pytest.mark.parametrize(
    "wrong", [1, (1, 1), (2, 1, 0), (0, 2, 0), (0, 1, 2), (0, 1, -1), (0.5, 1, 1), "011", None, (0, 1, 0, 0)]
)
def test_a_wrong_action_changes_nothing(env: CopyEnv, wrong: Any) -> None:
    with pytest.raises(ValueError, match=r"an action is \(movement 0..1, write 0..1, character 0..1\), got"):
        env.step(wrong)
    assert (env.time, env.read_head, env.write_head) == (0, (0, 0), 0)


@pytest.mark.parametrize("action", [[RIGHT, 1, 0], np.array([RIGHT, 1, 0]), (np.int64(1), np.int8(1), 0)])
def test_actions_may_be_lists_and_arrays(env: CopyEnv, action: Any) -> None:
    assert env.step(action)[:3] == (1, 1.0, False)


def test_a_step_needs_an_episode(env: CopyEnv) -> None:
    env.step((RIGHT, 1, 1))
    for each in (CopyEnv(), env):
        with pytest.raises(gymnasium.error.ResetNeeded, match=r"call env.reset\(\) before env.step\(\)"):
            each.step((RIGHT, 1, 0))


@pytest.mark.parametrize("wrong", ["", "C", "a", "A\nB", [0, 1], None, "A "])
def test_a_wrong_input_changes_nothing(env: CopyEnv, wrong: Any) -> None:
    env.step((RIGHT, 1, 0))
    with pytest.raises(ValueError, match=r"options\['input'\] is 1 line\(s\) of equal length, made of 'AB', got"):
        env.reset(seed=9, options={"input": wrong})
    assert (env.time, env.read_head) == (1, (1, 0))


@pytest.mark.parametrize("wrong", ["012", "01\n2", "012\n013", "\n"])
def test_a_grid_needs_rows_of_one_length(wrong: str) -> None:
    with pytest.raises(ValueError, match=r"options\['input'\] is 2 line\(s\) of equal length, made of '012', got"):
        ReversedAdditionEnv().reset(options={"input": wrong})


@pytest.mark.parametrize(
    ("kind", "options", "text"),
    [
        (CopyEnv, {"base": 0}, r"base must be within 1\.\.26, got 0"),
        (CopyEnv, {"base": 27}, r"base must be within 1\.\.26, got 27"),
        (CopyEnv, {"base": 2.5}, r"base must be an integer within 1\.\.26, got 2\.5"),
        (CopyEnv, {"min_length": 0}, r"min_length must be within 1\.\.30, got 0"),
        (CopyEnv, {"min_length": 31}, r"min_length must be within 1\.\.30, got 31"),
        (CopyEnv, {"min_length": "3"}, r"min_length must be an integer within 1\.\.30, got '3'"),
        (CopyEnv, {"render_mode": "rgb_array"}, "render_mode is 'human', 'ansi' or None, got 'rgb_array'"),
        (DuplicatedInputEnv, {"duplication": 0}, r"duplication must be within 1\.\.100, got 0"),
        (ReversedAdditionEnv, {"rows": 0}, r"rows must be within 1\.\.100, got 0"),
        (ReversedAdditionEnv, {"steps_per_column": 0}, r"steps_per_column must be within 1\.\.100, got 0"),
        (ReversedAdditionEnv, {"base": 11}, r"base must be within 1\.\.10, got 11"),
    ],
)
def test_wrong_options(kind: type[Any], options: dict[str, Any], text: str) -> None:
    with pytest.raises((TypeError, ValueError), match=text):
        kind(**options)
