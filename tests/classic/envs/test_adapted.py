"""The classes of `gym.envs`: constructed, subclassed, copied, registered by their paths."""

import copy
import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest

import atari.classic as gym
from atari.classic.adapter import CLASSES
from atari.classic.envs import classic_control, toy_text


@pytest.mark.parametrize("kind", CLASSES.values(), ids=lambda kind: kind.__name__)
def test_a_constructed_environment_plays(kind: type[gym.Env]) -> None:
    env = kind()
    assert str(env) == f"<{kind.__name__} instance>"
    env.seed(0)
    env.action_space.seed(0)
    assert env.observation_space.contains(env.reset())
    for _ in range(5):
        observation, reward, done, info = env.step(env.action_space.sample())
        assert (float(reward), type(done), type(info)) == (reward, bool, dict)
        assert env.observation_space.contains(env.reset() if done else observation)
    assert kind.metadata["render.modes"] == env.metadata["render.modes"]
    assert kind.metadata["video.pixel_aspect"] == env.metadata["video.pixel_aspect"]


@pytest.mark.parametrize(
    ("env_id", "kind"),
    [
        ("CartPole-v1", classic_control.CartPoleEnv),
        ("Acrobot-v1", classic_control.AcrobotEnv),
        ("MountainCarContinuous-v0", classic_control.Continuous_MountainCarEnv),
        ("Pendulum-v0", classic_control.PendulumEnv),
        ("Blackjack-v0", toy_text.BlackjackEnv),
        ("CliffWalking-v0", toy_text.CliffWalkingEnv),
        ("Taxi-v3", toy_text.TaxiEnv),
    ],
)
def test_make_returns_the_same_classes(env_id: str, kind: type[gym.Env]) -> None:
    env, other = gym.make(env_id).unwrapped, kind()
    assert type(env) is kind
    assert f".{kind.__module__.split('.')[-1]}." in str(kind)
    for each in (env, other):
        each.seed(5)
        each.action_space.seed(5)
    np.testing.assert_array_equal(env.reset(), other.reset())
    action = env.action_space.sample()
    np.testing.assert_array_equal(env.step(action)[0], other.step(action)[0])


class Heavy(classic_control.PendulumEnv):
    """Replaces a method that the adapted environment calls, and `step` under its name of 2016."""

    def __init__(self) -> None:
        super().__init__(g=5.0)
        self.m = 2.0
        self.calls = 0

    def _get_obs(self) -> Any:
        return np.zeros(3, np.float32)

    def _step(self, action: Any) -> Any:
        self.calls += 1
        return super()._step(action)


def test_a_subclass_replaces_methods_that_the_environment_calls() -> None:
    env = Heavy()
    assert (env.g, env.m, env.modern.unwrapped.m) == (5.0, 2.0, 2.0)  # type: ignore[attr-defined]
    assert env.reset().tolist() == [0, 0, 0]
    assert (env.step([1.0])[0].tolist(), env.calls) == ([0, 0, 0], 1)


class Long(classic_control.AcrobotEnv):
    LINK_LENGTH_1 = 3.0


def test_a_subclass_replaces_constants() -> None:
    env = Long()
    assert env.modern.unwrapped.LINK_LENGTH_1 == 3.0  # type: ignore[attr-defined]
    env.LINK_LENGTH_1 = 4.0
    assert (env.LINK_LENGTH_1, env.modern.unwrapped.LINK_LENGTH_1) == (4.0, 4.0)  # type: ignore[attr-defined]
    plain = classic_control.AcrobotEnv()
    for each in (env, plain):
        each.seed(0)
        each.reset()
    assert (env.step(2)[0] != plain.step(2)[0]).any()


@pytest.mark.parametrize("make_copy", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_of_a_subclass_plays_on(make_copy: Any) -> None:
    env = Heavy()
    env.seed(0)
    env.reset()
    other = make_copy(env)
    assert type(other) is Heavy
    for each in (env, other):
        each.step([0.5])
        each.reset()
    np.testing.assert_array_equal(env.state, other.state)
    assert (env.calls, other.calls) == (1, 1)
    other.modern._get_obs()
    assert other.modern._get_obs.__self__ is other  # not the original


def test_a_toy_text_has_a_state_before_the_first_reset() -> None:
    env: Any = toy_text.TaxiEnv()
    env.seed(0)
    state = env.s
    assert (env.s, env.reset()) == (state, state)
    env.s = 114
    assert (env.s, env.lastaction) == (114, None)
    assert env.encode(*env.decode(state)) == state
    env.s = env.encode(0, 0, 1, 2)
    assert env.step(0)[0] == env.encode(1, 0, 1, 2) == env.s


def test_a_map_of_ones_own() -> None:
    env = toy_text.FrozenLakeEnv(["SF", "HG"], is_slippery=False)
    assert (env.reset(), env.step(2)[:3], env.step(1)[:3]) == (0, (1, 0, False), (3, 1, True))
    assert toy_text.frozen_lake.MAPS["4x4"][0] == "SFFF"  # type: ignore[attr-defined]
    assert len(toy_text.frozen_lake.generate_random_map(5)) == 5  # type: ignore[attr-defined]
    with pytest.raises(TypeError, match="success_rate"):
        toy_text.FrozenLakeEnv(success_rate=0.5)  # type: ignore[call-arg]


def test_a_class_registered_by_its_path_is_made_by_gymnasium_too() -> None:
    gym.register("HalfCart-v0", entry_point="gym.envs.classic_control:CartPoleEnv", max_episode_steps=3)
    env = gymnasium.make("HalfCart-v0", render_mode="rgb_array")
    env.reset(seed=0)
    assert np.shape(env.render()) == (400, 600, 3)
    assert [env.step(0)[2:4] for _ in range(3)] == [(False, False), (False, False), (False, True)]
    options = {"map_name": "4x4", "is_slippery": False}
    path = "gym.envs.toy_text:FrozenLakeEnv"
    gym.envs.registration.register(id="FirmLake-v0", entry_point=path, kwargs=options, reward_threshold=0.78)
    lake = gym.make("FirmLake-v0")
    assert lake.spec is not None
    assert (lake.reset(), lake.spec.reward_threshold) == (0, 0.78)
    assert [lake.step(action)[:3] for action in (1, 1, 2, 1, 2, 2)][-1] == (15, 1, True)


def test_a_path_of_another_module_of_gym_means_gymnasiums() -> None:
    load = gym.envs.registration.load
    assert load("gym.envs.registration:EnvSpec").__module__.startswith("gymnasium.")


def test_the_viewer_for_geometry_is_not_provided() -> None:
    with pytest.raises(AttributeError, match=r"^rendering.Viewer drew by OpenGL and is not provided; draw an image"):
        _ = classic_control.rendering.Viewer
    with pytest.raises(AttributeError, match="no attribute 'Nothing'"):
        _ = classic_control.rendering.Nothing
