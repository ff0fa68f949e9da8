"""The wrappers of Gym's last years: normalisation, parts of observations, images, time, order."""

from typing import Any

import numpy as np
import pytest

import atari.classic as gym
from atari.classic import wrappers


class Walk(gym.Env):
    """Rewards and observations count the steps; an episode has three."""

    metadata = {"render.modes": ["rgb_array"]}  # noqa: RUF012
    action_space = gym.spaces.Discrete(2)
    observation_space = gym.spaces.Box(-9, 9, (2,))

    def reset(self) -> Any:
        self.n = 0
        return np.array([0, 1], np.float32)

    def step(self, action: Any) -> Any:
        self.n += 1
        return np.array([self.n, -self.n], np.float32), float(self.n), self.n == 3, {}

    def render(self, mode: str = "human") -> Any:
        return np.full((4, 5, 3), getattr(self, "n", 0), np.uint8)


class Parts(Walk):
    observation_space = gym.spaces.Dict(a=gym.spaces.Discrete(9), b=gym.spaces.Discrete(9))

    def reset(self) -> Any:
        self.n = 0
        return {"a": 0, "b": 1}


def test_observations_are_normalised_by_all_before() -> None:
    env = wrappers.NormalizeObservation(Walk())
    seen: list[list[float]] = []
    for observation, plain in ((env.reset(), [0, 1]), (env.step(0)[0], [1, -1]), (env.step(0)[0], [2, -2])):
        seen.append(plain)
        # the first moments are those of one ten-thousandth of a sample with mean 0 and variance 1
        count, values = len(seen) + 1e-4, np.array(seen, float)
        mean = values.sum(0) / count
        variance = (((values - mean) ** 2).sum(0) + 1e-4 * (1 + mean**2)) / count
        np.testing.assert_allclose(observation, (seen[-1] - mean) / np.sqrt(variance + 1e-8))


def test_rewards_are_normalised_by_the_deviation_of_returns() -> None:
    env = wrappers.NormalizeReward(Walk(), gamma=0.5)
    env.reset()
    results, returns = [env.step(0) for _ in range(3)], [1.0, 2.5, 4.25]
    for number, (_, reward, _, _) in enumerate(results, 1):
        count, values = number + 1e-4, np.array(returns[:number])
        mean = values.sum() / count
        variance = (((values - mean) ** 2).sum() + 1e-4 * (1 + mean**2)) / count
        assert reward == pytest.approx(number / np.sqrt(variance + 1e-8))
    assert env.returns.tolist() == [0.0]  # the episode is over


def test_normalisation_of_a_vector() -> None:
    envs: Any = gym.vector.SyncVectorEnv([Walk, Walk])
    envs = wrappers.NormalizeReward(wrappers.NormalizeObservation(envs))
    assert np.abs(envs.reset()).max() < 0.1  # all are equal
    observations, rewards, dones, _ = envs.step([0, 1])
    assert (observations.shape, rewards.shape, dones.tolist()) == ((2, 2), (2,), [False, False])
    assert envs.returns.tolist() == [1.0, 1.0]


def test_parts_of_observations() -> None:
    env = wrappers.FilterObservation(Parts(), ["b"])
    assert (str(env.observation_space), env.reset()) == ("Dict(b:Discrete(9))", {"b": 1})
    with pytest.raises(ValueError, match=r"^the observations have the parts a, b, got 'c'$"):
        wrappers.FilterObservation(Parts(), ["b", "c"])
    with pytest.raises(TypeError, match=r"^FilterObservation chooses parts of a Dict space, got Box\(2,\)$"):
        wrappers.FilterObservation(Walk())


def test_the_time_is_observed() -> None:
    env = wrappers.TimeAwareObservation(Walk())
    assert str(env.observation_space) == "Box(3,)"
    assert [env.reset().tolist(), env.step(0)[0].tolist(), env.reset().tolist()] == [[0, 1, 0], [1, -1, 1], [0, 1, 0]]


def test_images_are_observed() -> None:
    alone = wrappers.PixelObservationWrapper(Walk())
    assert str(alone.observation_space) == "Dict(pixels:Box(4, 5, 3))"
    assert list(alone.reset()) == ["pixels"]
    assert alone.step(0)[0]["pixels"].max() == 1
    both = wrappers.PixelObservationWrapper(Walk(), pixels_only=False, pixel_keys=("image",))
    assert both.reset()["state"].tolist() == [0, 1]
    assert list(both.step(0)[0]) == ["state", "image"]
    parts = wrappers.PixelObservationWrapper(Parts(), pixels_only=False)
    assert list(parts.reset()) == ["a", "b", "pixels"]
    with pytest.raises(ValueError, match=r"^the observations have a part 'a' already"):
        wrappers.PixelObservationWrapper(Parts(), pixels_only=False, pixel_keys=("a",))


def test_a_step_comes_after_a_reset() -> None:
    env = wrappers.OrderEnforcing(Walk())
    for call in (lambda: env.step(0), lambda: env.render(mode="rgb_array")):
        with pytest.raises(gym.error.ResetNeeded, match=r"came before the first reset\(\)"):
            call()
    env.reset()
    assert (env.step(0)[1], env.has_reset) == (1.0, True)


def test_five_values_and_back() -> None:
    env = wrappers.StepAPICompatibility(wrappers.TimeLimit(Walk(), 2))
    env.reset()
    assert env.step(0)[2:] == (False, False, {})
    assert env.step(0)[2:] == (False, True, {})
    modern = wrappers.EnvCompatibility(wrappers.TimeLimit(Walk(), 2), render_mode="rgb_array")
    assert modern.reset(seed=3)[0].tolist() == [0, 1]
    assert [modern.step(0)[2:4] for _ in range(2)] == [(False, False), (False, True)]
    assert modern.render().shape == (4, 5, 3)
    envs: Any = wrappers.StepAPICompatibility(gym.vector.SyncVectorEnv([lambda: wrappers.TimeLimit(Walk(), 1), Walk]))
    envs.reset()
    terminated, truncated = envs.step([0, 0])[2:4]
    assert (terminated.tolist(), truncated.tolist()) == ([False, False], [True, False])


def test_frames_are_collected_and_episodes_begin() -> None:
    env = wrappers.RenderCollection(wrappers.AutoResetWrapper(Walk()))
    env.reset()
    last = [env.step(0) for _ in range(3)][-1]
    assert (last[0].tolist(), last[2], last[3]["final_observation"].tolist()) == ([0, 1], True, [3, -3])
    assert [frame.max() for frame in env.render()] == [0, 1, 2, 0]
    assert env.render() == []


def test_infos_of_a_vector_as_a_list() -> None:
    class One(gym.vector.SyncVectorEnv):
        def step_wait(self, **options: Any) -> Any:
            *results, _ = super().step_wait(**options)
            joined: dict[str, Any] = self._add_info({}, {"n": 3}, 1)
            return *results, {**joined, "episode": {"r": [1, 2], "l": [3, 4], "t": [5, 6]}, "_episode": [True, False]}

    envs = wrappers.VectorListInfo(One([Walk, Walk]))
    envs.reset()
    assert envs.step([0, 0])[3] == [{"episode": {"r": 1, "l": 3, "t": 5}}, {"n": 3}]
    with pytest.raises(TypeError, match=r"^VectorListInfo is for vectors"):
        wrappers.VectorListInfo(Walk())


def test_actions_are_repeated() -> None:
    env = wrappers.SkipWrapper(1)(Walk())
    env.reset()
    assert env.step(0)[1:] == (3.0, False, {"skip.stepcount": 2})
    assert env.step(0)[1:] == (3.0, True, {"skip.stepcount": 3})


def test_running_moments() -> None:
    samples = np.random.default_rng(0).normal(5, 3, (1000, 2))
    moments = wrappers.normalize.RunningMeanStd(shape=(2,))
    for batch in np.split(samples, 10):
        moments.update(batch)
    np.testing.assert_allclose(moments.mean, samples.mean(axis=0), rtol=1e-5)
    np.testing.assert_allclose(moments.var, samples.var(axis=0), rtol=1e-4)
