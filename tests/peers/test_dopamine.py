"""Preset `dopamine` beside Dopamine's `AtariPreprocessing`, with the stack of its agents and its runner's clipping."""

import sys
from types import ModuleType, SimpleNamespace

import ale_py
import gymnasium
import numpy as np
import pytest

from atari import AtariEnv
from atari.wrappers import preset, preset_options

pytestmark = pytest.mark.peers

CASES = {
    "defaults": {},
    "episodic life": {"episodic_life": True},
    "truncation inside a skip": {"limit": 203},
}


@pytest.fixture
def atari_lib(monkeypatch):
    """Dopamine's module, with stand-ins for what it imports for its networks and for old versions of Gym."""
    stand_ins = {
        "tensorflow": {"uint8": np.uint8, "keras": SimpleNamespace(Model=object)},
        "gym": {},
        "baselines": {},
        "baselines.common": {"atari_wrappers": None},
    }
    for name, content in stand_ins.items():
        module = ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    from dopamine.discrete_domains import atari_lib

    return atari_lib


@pytest.mark.parametrize("game", ["breakout", "pong", "ms_pacman", "bank_heist", "frogger", "qbert", "carnival"])
@pytest.mark.parametrize("case", CASES)
def test_same_bytes(atari_lib, game, case):
    compare(atari_lib, game, **CASES[case])


def compare(atari_lib, game, limit=108_000, episodic_life=False, steps=600):
    options = {**preset_options("dopamine"), "max_num_frames_per_episode": limit}
    inner = ale_py.AtariEnv(game, **options)
    theirs = atari_lib.AtariPreprocessing(gymnasium.wrappers.OrderEnforcing(inner), terminal_on_life_loss=episodic_life)
    env = AtariEnv(game, **options)
    ours = preset(env, "dopamine", episodic_life=episodic_life)
    inner.reset(seed=3)
    env.reset(seed=3)

    expected = push(np.zeros((4, 84, 84), np.uint8), theirs.reset())
    observation, _ = ours.reset()
    rng = np.random.default_rng(3)
    ends = 0
    for _ in range(steps):
        np.testing.assert_array_equal(observation, expected)
        action = int(rng.integers(env.action_space.n))
        frame, reward, ended, _ = theirs.step(action)
        observation, own_reward, terminated, truncated, _ = ours.step(action)
        assert own_reward == np.clip(reward, -1, 1)
        assert (terminated or truncated) == ended
        expected = push(expected, frame)
        if ended:
            ends += 1
            np.testing.assert_array_equal(observation, expected)
            # As in Dopamine's runner, a reset follows only the end of the game; after a lost life the frame stays.
            expected = push(np.zeros_like(expected), theirs.reset() if theirs.game_over else frame)
            observation, _ = ours.reset()
    assert ends > 0 or limit > 4 * steps


def push(stack, frame):
    """The stack of an agent, with the new frame last."""
    return np.concatenate([stack[1:], frame[None, ..., 0]])


def test_its_function_makes_our_environment(atari_lib):
    """The environment of its runner, where only `import atari` was added."""
    theirs = atari_lib.create_atari_environment("Breakout")
    assert isinstance(theirs.environment.unwrapped, AtariEnv)
    ours = preset(AtariEnv("breakout", **preset_options("dopamine")), "dopamine")
    theirs.environment.reset(seed=3)
    ours.reset(seed=3)
    assert np.array_equal(theirs.reset()[..., 0], ours.reset()[0][-1])
    for step in range(400):
        frame, reward, ended, _ = theirs.step(step % 4)
        observation, own_reward, terminated, truncated, _ = ours.step(step % 4)
        assert np.array_equal(frame[..., 0], observation[-1])
        assert (np.clip(reward, -1, 1), ended) == (own_reward, terminated or truncated)
        if ended:
            assert np.array_equal(theirs.reset()[..., 0], ours.reset()[0][-1])
