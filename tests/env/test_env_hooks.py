"""The attributes that ale-py's environment reads, and the methods that it calls on itself: users set and override them."""

import copy
import pickle
from typing import Any

import ale_py.env
import gymnasium
import numpy as np
import pytest
from env_tools import data_equivalence, needs_new_ale_py

import atari.ale_py
from atari import AtariEnv
from atari.wrappers import DqnPreprocessing

pytestmark = needs_new_ale_py

KINDS = (AtariEnv, getattr(ale_py.env, "AtariEnv", AtariEnv))  # of old ale-py, whose tests are skipped, there is none


def overriding(kind: type, method: str, calls: list[str]) -> type:
    """A subclass that notes the calls of a method."""

    def noted(self: Any, *args: Any, **kwargs: Any) -> Any:
        calls.append(method)
        return getattr(kind, method)(self, *args, **kwargs)

    return type("Subclass", (kind,), {method: noted})


@pytest.mark.parametrize("method", ["seed_game", "load_game", "_get_obs", "_get_info", "reset", "step", "render"])
def test_an_override_is_called_where_ale_py_calls_it(method: str) -> None:
    seen = []
    for kind in KINDS:
        calls: list[str] = []
        env = overriding(kind, method, calls)("breakout", render_mode="rgb_array")
        counts = [len(calls)]
        for use in (
            lambda env: env.reset(seed=1),
            lambda env: env.step(1),
            lambda env: env.reset(),
            lambda env: env.render(),
        ):
            use(env)
            counts.append(len(calls))
        seen.append(counts)
    assert seen[0] == seen[1]


@pytest.mark.parametrize("kind", KINDS)
def test_what_an_override_returns_is_returned(kind: Any) -> None:
    class Mine(kind):
        def _get_obs(self) -> Any:
            return super()._get_obs() // 2

        def _get_info(self) -> dict[str, Any]:
            return {**super()._get_info(), "mine": 1}

    env, plain = Mine("pong"), kind("pong")
    for use in (lambda env: env.reset(seed=1), lambda env: env.step(2)):
        mine, shown = use(env), use(plain)
        assert np.array_equal(mine[0], shown[0] // 2)
        assert mine[-1] == {**shown[-1], "mine": 1}


def test_both_names_of_the_observation_are_overridden() -> None:
    class ByOurs(AtariEnv):
        def observe(self) -> Any:
            return "mine"

    class ByTheirs(AtariEnv):
        def _get_obs(self) -> Any:
            return "mine"

    class Deeper(ByTheirs):
        pass

    for kind in (ByOurs, ByTheirs, Deeper):
        env = kind("pong")
        assert env.reset(seed=1)[0] == env.observe() == env._get_obs() == env.step(0)[0] == "mine"


@pytest.mark.parametrize("kind", KINDS)
def test_methods_of_one_environment_can_be_replaced(kind: Any) -> None:
    env = kind("pong")
    env._get_info = lambda: {"mine": 1}
    env._get_obs = lambda: "seen"
    env.reset(seed=0)
    observation, *_, info = env.step(0)
    assert (observation, info) == ("seen", {"mine": 1})


def test_preprocessing_returns_the_information_of_an_override() -> None:
    class Mine(AtariEnv):
        def _get_info(self) -> dict[str, Any]:
            return {**super()._get_info(), "mine": self.core.ram()[0]}

    env, plain = (DqnPreprocessing(kind("breakout", frameskip=1)) for kind in (Mine, AtariEnv))
    assert env.reset(seed=1)[1]["mine"] == env.unwrapped.core.ram()[0]
    plain.reset(seed=1)
    for action in (1, 2, 3) * 10:
        mine, shown = env.step(action), plain.step(action)
        assert mine[4].pop("mine") == env.unwrapped.core.ram()[0]
        assert data_equivalence(mine, shown)


def test_a_mode_set_before_a_seeded_reset_is_played() -> None:
    cores = [AtariEnv("breakout", mode=4, core=core) for core in ("native", "plain", "ale")]
    envs = [*cores, ale_py.env.AtariEnv("breakout", mode=4)]
    for env in envs:
        env.reset(seed=1)
        assert (env._game, env._game_mode, env._game_difficulty) == ("breakout", 4, None)
        env._game_mode, env._game_difficulty = 20, 1
    for reset, mode in (({}, 4), ({"seed": 2}, 20), ({}, 20), ({"seed": 3}, 20)):
        *results, expected = (env.reset(**reset) for env in envs)
        assert all(data_equivalence(result, expected) for result in results)
        assert {env.ale.cloneState().getCurrentMode() for env in envs} == {mode}
        for action in (1, 2, 3) * 10:
            *results, expected = (env.step(action) for env in envs)
            assert all(data_equivalence(result, expected) for result in results)
    assert {(env.task.mode, env.task.difficulty) for env in cores} == {(20, 1)}


def test_none_is_the_games_default_mode() -> None:
    ours, theirs = (kind("breakout", mode=4, difficulty=1) for kind in KINDS)
    for env in (ours, theirs):
        env._game_mode = env._game_difficulty = None
        env.reset(seed=1)
        assert env._game_mode is None
    assert ours.ale.cloneState().getCurrentMode() == 0
    assert data_equivalence(ours.step(1), theirs.step(1))


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_copies_and_snapshots_keep_a_mode(duplicate: Any) -> None:
    env = AtariEnv("breakout")
    env.reset(seed=1)
    env._game_mode = 20
    copied = duplicate(env)
    assert copied._game_mode == 20
    for each in (env, copied):
        each.reset(seed=2)
        each.ale.setFloat("repeat_action_probability", 0.5)  # makes another core at the next load
        each.reset(seed=3)
        assert each.core.mode == 20
    saved = env.snapshot()
    assert data_equivalence(env.step(1), copied.step(1))
    env.restore(saved)
    again = duplicate(env)
    assert data_equivalence(env.step(2), again.step(2))
    env.close()
    env.reset()
    assert env.core.mode == 20


def test_a_mode_that_the_game_lacks_is_refused() -> None:
    env = AtariEnv("breakout")
    with pytest.raises(RuntimeError, match="breakout has no mode 5; it has 0, 4"):
        env._game_mode = 5
    with pytest.raises(RuntimeError, match="breakout has no difficulty 2; it has 0, 1"):
        env._game_difficulty = 2
    assert (env._game_mode, env._game_difficulty) == (None, None)


def test_actions_that_are_set_are_played() -> None:
    ours, theirs = (kind("breakout") for kind in KINDS)
    for env in (ours, theirs):
        env._action_set = [ale_py.Action.NOOP, ale_py.Action.LEFT, ale_py.Action.FIRE]
        env.action_space = gymnasium.spaces.Discrete(3)
        env.reset(seed=1)
    assert ours.get_action_meanings() == theirs.get_action_meanings() == ["NOOP", "LEFT", "FIRE"]
    assert ours._action_set == [atari.ale_py.Action[name] for name in ("NOOP", "LEFT", "FIRE")]
    for action in (2, 1, 1, 0) * 10:
        assert data_equivalence(ours.step(action), theirs.step(action))
    assert pickle.loads(pickle.dumps(ours))._action_set == ours._action_set
    with pytest.raises(ValueError, match=r"action 3 is not within 0\.\.2"):
        ours.step(3)
    with pytest.raises(ValueError, match=r"an ALE action number is within 0\.\.17, got 40"):
        ours._action_set = [40]


@pytest.mark.parametrize("name", ["_game", "continuous", "continuous_action_threshold"])
def test_what_a_change_would_not_reach_cannot_be_set(name: str) -> None:
    with pytest.raises(AttributeError):
        setattr(AtariEnv("breakout"), name, 0)


def test_the_frame_skip_and_the_kind_of_observations_can_be_set() -> None:
    ours, theirs = (kind("breakout") for kind in KINDS)
    for env in (ours, theirs):
        env.reset(seed=1)
        env._frameskip, env._obs_type = (2, 6), "ram"
    for action in (1, 2, 3) * 10:
        assert data_equivalence(ours.step(action), theirs.step(action))
