"""`AtariVectorEnv.play`: several steps in one call have the results of as many calls of `step`."""

from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest

import atari
from atari.base.gymnasium_versions import AutoresetMode
from atari.lab import Freeze
from atari.vector.results import indexed

Step = tuple[Any, Any, Any, Any, dict[str, Any]]
LANES = 3
OF_PLAY = ("steps", "_steps", "ram", "_ram")


def pair(game: Any = "breakout", **options: Any) -> tuple[atari.AtariVectorEnv, atari.AtariVectorEnv]:
    """Two equal vectors after a reset: one for `play`, one for `step`."""
    made = [atari.AtariVectorEnv(game, LANES, num_threads=2, **options) for _ in range(2)]
    for envs in made:
        envs.reset(seed=1)
    return made[0], made[1]


def random_actions(envs: atari.AtariVectorEnv, steps: int, seed: int = 0) -> Any:
    """Actions (lanes, steps, ...) of the vector's space."""
    space = envs.single_action_space
    space.seed(seed)
    return np.array([[space.sample() for _ in range(steps)] for _ in range(LANES)])


def assert_equal(one: Any, other: Any, where: str = "") -> None:
    """Check that two results have equal arrays of equal types; seconds may differ."""
    if isinstance(one, dict):
        assert one.keys() == other.keys(), where
        for name in one.keys() - {"t"}:
            assert_equal(one[name], other[name], f"{where}/{name}")
    elif isinstance(one, tuple):
        for number, (left, right) in enumerate(zip(one, other, strict=True)):
            assert_equal(left, right, f"{where}/{number}")
    else:
        assert (np.asarray(one).dtype, np.shape(one)) == (np.asarray(other).dtype, np.shape(other)), where
        assert np.array_equal(one, other), where


def assert_same_position(one: atari.AtariVectorEnv, other: atari.AtariVectorEnv) -> None:
    """Check that two vectors go on alike: in RAM and counters, and in the next step."""
    assert_equal(one.observe(), other.observe())
    assert_equal(one.ram(), other.ram())
    assert [lane.frame_number for lane in one.lanes] == [lane.frame_number for lane in other.lanes]


CASES: dict[str, dict[str, Any]] = {
    "a name": {},
    "dqn2015": {"preset": "dqn2015"},
    "one image": {"preset": "dqn2015", "stack_num": None},
    "atari100k": {"preset": "atari100k"},
    "baselines": {"preset": "baselines", "episodic_life": True},
    "seamless lives": {"preset": "envpool", "episodic_life": True},
    "short episodes": {"preset": "dqn2015", "frameskip": 1, "max_episode_steps": 9},
    "short games": {"frameskip": 1, "max_num_frames_per_episode": 31},
    "random skips": {"preset": "dqn2015", "frameskip": (2, 5)},
    "RGB": {"preset": "dqn2015", "obs_type": "rgb", "img_height": None, "img_width": None},
    "RAM": {"preset": "dqn2015", "obs_type": "ram", "stack_num": 2},
    "dict": {"preset": "dqn2015", "obs_type": "dict", "channels_last": True},
    "delays": {"preset": "dqn2015", "observation_delay": (0, 3), "action_delay": 2},
    "continuous": {"preset": "dqn2015", "continuous": True},
    "reward": {"preset": "dqn2015", "reward": "reward - 5 * lives_lost"},
}


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("case", CASES)
def test_plays_on_as_steps_do(case: str, mode: AutoresetMode) -> None:
    played, stepped = pair(**CASES[case], autoreset_mode=mode)
    for call, steps in enumerate((1, 3, 40, 120)):
        actions = random_actions(played, steps, seed=call)
        result = played.play(actions, discount=0.9, stop=False)
        rewards, weight = np.zeros(LANES), 1.0
        for step in range(steps):
            last = stepped.step(actions[:, step])
            rewards += weight * last[1]
            weight *= 0.9
        info = result[4]
        assert info["steps"].tolist() == [steps] * LANES
        assert_equal(info["ram"], stepped.ram())
        shared = {name: value for name, value in info.items() if name not in OF_PLAY}
        assert_equal((*result[:4], shared), (last[0], rewards, *last[2:]))
        assert_equal(played.ram(of="final"), stepped.ram(of="final"))
    assert_same_position(played, stepped)


def steps_to_end(envs: atari.AtariVectorEnv, lane: int, actions: Any) -> Iterator[Step]:
    """The results of steps of one lane, up to the first end of an episode."""
    waits = envs.lanes[lane].ended and envs.autoreset_mode == AutoresetMode.DISABLED
    for action in actions[:0] if waits else actions:
        result = envs.step([action], env_id=[lane])
        yield result
        if envs.lanes[lane].ended or "final_obs" in result[4]:
            return


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("case", CASES)
def test_stops_at_the_end_of_an_episode(case: str, mode: AutoresetMode) -> None:
    options = {"max_num_frames_per_episode": 200, **CASES[case]}
    played, stepped = pair(**options, autoreset_mode=mode)
    stops = 0
    for call, steps in enumerate((20, 70, 150)):
        actions = random_actions(played, steps, seed=call)
        result = played.play(actions)
        for lane in range(LANES):
            results = list(steps_to_end(stepped, lane, actions[lane]))
            row = indexed(result, [lane])
            assert row[4]["steps"].tolist() == [len(results)]
            assert row[1].tolist() == [sum(float(one[1][0]) for one in results)]
            stops += len(results) < steps
            if results:
                observation, _, *ends, info = results[-1]
                assert_equal((row[0], *row[2:4]), (observation, *ends))
                for name in info.keys() - {"final_info", "episode", "_episode"}:
                    assert_equal(row[4][name], info[name], name)
    assert stops
    assert_same_position(played, stepped)


@pytest.mark.parametrize("stop", [False, True])
@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("case", ["seamless lives", "short episodes", "dict", "reward"])
def test_every_step_has_its_results(case: str, mode: AutoresetMode, stop: bool) -> None:
    played, stepped = pair(**CASES[case], autoreset_mode=mode)
    steps = 40
    actions = random_actions(played, steps)
    result = played.play(actions, every=True, stop=stop)
    count = result[4]["steps"]
    assert stop or count.tolist() == [steps] * LANES
    info = {name: value for name, value in result[4].items() if name not in ("steps", "_steps")}
    for lane in range(LANES):
        for step in range(count[lane]):
            *values, facts = indexed((*result[:4], info), (lane, step))
            *expected, expected_facts = indexed(stepped.step([actions[lane, step]], env_id=[lane]), 0)
            assert_equal(tuple(values), tuple(expected))
            for name in expected_facts.keys() - {"final_info", "episode", "_episode"}:
                assert_equal(facts[name], expected_facts[name], name)
            assert_equal(facts["ram"], stepped.ram([lane])[0])
    assert np.array_equal(info["_lives"], np.arange(steps) < count[:, None])
    assert not result[2][~info["_lives"]].any()
    assert_same_position(played, stepped)


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("stack_num", [None, 1, 4])
@pytest.mark.parametrize("preset", ["dqn2015", "gymnasium", "baselines"])
def test_episodes_that_end_near_the_end_of_a_sequence(preset: str, stack_num: int | None, mode: AutoresetMode) -> None:
    """Lane 0 is three steps ahead; a game has 20 steps, and the last frame of a skip ends it."""
    played, stepped = pair(preset=preset, stack_num=stack_num, noops=(0, 0), max_frames=80, autoreset_mode=mode)
    ahead = np.ones((1, 3), int)
    for steps in range(14, 30):
        for envs in (played, stepped):
            envs.reset(seed=1)
            envs.play(ahead, env_id=[0], every=True)
        actions = random_actions(played, steps)
        result = played.play(actions, stop=False)
        for step in range(steps):
            last = stepped.step(actions[:, step])
        assert_equal((result[0], *result[2:4]), (last[0], *last[2:4]), str(steps))
        for name in last[4]:
            assert_equal(result[4][name], last[4][name], f"{name} after {steps} steps")


def test_several_players() -> None:
    played, stepped = pair("pong", players=2, preset="multiplayer_dqn", zero_sum=True)
    actions = random_actions(played, 30)
    result = played.play(actions, stop=False)
    rewards = np.sum([stepped.step(actions[:, step])[1] for step in range(30)], axis=0)
    assert result[1].shape == (LANES, 2)
    assert_equal(result[1], rewards)
    assert_same_position(played, stepped)


def test_several_games_each_with_its_own_actions() -> None:
    played, stepped = pair(["pong", "breakout", "ms_pacman"], preset="dqn2015")
    actions = random_actions(played, 30)
    result = played.play(actions, stop=False)
    for step in range(30):
        last = stepped.step(actions[:, step])
    assert_equal(result[0], last[0])
    assert_equal(result[4]["action_mask"], last[4]["action_mask"])


def test_some_environments() -> None:
    played, stepped = pair(preset="dqn2015")
    before = played.ram([1])
    actions = random_actions(played, 25)[:2]
    result = played.play(actions, env_id=[2, 0])
    for step in range(25):
        last = stepped.step(actions[:, step], env_id=[2, 0])
    assert result[4]["env_id"].tolist() == [2, 0]
    assert_equal(result[0], last[0])
    assert_equal(result[4]["ram"], stepped.ram(np.array([2, 0])))
    assert_equal(played.ram([1]), before)
    every = played.play(actions, env_id=[2, 0], every=True)
    assert every[0].shape == (2, 25, 4, 84, 84)
    assert_equal(played.ram([1]), before)


def test_interventions_and_moves_are_those_of_steps() -> None:
    played, stepped = pair(preset="machado2018")
    for envs in (played, stepped):
        Freeze(envs, ball_x=40, index=0)
        envs.lanes[1].record_moves()
    actions = random_actions(played, 25)
    played.play(actions, stop=False)
    for step in range(25):
        stepped.step(actions[:, step])
    assert played.lanes[1].take_moves() == stepped.lanes[1].take_moves()
    assert_same_position(played, stepped)


def test_observations_do_not_change_while_they_are_held() -> None:
    envs, _ = pair(preset="dqn2015")
    held = [envs.play(random_actions(envs, 12, seed))[0] for seed in range(4)]
    copies = [one.copy() for one in held]
    envs.play(random_actions(envs, 12))
    assert_equal(tuple(held), tuple(copies))


WRONG: dict[str, tuple[dict[str, Any], type[Exception], str]] = {
    "no steps": ({"actions": np.zeros((LANES, 0), int)}, ValueError, r"shape \(3, steps\), with a step or more, got"),
    "too many steps": ({"actions": np.zeros((LANES, 1_000_001), np.uint8)}, ValueError, "has 1 to 1000000 steps"),
    "one axis": ({"actions": np.zeros(LANES, int)}, ValueError, r"shape \(3, steps\)"),
    "rows": ({"actions": np.zeros((2, 5), int)}, ValueError, r"shape \(3, steps\)"),
    "rows of env_id": ({"env_id": [0]}, ValueError, r"shape \(1, steps\)"),
    "floats": ({"actions": np.zeros((LANES, 5))}, TypeError, "actions must be integers"),
    "the last action": ({"actions": np.array([[0] * 5, [0] * 5, [0] * 4 + [4]])}, ValueError, "row 2, step 4, is not"),
    "discount": ({"discount": 1.5}, ValueError, "discount"),
    "stop": ({"stop": 1}, TypeError, "stop must be True or False"),
    "discount and every": ({"discount": 0.9, "every": True}, ValueError, "leave discount=0.9 out"),
    "environment": ({"env_id": [0, 1, 3]}, IndexError, "environment 3"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_nothing_is_played_after_an_error(wrong: str) -> None:
    arguments, error, message = WRONG[wrong]
    envs, other = pair(preset="dqn2015")
    with pytest.raises(error, match=message):
        envs.play(**{"actions": np.zeros((LANES, 5), int), **arguments})
    assert_same_position(envs, other)


def test_needs_a_reset_no_pending_step_and_whole_batches() -> None:
    envs = atari.AtariVectorEnv("pong", LANES)
    actions = np.zeros((LANES, 2), int)
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.play(actions)
    envs.reset(seed=0)
    envs.send(actions[:, 0])
    with pytest.raises(gymnasium.error.AlreadyPendingCallError):
        envs.play(actions)
    envs.recv()
    assert envs.play(actions)[4]["steps"].tolist() == [2] * LANES
    parts = atari.AtariVectorEnv("pong", LANES, batch_size=2)
    parts.reset(seed=0)
    with pytest.raises(ValueError, match="batches of all environments"):
        parts.play(actions[:2])
