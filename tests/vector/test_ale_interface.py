"""`AtariVectorEnv.ale`, and the other attributes of ale-py's vector environment."""

from collections.abc import Callable
from typing import Any

import ale_py
import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence

from atari import AtariVectorEnv
from atari.vector.ale_interface import AleVectorInterface

Theirs: Any = pytest.importorskip("ale_py.vector_env", reason="this ale-py has no vector environment").AtariVectorEnv

KEYS = ("env_id", "lives", "frame_number", "episode_frame_number")


def both(**options: Any) -> tuple[AtariVectorEnv, Any]:
    return AtariVectorEnv("breakout", 3, **options), Theirs("breakout", 3, **options)


def same(ours: tuple[Any, ...], theirs: tuple[Any, ...]) -> bool:
    mine = {key: ours[-1][key] for key in KEYS}
    return data_equivalence((*ours[:-1], mine), (*theirs[:-1], {key: theirs[-1][key] for key in KEYS}))


def test_nothing_is_left_out() -> None:
    names = {name for name in dir(ale_py.ALEVectorInterface) if not name.startswith("_")}
    assert names - set(dir(AleVectorInterface)) == set()


@pytest.mark.parametrize(
    "options", [{}, {"continuous": True, "continuous_action_threshold": 0.25}, {"grayscale": False}]
)
def test_attributes_are_those_of_ale_py(options: dict[str, Any]) -> None:
    ours, theirs = both(**options)
    for name in ("continuous", "continuous_action_threshold", "grayscale", "batch_size", "num_envs", "autoreset_mode"):
        assert getattr(ours, name) == getattr(theirs, name), name
    for name in ("get_num_envs", "get_observation_shape"):
        assert getattr(ours.ale, name)() == getattr(theirs.ale, name)(), name
    actions = [[(action.name, action.value) for action in envs.ale.get_action_set()] for envs in (ours, theirs)]
    assert actions[0] == actions[1]


def test_resets_and_steps_are_those_of_ale_py() -> None:
    ours, theirs = both()
    assert same(ours.ale.reset([2, 0, 1], [7, 8, 9]), theirs.ale.reset(np.array([2, 0, 1]), np.array([7, 8, 9])))
    for _ in range(20):
        for envs in (ours, theirs):
            envs.ale.send(np.array([1, 2, 3]), np.ones(3, np.float32))
        assert same(ours.ale.recv(), theirs.ale.recv())
    assert same(ours.ale.reset([1], [-1]), theirs.ale.reset(np.array([1]), np.array([-1])))


@pytest.mark.parametrize(
    ("use", "error", "text"),
    [
        (lambda ale: ale.reset([0, 0], [-1, -1]), ValueError, "duplicate env_id 0"),
        (lambda ale: ale.reset([3], [-1]), IndexError, "environment 3 is out of range; there are 3"),
        (lambda ale: ale.reset([0, 1], [-1]), ValueError, "there must be one seed for each of 2 environments, got 1"),
        (lambda ale: ale.send([0, 0], [1.0, 1.0]), ValueError, "both must have the shape (3,), got (2,) and (2,)"),
        (lambda ale: ale.send([0.0] * 3, [1.0] * 3), TypeError, "actions must be integers and strengths floats"),
        (lambda ale: ale.send([0] * 3, [np.nan] * 3), ValueError, "strength must be finite"),
        (lambda ale: ale.send([9] * 3, [1.0] * 3), ValueError, "action 9 in row 0 is not within 0..3"),
    ],
)
def test_wrong_calls(use: Callable[[AleVectorInterface], Any], error: type[Exception], text: str) -> None:
    envs = AtariVectorEnv("breakout", 3)
    envs.reset()
    with pytest.raises(error) as caught:
        use(envs.ale)
    assert text in str(caught.value)
    envs.step(np.zeros(3, int))


def test_a_partial_first_reset_raises_the_errors_of_both() -> None:
    mask = np.array([True, False, False])
    for envs in both():
        with pytest.raises(RuntimeError, match=r"first reset\(\) must reset every"):
            envs.reset(options={"reset_mask": mask})
    with pytest.raises(gymnasium.error.ResetNeeded):
        AtariVectorEnv("breakout", 3).reset(options={"reset_mask": mask})


@pytest.mark.parametrize("frameskip", [0, -1, 4.0])
def test_where_ale_py_raises_gymnasiums_error_ours_is_one_too(frameskip: Any) -> None:
    for kind in (AtariVectorEnv, Theirs):
        with pytest.raises(gymnasium.error.Error, match="frameskip"):
            kind("breakout", 3, frameskip=frameskip)


def test_render_fps_is_an_int() -> None:
    fps = AtariVectorEnv("breakout", 2).metadata["render_fps"]
    assert (fps, type(fps)) == (15, int)
