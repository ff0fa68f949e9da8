"""The names of Gym that public scripts use (`gym_names.toml`): each is used here in the way of those scripts.

A use covers the names of its decorator. Every name that two scripts or more have is covered; `UNSUPPORTED` has the
others that are not.
"""

import copy
import json
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atari.classic as gym

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

LIST = tomllib.loads((Path(__file__).parent / "gym_names.toml").read_text(encoding="utf-8"))
COUNTS = Counter(name for scripts in LIST.values() for names in scripts.values() for name in names.split())
PAGE = Path(__file__).parents[2] / "docs" / "classic.md"

UNSUPPORTED = {
    "env.configure": "a method of Universe's environments, which no longer exist",
    "gym.monitoring.demonstrations": "a module of one fork of Gym",
    "gym.monitoring.monitor_manager": "a module of 2016, before `gym.wrappers.Monitor`",
    "gym.wrappers.monitoring._Monitor": "a private class of 2016",
}
"""Names that do not work, and why. Each occurs once."""

Use = Callable[[Path], None]
USES: dict[str, Use] = {}


def use(*names: str) -> Callable[[Use], Use]:
    def enter(function: Use) -> Use:
        assert not set(names) & set(USES), "a name has one use"
        USES.update(dict.fromkeys(names, function))
        return function

    return enter


# Loops


@use("gym.make", "env.reset", "env.step", "env.action_space", "space.sample", "env.observation_space", "env.close")
def random_episodes(_: Path) -> None:
    for env_id in ("CartPole-v0", "Breakout-v0", "Taxi-v2", "Blackjack-v0"):
        env = gym.make(env_id)
        for _ in range(2):
            observation, done, steps = env.reset(), False, 0
            while not done and steps < 20:
                assert env.observation_space.contains(observation)
                observation, reward, done, info = env.step(env.action_space.sample())
                steps += 1
                assert (float(reward), type(done), type(info)) == (reward, bool, dict)
        env.close()


@use("env.seed", "space.seed")
def seeded_episodes(_: Path) -> None:
    env = gym.make("CartPole-v0")
    for _ in range(2):
        assert env.seed(0) == [0]
        np.testing.assert_allclose(env.reset(), [-0.04456399, 0.04653909, 0.01326909, -0.02099827], atol=1e-8)
    env.action_space.seed(1)
    first = [env.action_space.sample() for _ in range(20)]
    env.action_space.seed(1)
    assert first == [env.action_space.sample() for _ in range(20)]


@use("env.render", "env.render(rgb_array)", "env.viewer", "viewer.window")
def rendering(_: Path) -> None:
    import pygame

    env = gym.make("Breakout-v0")
    env.reset()
    assert env.render(mode="rgb_array").shape == env.render("rgb_array").shape == (210, 160, 3)
    assert env.unwrapped.viewer is None
    assert env.render() is True
    pressed: list[Any] = []
    env.unwrapped.viewer.window.on_key_press = lambda key, mod: pressed.append(key)
    for key in (pygame.K_2, pygame.K_RETURN):
        pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=key, mod=0))
    env.render()
    assert pressed == [ord("2"), 0xFF0D]
    env.close()


@use("env.step([n])")
def an_action_in_a_list(_: Path) -> None:
    env, twin = gym.make("SpaceInvadersNoFrameskip-v4"), gym.make("SpaceInvadersNoFrameskip-v4")
    for each in (env, twin):
        each.seed(0)
        each.reset()
    for action in ([3], np.array([3]), np.array([[3]]), (3,)):
        np.testing.assert_array_equal(env.step(action)[0], twin.step(3)[0])


# Spaces


@use("space.n", "space.contains", "space.shape", "space.low", "space.high", "space.dtype", "gym.spaces")
def fields_of_spaces(_: Path) -> None:
    env = gym.make("Pong-v0")
    actions: Any = env.action_space
    images: Any = env.observation_space
    assert (actions.n, np.zeros(actions.n).shape, actions.contains(5), actions.contains(6)) == (6, (6,), True, False)
    assert (images.shape, images.dtype, images.low.min(), images.high.max()) == ((210, 160, 3), np.uint8, 0, 255)
    assert np.repeat(images.low, 4, axis=-1).shape == (210, 160, 12)


@use("gym.spaces.Box", "gym.spaces.box.Box", "gym.spaces.Discrete", "gym.spaces.discrete.Discrete", "gym.Space")
def classes_of_spaces(_: Path) -> None:
    assert gym.spaces.Box is gym.spaces.box.Box  # type: ignore[attr-defined]
    assert gym.spaces.Discrete is gym.spaces.discrete.Discrete  # type: ignore[attr-defined]
    assert gym.spaces.Box(0, 255, [42, 42, 1]).shape == (42, 42, 1)
    assert gym.spaces.Box(low=0, high=255, shape=(84, 84, 1)).dtype == np.float32
    assert gym.spaces.Box(np.zeros(2), np.ones(2), dtype=np.float32).shape == (2,)
    env = gym.make("CartPole-v0")
    assert type(env.action_space) is gym.spaces.Discrete
    assert type(env.observation_space) is gym.spaces.Box

    class Bits(gym.Space):  # type: ignore[type-arg]  # as a script of 2018 has it, without super().__init__()
        def __init__(self) -> None:
            self.low, self.dtype = np.zeros(3), np.uint8  # type: ignore[assignment, misc]

        @property
        def shape(self) -> Any:
            return self.low.shape

    assert isinstance(Bits(), gym.spaces.Space)
    assert Bits().shape == (3,)


@use("gym.spaces.Dict", "gym.spaces.dict_space.Dict", "gym.spaces.Tuple", "space.spaces")
def spaces_of_spaces(_: Path) -> None:
    box = gym.spaces.Box(0, 1, (2,))
    assert gym.spaces.Dict({"a": box, "b": gym.spaces.Discrete(3)}).spaces["a"] is box
    assert gym.spaces.dict_space.Dict is gym.spaces.Dict
    assert [space.n for space in gym.make("Blackjack-v0").observation_space.spaces] == [32, 11, 2]  # type: ignore[attr-defined]
    assert isinstance(gym.make("Blackjack-v0").observation_space, gym.spaces.Tuple)


@use("gym.spaces.MultiBinary", "gym.spaces.MultiDiscrete", "space.nvec")
def spaces_of_several(_: Path) -> None:
    assert gym.spaces.MultiBinary(4).n == 4
    assert gym.spaces.MultiDiscrete([3, 2]).nvec.tolist() == [3, 2]


# Attributes of environments


@use("env.unwrapped", "env.env", "env.spec", "spec.id", "env.metadata", "env.reward_range", "env.reward_range=")
def layers(_: Path) -> None:
    env = gym.Wrapper(gym.make("PongNoFrameskip-v4"))
    assert env.unwrapped is env.env.env
    assert env.spec is not None
    assert "NoFrameskip" in env.spec.id
    assert env.unwrapped.spec is env.spec
    assert "rgb_array" in env.metadata["render.modes"]
    assert env.metadata["video.frames_per_second"] > 0
    env.reward_range = (-1, 1)
    assert (env.reward_range, env.env.reward_range) == ((-1, 1), (-float("inf"), float("inf")))


@use("env.observation_space=")
def another_space(_: Path) -> None:
    env = gym.make("Pong-v0")
    env.observation_space = gym.spaces.Box(0, 1, (2,))
    env.unwrapped.observation_space = gym.spaces.Box(0, 1, (3,))
    assert (env.observation_space.shape, env.unwrapped.observation_space.shape) == ((2,), (3,))


@use("env._max_episode_steps", "env._max_episode_steps=", "env._elapsed_steps", "info[TimeLimit.truncated]")
def limits(_: Path) -> None:
    env: Any = gym.make("MountainCar-v0")
    assert (type(env).__name__, env._max_episode_steps) == ("TimeLimit", 200)
    env._max_episode_steps = 3
    env.reset()
    assert [env.step(0)[2] for _ in range(2)] == [False, False]
    assert (env._elapsed_steps, env.step(0)[2:], env._elapsed_steps) == (2, (True, {"TimeLimit.truncated": True}), 3)


@use("env.state", "env.state=", "env.MAX_VEL_1", "env.AVAIL_TORQUE")
def states_of_classic_control(_: Path) -> None:
    env: Any = gym.make("Acrobot-v1")
    env.reset()
    assert (env.env.MAX_VEL_1, list(env.env.AVAIL_TORQUE)) == (4 * np.pi, [-1.0, 0.0, 1.0])
    env.env.state = np.array([0.1, 0.0, 0.0, 0.0])
    env.step(1)
    assert 0 < env.env.state[0] < 0.1
    assert env.env.state is env.unwrapped.modern.unwrapped.state


@use("env.min_position", "env.max_position", "env.max_speed", "env.goal_position")
def constants_of_mountain_car(_: Path) -> None:
    env: Any = gym.make("MountainCar-v0").unwrapped
    assert (env.min_position, env.max_position, env.max_speed, env.goal_position) == (-1.2, 0.6, 0.07, 0.5)


@use("env.nS", "env.nA", "env.P", "env.shape")
def tables(_: Path) -> None:
    env: Any = gym.make("CliffWalking-v0")
    assert (env.nS, env.nA, env.shape) == (48, 4, (4, 12))
    lake: Any = gym.make("FrozenLake-v0")
    for env in (lake, lake.env, lake.unwrapped):
        chances = [p for p, state, reward, done in env.P[14][2]]
        assert sum(chances) == pytest.approx(1)
        assert len(chances) == 3


@use("env.s", "env.s=", "env.decode", "env.encode")
def states_of_the_taxi(_: Path) -> None:
    env: Any = gym.make("Taxi-v2")
    assert env.env.s in range(500)  # before the first reset, too
    env.reset()
    row, column, passenger, goal = env.env.decode(env.env.s)
    assert env.env.encode(row, column, passenger, goal) == env.env.s
    env.env.s = env.env.encode(0, 0, 1, 2)
    assert env.step(0)[0] == env.env.encode(1, 0, 1, 2) == env.env.s


# Subclasses


@use("gym.Env", "subclass.reset", "subclass.step", "subclass.render", "subclass.seed", "subclass.close", "gym.error")
def an_environment(_: Path) -> None:
    class Corridor(gym.Env):
        metadata = {"render.modes": ["human"]}  # noqa: RUF012
        action_space, observation_space = gym.spaces.Discrete(2), gym.spaces.Discrete(5)
        closed = False

        def reset(self) -> int:
            self.place = 0
            return self.place

        def step(self, action: int) -> Any:
            if action not in (0, 1):
                raise gym.error.Error("no such action")
            self.place += action
            return self.place, 1.0, self.place == 4, {}

        def render(self, mode: str = "human", close: bool = False) -> Any:  # type: ignore[override]
            return "." * self.place

        def seed(self, seed: int | None = None) -> list[int]:
            return [seed or 0]

        def close(self) -> None:
            self.closed = True

    env = Corridor()
    assert (env.reset(), env.step(1), env.render(), env.seed(4)) == (0, (1, 1.0, False, {}), ".", [4])
    with pytest.raises(gym.error.Error):
        env.step(7)
    env.close()
    assert env.closed


@use("subclass._reset", "subclass._step", "subclass._render", "subclass._seed", "env._render", "env._close")
def an_environment_of_2016(_: Path) -> None:
    class Corridor(gym.Env):
        action_space = observation_space = gym.spaces.Discrete(5)

        def _seed(self, seed: int | None = None) -> list[int]:
            self.np_random, seed = gym.utils.seeding.np_random(seed)
            return [seed]

        def _reset(self) -> int:
            return int(self.np_random.choice([1, 2]))

        def _step(self, action: int) -> Any:
            return action, 0.0, True, {}

        def _render(self, mode: str = "human", close: bool = False) -> Any:
            return None if close else mode

    class Around(gym.Wrapper):
        def _reset(self) -> Any:
            return -self.env.reset()

        def _render(self, mode: str = "human", close: bool = False) -> Any:
            env: Any = self.env
            return env._render(mode, close)

    env: Any = Around(Corridor())
    env.seed(0)
    assert env.reset() in (-1, -2)
    assert (env.step(3)[0], env.render("ansi"), env.render(close=True)) == (3, "ansi", None)
    cart: Any = gym.make("CartPole-v0")
    cart.reset()
    assert cart._render("rgb_array").shape == cart.env._render("rgb_array").shape == (400, 600, 3)
    cart._close()
    cart.unwrapped._close()


@use("gym.Wrapper", "gym.core.Wrapper")
def a_wrapper(_: Path) -> None:
    class Repeat(gym.Wrapper):
        def __init__(self, env: gym.Env) -> None:
            gym.Wrapper.__init__(self, env)

        def reset(self, **kwargs: Any) -> Any:
            return self.env.reset(**kwargs)

        def step(self, action: Any) -> Any:
            self.env.step(action)
            return self.env.step(action)

    assert gym.core.Wrapper is gym.Wrapper
    env: Any = Repeat(gym.make("CartPole-v0"))
    env.reset()
    env.step(1)
    assert env.env._elapsed_steps == 2


@use("gym.ObservationWrapper", "subclass.observation", "subclass._observation", "gym.RewardWrapper", "subclass.reward")
def wrappers_of_parts(_: Path) -> None:
    class Gray(gym.ObservationWrapper):
        def observation(self, observation: Any) -> Any:
            return observation.mean(axis=2)

    class Half(gym.ObservationWrapper):
        def _observation(self, observation: Any) -> Any:
            return observation[::2, ::2]

    class Sign(gym.RewardWrapper):
        def reward(self, reward: Any) -> Any:
            return np.sign(reward)

    env = Sign(Half(Gray(gym.make("Pong-v0"))))
    assert env.reset().shape == env.step(0)[0].shape == (105, 80)


@use("gym.ActionWrapper", "subclass.action", "subclass._reward")
def more_wrappers_of_parts(_: Path) -> None:
    class Minus(gym.RewardWrapper):
        def _reward(self, reward: Any) -> Any:
            return -reward

    class Fixed(gym.ActionWrapper):
        def action(self, action: Any) -> Any:
            return 0

    env = Minus(Fixed(gym.make("CartPole-v0")))
    env.reset()
    assert env.step("anything")[1] == -1.0


@use("gym.utils", "gym.utils.seeding", "gym.utils.seeding.np_random", "np_random.choice")
def generators(_: Path) -> None:
    rng, seed = gym.utils.seeding.np_random(5)
    assert seed == 5
    assert rng.choice([10]) == 10
    assert rng.randint(3) in range(3)
    assert 0 <= rng.rand() < 1


@use("gym.envs.toy_text.discrete.DiscreteEnv")
def a_table_of_transitions(_: Path) -> None:
    class Two(gym.envs.toy_text.discrete.DiscreteEnv):
        def __init__(self) -> None:
            moves = {s: {a: [(1.0, a, float(a), a == 1)] for a in range(2)} for s in range(2)}
            super().__init__(2, 2, moves, [1.0, 0.0])

        def _render(self, mode: str = "human", close: bool = False) -> Any:
            return f"{self.s} of {self.nS}"

        def _reset(self) -> int:
            return 10 + super()._reset()

    env = Two()
    assert (env.reset(), env.step(1), env.render()) == (10, (1, 1.0, True, {"prob": 1.0}), "1 of 2")


# Classes of environments


@use("gym.envs.classic_control.CartPoleEnv", "gym.envs.classic_control.cartpole.CartPoleEnv")
def a_cart_pole_of_ones_own(_: Path) -> None:
    class Moon(gym.envs.classic_control.CartPoleEnv):
        def __init__(self) -> None:
            super().__init__()
            self.gravity = 1.6

        def step(self, action: Any) -> Any:
            observation, reward, done, info = super().step(action)
            return observation, reward - 1, done, info

    assert gym.envs.classic_control.cartpole.CartPoleEnv is gym.envs.classic_control.CartPoleEnv
    earth, moon = gym.envs.classic_control.CartPoleEnv(), Moon()
    for env in (earth, moon):
        env.seed(0)
        env.reset()
    assert moon.step(0)[1] == 0.0
    assert (moon.state != earth.step(0)[0]).any()
    assert moon.modern.unwrapped.gravity == 1.6


@use("env.x_threshold", "env.theta_threshold_radians")
def thresholds_of_cart_pole(_: Path) -> None:
    env = gym.envs.classic_control.CartPoleEnv()
    assert (env.x_threshold, round(env.theta_threshold_radians, 3)) == (2.4, 0.209)


@use("gym.envs.toy_text.frozen_lake", "gym.envs.toy_text.frozen_lake.FrozenLakeEnv", "gym.wrappers.TimeLimit")
def a_lake_without_an_id(_: Path) -> None:
    env: gym.Env = gym.envs.toy_text.frozen_lake.FrozenLakeEnv(is_slippery=False)
    env = gym.wrappers.TimeLimit(env, max_episode_steps=2)
    env.reset()
    assert [env.step(2)[:3] for _ in range(2)] == [(1, 0, False), (2, 0, True)]


@use("gym.envs.registration.register", "entry_point:gym.envs.toy_text:FrozenLakeEnv", "gym.register")
def a_lake_that_is_not_slippery(_: Path) -> None:
    for number, register in enumerate((gym.envs.registration.register, gym.register)):
        register(
            id=f"FrozenLakeNotSlippery-v{number}",
            entry_point="gym.envs.toy_text:FrozenLakeEnv",
            kwargs={"map_name": "4x4", "is_slippery": False},
            max_episode_steps=100,
            reward_threshold=0.78,
        )
        env = gym.make(f"FrozenLakeNotSlippery-v{number}")
        env.reset()
        path = [env.step(action)[:3] for action in (1, 1, 2, 1, 2, 2)]
        assert path[-1] == (15, 1, True)
        assert env.spec is not None
        assert env.spec.reward_threshold == 0.78


# Atari


@use("env.get_action_meanings", "env.get_keys_to_action", "env._action_set")
def actions_of_games(_: Path) -> None:
    env: Any = gym.make("Pong-v0").unwrapped
    assert env.get_action_meanings()[:2] == ["NOOP", "FIRE"]
    assert env.get_keys_to_action() == {(): 0, (32,): 1, (100,): 2, (97,): 3, (32, 100): 4, (32, 97): 5}
    assert [int(env._action_set[a]) for a in range(3)] == [0, 1, 3]


@use("env.ale", "ale.lives", "ale.getRAM", "ale.act", "ale.getScreenGrayscale", "ale.saveScreenPNG")
def the_emulator(folder: Path) -> None:
    env: Any = gym.make("BreakoutNoFrameskip-v4")
    env.reset()
    gray = np.empty((210, 160), np.uint8)
    env.env.ale.getScreenGrayscale(gray)
    assert (env.ale.lives(), env.unwrapped.ale.getRAM().shape, gray.max() > 0) == (5, (128,), True)
    before = env.unwrapped.ale.getRAM()
    env.unwrapped.ale.act(env.unwrapped._action_set[1])
    assert (env.unwrapped.ale.getRAM() != before).any()
    env.ale.saveScreenPNG(str(folder / "screen.png").encode())
    assert (folder / "screen.png").stat().st_size > 100


@use("env.np_random", "env.np_random.randint", "env.np_random.uniform")
def the_generator_of_a_game(_: Path) -> None:
    """The no-op wrapper and the sticky actions of Baselines draw from it, and a seed repeats what they drew."""
    env: Any = gym.make("FreewayNoFrameskip-v4")
    assert env.unwrapped.np_random.randint(1, 31) in range(1, 31)
    draws = []
    for _ in range(2):
        env.seed(3)
        draws.append((env.unwrapped.np_random.randint(1, 31), env.np_random.uniform()))
    assert draws[0] == draws[1]
    expected = gym.utils.seeding.np_random(3)[0]
    assert draws[0] == (expected.randint(1, 31), expected.uniform())
    kept = copy.deepcopy(env.unwrapped.np_random)
    assert kept.uniform() == env.unwrapped.np_random.uniform()


@use("gym.envs.atari.AtariEnv", "gym.envs.atari.atari_env.AtariEnv", "obs_type=image")
def the_class_of_games(_: Path) -> None:
    assert gym.envs.atari.atari_env.AtariEnv is gym.envs.atari.AtariEnv
    made = {env_id: gym.make(env_id).unwrapped for env_id in ("PongNoFrameskip-v4", "ALE/Pong-v5", "CartPole-v1")}
    assert hasattr(gym.envs, "atari")
    assert [isinstance(env, gym.envs.atari.AtariEnv) for env in made.values()] == [True, True, False]
    env = gym.envs.atari.AtariEnv(game="ms_pacman", obs_type="image", frameskip=5)
    assert (env.reset().shape, env.spec, env.step(0)[3]["frame_number"]) == ((210, 160, 3), None, 5)
    assert gym.make("Pong-v0", obs_type="image").reset().shape == (210, 160, 3)


@use("env.clone_full_state", "env.restore_full_state", "env.restore_state", "env._get_image")
def states_of_games(_: Path) -> None:
    env: Any = gym.make("Breakout-v0").unwrapped
    env.reset()
    env.step(1)
    for clone, restore in ((env.clone_full_state, env.restore_full_state), (env.clone_state, env.restore_state)):
        state, image = clone(), env._get_image()
        env.step(2)
        assert (env._get_image() != image).any()
        restore(state)
        np.testing.assert_array_equal(env._get_image(), image)


@use("env.frameskip=")
def frames_of_a_step(_: Path) -> None:
    env: Any = gym.make("PongDeterministic-v4")
    env.unwrapped.frameskip = 1
    env.reset()
    assert [env.step(0)[3]["episode_frame_number"] for _ in range(3)] == [1, 2, 3]


@use("info[ale.lives]", "info[lives]")
def lives_in_the_info(_: Path) -> None:
    env = gym.make("SpaceInvaders-v0")
    env.reset()
    info = env.step(0)[3]
    assert info["ale.lives"] == info["lives"] == 3


# Registry


@use("gym.spec", "gym.envs.make", "spec.tags", "spec.timestep_limit", "spec.max_episode_steps", "spec.reward_threshold")
def specs(_: Path) -> None:
    spec = gym.spec("CartPole-v0")
    assert (spec.timestep_limit, spec.max_episode_steps, spec.reward_threshold) == (200, 200, 195.0)
    assert spec.tags.get("wrapper_config.TimeLimit.max_episode_steps") == 200
    assert not spec.tags.get("atari", False)
    assert gym.envs.make("CartPole-v0").spec == spec


@use("gym.envs.registry.all", "gym.envs.registry.env_specs", "spec._entry_point")
def kinds_of_environments(_: Path) -> None:
    """Baselines finds the kind of an environment by the module of its class."""
    kinds = {spec.id: str(spec._entry_point).split(":")[0].split(".")[-1] for spec in gym.envs.registry.all()}
    ids = ("PongNoFrameskip-v4", "Breakout-ram-v0", "CartPole-v0", "Acrobot-v1", "FrozenLake-v1")
    assert [kinds[env_id] for env_id in ids] == ["atari", "atari", *["classic_control"] * 2, "toy_text"]
    assert "Pong-v0" in gym.envs.registry.env_specs
    assert "Pong-v9" not in gym.envs.registry.env_specs


@use("gym.envs.registration.load", "spec.entry_point", "spec._kwargs", "spec.nondeterministic")
def classes_of_specs(_: Path) -> None:
    for env_id in ("PongNoFrameskip-v4", "Pong-ram-v0", "MountainCar-v0", "FrozenLake8x8-v1"):
        spec: Any = gym.envs.registry.env_specs[env_id]
        env = gym.envs.registration.load(spec.entry_point)(**spec._kwargs)
        made = gym.make(env_id)
        assert type(env) is type(made.unwrapped)
        assert spec.nondeterministic is False
        assert env.observation_space == made.observation_space
        assert env.action_space == made.action_space


@use("gym.benchmark_spec", "benchmark.tasks", "task.env_id", "task.max_timesteps")
def benchmarks(_: Path) -> None:
    task = gym.benchmark_spec("Atari40M").tasks[3]
    assert (task.env_id, task.max_timesteps) == ("PongNoFrameskip-v4", 40_000_000)
    assert gym.make(gym.benchmark_spec("Atari200M").tasks[1].env_id).action_space.n == 4  # type: ignore[attr-defined]


@use("gym.undo_logger_setup", "gym.version.VERSION", "gym.upload", "gym.logger.set_level", "gym.logger.setLevel")
def the_package(_: Path) -> None:
    level = gym.logger.INFO
    gym.undo_logger_setup()
    assert gym.version.VERSION == gym.__version__ < "0.22"
    gym.upload("results", algorithm_id="random")
    for name in ("set_level", "setLevel"):
        getattr(gym.logger, name)(level)
    gym.logger.set_level(30)


@use("gym.logger.INFO")
def levels(_: Path) -> None:
    assert gym.logger.DEBUG < gym.logger.INFO < gym.logger.WARN < gym.logger.ERROR


# Recorders


@use("gym.wrappers.Monitor", "monitor.get_total_steps", "monitor.stats_recorder.done=")
def a_monitor(folder: Path) -> None:
    env = gym.wrappers.Monitor(gym.make("CartPole-v0"), str(folder), video_callable=lambda episode: episode == 1)
    for _ in range(2):
        env.reset()
        while not env.step(env.action_space.sample())[2]:
            pass
    env.reset()
    env.step(0)
    env.stats_recorder.done = True
    env.reset()
    assert env.get_total_steps() == sum(env.get_episode_lengths())
    env.close()
    (stats,) = folder.glob("*.stats.json")
    assert len(json.loads(stats.read_text())["episode_lengths"]) == 3
    assert len(list(folder.glob("*.mp4"))) == 1


@use("env.monitor.start", "env.monitor.close")
def a_monitor_of_2016(folder: Path) -> None:
    env = gym.make("CartPole-v0")
    env.monitor.start(str(folder), force=True, seed=0, video_callable=lambda episode: False)
    env.reset()
    while not env.step(0)[2]:
        pass
    env.monitor.close()
    assert len(list(folder.glob("*.stats.json"))) == 1


@use("gym.wrappers.RecordVideo")
def a_recorder_of_videos(folder: Path) -> None:
    env = gym.wrappers.RecordVideo(gym.make("CartPole-v0"), str(folder))
    env.reset()
    while not env.step(0)[2]:
        pass
    env.close()
    assert sorted(file.name for file in folder.iterdir()) == ["rl-video-episode-0.meta.json", "rl-video-episode-0.mp4"]


@use("gym.envs.classic_control.rendering.SimpleImageViewer", "viewer.imshow")
def a_window_for_images(_: Path) -> None:
    from atari.classic.envs.classic_control import rendering

    viewer = rendering.SimpleImageViewer()
    viewer.imshow(np.zeros((210, 160, 3), np.uint8))
    assert viewer.isopen
    viewer.close()
    assert not viewer.isopen


@use("gym.utils.play.play")
def play(_: Path) -> None:
    """`test_play.py` plays."""
    from atari.classic.utils.play import play as function

    assert callable(function)


# Gym's last years


@use(
    "gym.wrappers.RecordEpisodeStatistics",
    "gym.wrappers.ResizeObservation",
    "gym.wrappers.GrayScaleObservation",
    "gym.wrappers.FrameStack",
    "gym.wrappers.time_limit.TimeLimit",
    "info[episode]",
)
def cleanrls_wrappers(_: Path) -> None:
    env: gym.Env = gym.make("BreakoutNoFrameskip-v4")
    assert isinstance(env, gym.wrappers.time_limit.TimeLimit)
    env._max_episode_steps = 5
    env = gym.wrappers.RecordEpisodeStatistics(env)
    env = gym.wrappers.ResizeObservation(env, (84, 84))
    env = gym.wrappers.GrayScaleObservation(env)
    env = gym.wrappers.FrameStack(env, 4)
    assert np.array(env.reset()).shape == (4, 84, 84)
    results = [env.step(0) for _ in range(5)]
    assert results[-1][2]
    assert results[-1][3]["episode"]["l"] == 5


@use("gym.wrappers.FlattenDictWrapper")
def a_flat_dictionary(_: Path) -> None:
    class Reach(gym.Env):
        action_space = gym.spaces.Discrete(2)
        observation_space = gym.spaces.Dict(
            {"observation": gym.spaces.Box(0, 9, (2,)), "desired_goal": gym.spaces.Box(0, 9, (3,))}
        )

        def reset(self) -> Any:
            return {"observation": np.ones(2), "desired_goal": np.zeros(3)}

    env = gym.wrappers.FlattenDictWrapper(Reach(), ["observation", "desired_goal"])
    assert (env.observation_space.shape, env.reset().tolist()) == ((5,), [1, 1, 0, 0, 0])


@use("gym.wrappers.normalize.RunningMeanStd")
def running_moments(_: Path) -> None:
    samples = np.random.default_rng(0).normal(5, 3, (1000, 2))
    moments = gym.wrappers.normalize.RunningMeanStd(shape=(2,))
    for batch in np.split(samples, 10):
        moments.update(batch)
    np.testing.assert_allclose(moments.mean, samples.mean(axis=0), rtol=1e-5)
    np.testing.assert_allclose(moments.var, samples.var(axis=0), rtol=1e-4)


@use(
    "gym.vector.SyncVectorEnv",
    "vector.single_action_space",
    "vector.single_observation_space",
    "vector.num_envs",
    "vector.reset",
    "vector.step",
    "vector.close",
    "info[terminal_observation]",
)
def a_vector(_: Path) -> None:
    envs = gym.vector.SyncVectorEnv([lambda: gym.make("CartPole-v1")] * 3)
    assert isinstance(envs.single_action_space, gym.spaces.Discrete)
    assert envs.single_observation_space.shape == (4,)
    assert envs.reset().shape == (3, 4)
    ends = 0
    for _ in range(30):
        before, rewards, dones, infos = envs.step(np.zeros(envs.num_envs, int))
        for i in np.flatnonzero(dones):
            assert (infos[i]["terminal_observation"] != before[i]).all()
            ends += 1
    assert ends >= 3
    assert rewards.tolist() == [1.0, 1.0, 1.0]
    envs.close()


@use("np.bool", "np.int", "np.cast")
def removed_names_of_numpy(folder: Path) -> None:
    script = folder / "script.py"
    script.write_text(
        "import numpy as np\nprint(np.zeros(1, np.bool), np.array([1.5]).astype(np.int), np.cast[np.uint8](3.5))"
    )
    result = subprocess.run([sys.executable, "-m", "atari.classic", str(script)], capture_output=True, text=True)
    assert result.stdout == "[False] [1] 3\n", result.stderr


# The list


@pytest.mark.parametrize("function", dict.fromkeys(USES.values()), ids=lambda function: function.__name__)
def test_names_are_used_as_in_scripts(function: Use, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    function(tmp_path)


def test_every_name_that_occurs_twice_has_a_use() -> None:
    assert {name for name, count in COUNTS.items() if count > 1} <= set(USES)


def test_every_other_name_has_a_use_or_a_reason() -> None:
    assert set(COUNTS) - set(USES) == set(UNSUPPORTED)
    assert not set(USES) - set(COUNTS), "take a use of what no script has out"


def test_the_page_has_the_numbers_of_the_list() -> None:
    scripts, uses = sum(map(len, LIST.values())), sum(COUNTS.values())
    supported = sum(count for name, count in COUNTS.items() if name in USES)
    page = re.sub(r"\s+", " ", PAGE.read_text(encoding="utf-8"))
    assert f"{scripts} public scripts" in page
    assert f"{len(COUNTS)} names" in page
    assert f"{supported:,} of their {uses:,} uses" in page
