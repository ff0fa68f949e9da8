"""Environments of a user's own, old style and new style, made through either interface."""

import copy
import pickle
import random
import warnings
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from env_tools import needs_gymnasium_1
from gymnasium.utils.env_checker import check_env

import atari.classic as gym
from atari.classic.modern import EntryPoint, Modern


class OldCorridor(gym.Env):
    """Old style: walk to the right end from a random start."""

    metadata = {"render.modes": ["human", "ansi", "rgb_array"], "video.frames_per_second": 12}  # noqa: RUF012

    def __init__(self, length: int = 5) -> None:
        self.length = length
        self.action_space = gym.spaces.Discrete(2)
        self.observation_space = gym.spaces.Box(low=0, high=100, shape=(1,), dtype=np.float32)
        self.closed = False
        self.random = random.Random()

    def seed(self, seed: int | None = None) -> list[int]:
        self.random = random.Random(seed)
        return [] if seed is None else [seed]

    def reset(self) -> Any:
        self.place = self.random.randrange(2)
        return [self.place]

    def step(self, action: int) -> Any:
        self.place = max(0, self.place + (1 if action else -1))
        done = self.place == self.length
        return [self.place], int(done), done, {"place": self.place}

    def render(self, mode: str = "human", close: bool = False) -> Any:  # type: ignore[override]
        if mode == "rgb_array":
            image = np.zeros((8, 8 * self.length + 8, 3), np.uint8)
            image[:, 8 * self.place : 8 * self.place + 8] = 255
            return image
        text = "." * self.place + "X"
        return print(text) if mode == "human" else text

    def close(self) -> None:
        self.closed = True


class Corridor2016(gym.Env):
    """The same, as it was written before 2018."""

    metadata = {"render.modes": ["human"]}  # noqa: RUF012
    action_space = gym.spaces.Discrete(2)
    observation_space = gym.spaces.Discrete(6)

    def __init__(self) -> None:
        self.seeds: list[int] = []
        self._seed()

    def _seed(self, seed: int | None = None) -> list[int]:
        self.random = random.Random(seed)
        if seed is not None:
            self.seeds.append(seed)
        return self.seeds

    def _reset(self) -> int:
        self.place = self.random.randrange(2)
        return self.place

    def _step(self, action: int) -> Any:
        self.place = max(0, self.place + (1 if action else -1))
        return self.place, float(self.place == 5), self.place == 5, {}

    def _render(self, mode: str = "human", close: bool = False) -> None:
        if not close:
            print(f"at {self.place}")


class NewCorridor(gymnasium.Env[Any, Any]):
    """New style."""

    metadata = {"render_modes": ["ansi"], "render_fps": 5}  # noqa: RUF012

    def __init__(self, length: int = 5, render_mode: str | None = None) -> None:
        self.length = length
        self.render_mode = render_mode
        self.action_space = gymnasium.spaces.Discrete(2)
        self.observation_space = gymnasium.spaces.Discrete(length + 1)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        super().reset(seed=seed)
        self.place = int(self.np_random.integers(2))
        return self.place, {}

    def step(self, action: Any) -> Any:
        self.place = max(0, self.place + (1 if action else -1))
        return self.place, float(self.place == self.length), self.place == self.length, False, {}

    def render(self) -> Any:
        return "." * self.place + "X"


class Wrong(gym.Env):
    """Returns the results that its constructor gets."""

    action_space = gym.spaces.Discrete(2)
    observation_space = gym.spaces.Discrete(2)

    def __init__(self, reset: Any = 0, step: Any = (0, 0.0, False, {})) -> None:
        self.returns = reset, step

    def reset(self) -> Any:
        return self.returns[0]

    def step(self, action: Any) -> Any:
        return self.returns[1]


IDS = {"OldCorridor-v0": OldCorridor, "Corridor2016-v0": Corridor2016, "NewCorridor-v0": NewCorridor}


@pytest.fixture(autouse=True)
def registered() -> Any:
    for env_id, kind in {**IDS, "Wrong-v0": Wrong}.items():
        gym.register(id=env_id, entry_point=kind, max_episode_steps=20)
    yield
    for env_id in (*IDS, "Wrong-v0"):
        del gym.envs.registry.env_specs[env_id]


# Through the old interface


@pytest.mark.parametrize("env_id", IDS)
def test_each_style_plays_through_the_old_interface(env_id: str) -> None:
    env = gym.make(env_id)
    env.seed(0)
    assert env.reset() in (0, 1, [0], [1])
    results = [env.step(1) for _ in range(5 if env.unwrapped.place == 0 else 4)]  # type: ignore[attr-defined]
    assert [result[2] for result in results] == [False] * (len(results) - 1) + [True]
    assert results[-1][0] in (5, [5])
    assert results[-1][1] == 1
    assert "TimeLimit.truncated" not in results[-1][3]


@pytest.mark.parametrize("env_id", IDS)
def test_the_time_limit_counts_in_the_old_interface(env_id: str) -> None:
    env = gym.make(env_id)
    env.reset()
    results = [env.step(0) for _ in range(20)]
    assert [result[2] for result in results] == [False] * 19 + [True]
    assert results[-1][3]["TimeLimit.truncated"] is True


def test_the_object_inside_is_the_users_own() -> None:
    env = gym.make("OldCorridor-v0", length=7)
    assert isinstance(env.unwrapped, OldCorridor)
    assert env.unwrapped.length == 7
    env.close()
    assert env.unwrapped.closed


def test_rendering_in_the_old_interface(capsys: pytest.CaptureFixture[str]) -> None:
    for env_id, shown in (("OldCorridor-v0", ".X"), ("Corridor2016-v0", "at 1"), ("NewCorridor-v0", ".X")):
        env = gym.make(env_id)
        env.reset()
        for action in (0, 1, 0, 1):
            env.step(action)
        env.render()
        assert capsys.readouterr().out == f"{shown}\n"


# Through Gymnasium


@pytest.mark.parametrize("env_id", IDS)
def test_each_style_plays_through_gymnasium(env_id: str) -> None:
    env = gymnasium.make(env_id)
    first, info = env.reset(seed=0)
    assert info == {}
    assert env.observation_space.contains(first)
    while not (result := env.step(1))[2]:
        assert result[1:4] == (0.0, False, False)
    assert result[0] == 5
    assert result[1:4] == (1.0, True, False)
    assert isinstance(result[1], float)


@pytest.mark.parametrize("env_id", IDS)
def test_the_time_limit_truncates_in_gymnasium(env_id: str) -> None:
    env = gymnasium.make(env_id)
    env.reset()
    results = [env.step(0)[2:4] for _ in range(20)]
    assert results == [(False, False)] * 19 + [(False, True)]


def test_a_limit_of_the_environments_own_truncates_too() -> None:
    env = gymnasium.make("Wrong-v0", step=(0, 0.0, True, {"TimeLimit.truncated": True}))
    env.reset()
    assert env.step(0)[2:4] == (False, True)


@pytest.mark.parametrize("env_id", IDS)
def test_gymnasiums_checker_passes(env_id: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(env_id).unwrapped)


def test_the_seed_goes_to_the_seed_method() -> None:
    env = gymnasium.make("Corridor2016-v0")
    env.reset(seed=5)
    env.reset()
    assert env.unwrapped.seeds == [5]  # type: ignore[attr-defined]
    places = []
    for _ in range(2):
        places.append([env.reset(seed=6)[0]] + [env.reset()[0] for _ in range(30)])
    assert places[0] == places[1]
    assert set(places[0]) == {0, 1}


def test_lists_become_arrays_of_the_box() -> None:
    observation = gymnasium.make("OldCorridor-v0").reset()[0]
    assert isinstance(observation, np.ndarray)
    assert (observation.dtype, observation.shape) == (np.float32, (1,))


@needs_gymnasium_1
@pytest.mark.parametrize("mode", ["sync", "async"])
@pytest.mark.parametrize("env_id", IDS)
def test_vector_environments(env_id: str, mode: Any) -> None:
    envs = gymnasium.make_vec(env_id, num_envs=3, vectorization_mode=mode)
    single = gymnasium.make(env_id)
    firsts, _ = envs.reset(seed=10)
    assert firsts.ravel().tolist() == [np.ravel(single.reset(seed=10 + index)[0])[0] for index in range(3)]
    for _ in range(20):
        observations, rewards, terminations, truncations, _ = envs.step(np.zeros(3, int))
    assert observations.ravel().tolist() == rewards.tolist() == [0, 0, 0]
    assert truncations.all()
    assert not terminations.any()
    envs.close()


def test_wrappers_of_gymnasium() -> None:
    env = gymnasium.make("OldCorridor-v0", render_mode="rgb_array_list")
    env = gymnasium.wrappers.RecordEpisodeStatistics(env)
    env = gymnasium.wrappers.FrameStackObservation(env, 2)
    env = gymnasium.wrappers.TransformReward(env, lambda reward: 10 * float(reward))
    env.reset(seed=0)
    steps = 0
    while True:
        observation, reward, terminated, _, info = env.step(1)
        steps += 1
        if terminated:
            break
    assert observation.tolist() == [[4.0], [5.0]]
    assert reward == 10
    assert (info["episode"]["r"], info["episode"]["l"], info["place"]) == (1, steps, 5)
    images: Any = env.render()
    assert len(images) == steps + 1
    assert images[-1][0, :, 0].tolist() == [0] * 40 + [255] * 8


def test_metadata_is_in_gymnasiums_words() -> None:
    env = gymnasium.make("OldCorridor-v0")
    assert env.metadata == {"render_modes": ["human", "ansi", "rgb_array"], "render_fps": 12}


def test_rendering_through_gymnasium(capsys: pytest.CaptureFixture[str]) -> None:
    env = gymnasium.make("OldCorridor-v0", render_mode="ansi")
    env.reset(seed=0)
    env.step(0)
    env.step(0)
    assert env.render() == "X"
    env = gymnasium.make("OldCorridor-v0", render_mode="human")
    env.reset(seed=0)
    env.step(0)
    env.step(0)
    assert env.render() is None
    assert capsys.readouterr().out.splitlines()[1:] == ["X", "X"]


def test_a_render_without_mode_is_called_without() -> None:
    class Plain(OldCorridor):
        metadata = {"render.modes": ["ansi"]}  # noqa: RUF012

        def render(self) -> str:  # type: ignore[override]
            return "plain"

    env = Modern(Plain(), "ansi")
    env.reset()
    assert env.render() == "plain"


def test_attributes_and_close_reach_the_environment() -> None:
    env = gymnasium.make("OldCorridor-v0", length=9)
    assert env.get_wrapper_attr("length") == 9
    env.reset()
    env.close()
    inside = env.unwrapped
    assert isinstance(inside, Modern)
    assert isinstance(inside.classic, OldCorridor)
    assert inside.classic.closed
    with pytest.raises(AttributeError, match="'OldCorridor' object has no attribute 'width'"):
        _ = inside.width


def test_copies_and_pickles() -> None:
    env = gymnasium.make("Corridor2016-v0")
    place = env.reset(seed=0)[0]
    other: Any
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env.unwrapped))):
        assert other.unwrapped.place == place
        assert other.step(1)[0] == place + 1
    assert env.unwrapped.place == place  # type: ignore[attr-defined]


def test_an_entry_point_may_be_a_function() -> None:
    for entry_point in (lambda: OldCorridor(8), lambda render_mode=None: NewCorridor(8, render_mode)):
        gym.register(id="Function-v0", entry_point=entry_point)
        env = gymnasium.make("Function-v0", render_mode="ansi")
        assert env.unwrapped.length == 8  # type: ignore[attr-defined]
        env.reset(seed=0)
        env.step(0)
        env.step(0)
        assert env.render() == "X"
        del gym.envs.registry.env_specs["Function-v0"]


# Mistakes


@pytest.mark.parametrize(
    ("step", "text"),
    [
        ((0, 0.0, False, False, {}), "returned five values, as in Gymnasium; return `terminated or truncated` as done"),
        ((0, 0.0, {}), "returned 3 values"),
        ((0, 0.0, None, {}), "done is None"),
        ((0, 0.0, "no", {}), "done is 'no'"),
        ((0, 0.0, {}, False), "done is {}"),
        ((0, 0.0, False, None), "info is None"),
        (None, "returned nothing"),
        ([0, 0.0, False, {}], "returned a list"),
    ],
)
def test_a_wrong_step_raises_in_both_interfaces(step: Any, text: str) -> None:
    for make in (gym.make, gymnasium.make):
        env: Any = make("Wrong-v0", step=step)
        env.reset()
        with pytest.raises(TypeError) as error:
            env.step(0)
        assert "Wrong.step() must return observation, reward, done, info" in str(error.value)
        assert text in str(error.value)


@pytest.mark.parametrize(
    ("reset", "text"), [((0, {}), r"returned \(observation, info\), as in Gymnasium"), (None, "returned nothing")]
)
def test_a_wrong_reset_raises_in_both_interfaces(reset: Any, text: str) -> None:
    for make in (gym.make, gymnasium.make):
        env: Any = make("Wrong-v0", reset=reset)
        with pytest.raises(TypeError, match=rf"Wrong.reset\(\) {text}"):
            env.reset()


class Mixed(gymnasium.Env[Any, Any]):
    def reset(self) -> int:  # type: ignore[override]
        return 0


class Spaceless(gym.Env):
    pass


@pytest.mark.parametrize(
    ("call", "kind", "text"),
    [
        (EntryPoint(Mixed), TypeError, r"Mixed derives from gymnasium.Env, but its reset\(\) takes no `seed`"),
        (EntryPoint(Spaceless), TypeError, "Spaceless has no action_space; set self.action_space to a space"),
        (EntryPoint("fractions:Fraction"), TypeError, "Fraction is no environment; derive the class from Env"),
        (
            lambda: EntryPoint(lambda: NewCorridor())(render_mode="ansi"),
            TypeError,
            "the entry point of this NewCorridor has no parameter render_mode; give it one",
        ),
        (lambda: Modern(Corridor2016(), "x"), gymnasium.error.UnsupportedMode, r"modes \['human'\], got 'x'"),
        (lambda: Modern(OldCorridor()).render(), gymnasium.error.Error, r"render\(\) needs a render mode"),
        (
            lambda: gym.register("Unknown-v0", OldCorridor, lenght=3),
            TypeError,
            r"^register\(\) has no option 'lenght'; options of the class go into kwargs=",
        ),
    ],
)
def test_a_mistake_is_named(call: Callable[[], Any], kind: type[Exception], text: str) -> None:
    with pytest.raises(kind, match=text):
        call()


def test_step_before_reset_and_a_wrong_action() -> None:
    env = Modern(OldCorridor())
    with pytest.raises(gymnasium.error.ResetNeeded, match=r"call env.reset\(\) first"):
        env.step(0)
    env.reset()
    with pytest.raises(ValueError, match=r"the action 2 is not within 0\.\.1"):
        env.step(2)
    with pytest.raises(TypeError, match=r"an action is an integer within 0\.\.1, got 'left'"):
        env.step("left")


def test_numbers_beyond_a_box_are_the_environments_to_clip() -> None:
    class Push(Wrong):
        def __init__(self) -> None:
            super().__init__()
            self.action_space: Any = gym.spaces.Box(low=-1, high=1, shape=(2,))

        def step(self, action: Any) -> Any:
            self.pushed = action
            return 0, 0.0, False, {}

    push = Push()
    env = Modern(push)
    env.reset()
    env.step([1.5, -3])
    assert (push.pushed.tolist(), push.pushed.dtype) == ([1.5, -3], np.float32)
    with pytest.raises(ValueError, match=r"an action is an array of shape \(2,\), got one of shape \(3,\)"):
        env.step([0, 0, 0])


def test_options_of_register() -> None:
    gym.register("Known-v0", OldCorridor, trials=100, local_only=True, kwargs={"length": 3})
    assert gym.make("Known-v0").unwrapped.length == 3  # type: ignore[attr-defined]


class Late(gym.Wrapper):
    def step(self, action: Any) -> Any:
        return ("step", action)


class Later(Late):
    def _step(self, action: Any) -> Any:
        return ("_step", action)


def test_an_old_name_replaces_an_inherited_method() -> None:
    assert Later(OldCorridor()).step(1) == ("_step", 1)

    class Fixed(OldCorridor):
        def _reset(self) -> Any:
            return [7]

    assert Fixed().reset() == [7]
