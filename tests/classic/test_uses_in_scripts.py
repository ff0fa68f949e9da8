"""What public scripts of 2016 to 2021 do with Gym, each in the way of those scripts.

`tests/interfaces` compares the names; these tests compare what they do.
"""

import copy
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atari.classic as gym


@pytest.fixture(autouse=True)
def _no_window(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


# Loops


def test_random_episodes() -> None:
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


def test_seeded_episodes() -> None:
    env = gym.make("CartPole-v0")
    for _ in range(2):
        assert env.seed(0) == [0]
        np.testing.assert_allclose(env.reset(), [-0.04456399, 0.04653909, 0.01326909, -0.02099827], atol=1e-8)
    env.action_space.seed(1)
    first = [env.action_space.sample() for _ in range(20)]
    env.action_space.seed(1)
    assert first == [env.action_space.sample() for _ in range(20)]


def test_rendering() -> None:
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


def test_an_action_in_a_list() -> None:
    env, twin = gym.make("SpaceInvadersNoFrameskip-v4"), gym.make("SpaceInvadersNoFrameskip-v4")
    for each in (env, twin):
        each.seed(0)
        each.reset()
    for action in ([3], np.array([3]), np.array([[3]]), (3,)):
        np.testing.assert_array_equal(env.step(action)[0], twin.step(3)[0])


# Spaces


def test_fields_of_spaces() -> None:
    env = gym.make("Pong-v0")
    actions: Any = env.action_space
    images: Any = env.observation_space
    assert (actions.n, np.zeros(actions.n).shape, actions.contains(5), actions.contains(6)) == (6, (6,), True, False)
    assert (images.shape, images.dtype, images.low.min(), images.high.max()) == ((210, 160, 3), np.uint8, 0, 255)
    assert np.repeat(images.low, 4, axis=-1).shape == (210, 160, 12)


def test_classes_of_spaces() -> None:
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


def test_spaces_of_spaces() -> None:
    box = gym.spaces.Box(0, 1, (2,))
    assert gym.spaces.Dict({"a": box, "b": gym.spaces.Discrete(3)}).spaces["a"] is box
    assert gym.spaces.dict_space.Dict is gym.spaces.Dict
    assert [space.n for space in gym.make("Blackjack-v0").observation_space.spaces] == [32, 11, 2]  # type: ignore[attr-defined]
    assert isinstance(gym.make("Blackjack-v0").observation_space, gym.spaces.Tuple)


def test_spaces_of_several() -> None:
    assert gym.spaces.MultiBinary(4).n == 4
    assert gym.spaces.MultiDiscrete([3, 2]).nvec.tolist() == [3, 2]


# Attributes of environments


def test_layers() -> None:
    env = gym.Wrapper(gym.make("PongNoFrameskip-v4"))
    assert env.unwrapped is env.env.env
    assert env.spec is not None
    assert "NoFrameskip" in env.spec.id
    assert env.unwrapped.spec is env.spec
    assert "rgb_array" in env.metadata["render.modes"]
    assert env.metadata["video.frames_per_second"] > 0
    env.reward_range = (-1, 1)
    assert (env.reward_range, env.env.reward_range) == ((-1, 1), (-float("inf"), float("inf")))


def test_another_space() -> None:
    env = gym.make("Pong-v0")
    env.observation_space = gym.spaces.Box(0, 1, (2,))
    env.unwrapped.observation_space = gym.spaces.Box(0, 1, (3,))
    assert (env.observation_space.shape, env.unwrapped.observation_space.shape) == ((2,), (3,))


def test_limits() -> None:
    env: Any = gym.make("MountainCar-v0")
    assert (type(env).__name__, env._max_episode_steps) == ("TimeLimit", 200)
    env._max_episode_steps = 3
    env.reset()
    assert [env.step(0)[2] for _ in range(2)] == [False, False]
    assert (env._elapsed_steps, env.step(0)[2:], env._elapsed_steps) == (2, (True, {"TimeLimit.truncated": True}), 3)


def test_states_of_classic_control() -> None:
    env: Any = gym.make("Acrobot-v1")
    env.reset()
    assert (env.env.MAX_VEL_1, list(env.env.AVAIL_TORQUE)) == (4 * np.pi, [-1.0, 0.0, 1.0])
    env.env.state = np.array([0.1, 0.0, 0.0, 0.0])
    env.step(1)
    assert 0 < env.env.state[0] < 0.1
    assert env.env.state is env.unwrapped.modern.unwrapped.state


def test_constants_of_mountain_car() -> None:
    env: Any = gym.make("MountainCar-v0").unwrapped
    assert (env.min_position, env.max_position, env.max_speed, env.goal_position) == (-1.2, 0.6, 0.07, 0.5)


def test_tables() -> None:
    env: Any = gym.make("CliffWalking-v0")
    assert (env.nS, env.nA, env.shape) == (48, 4, (4, 12))
    lake: Any = gym.make("FrozenLake-v0")
    for env in (lake, lake.env, lake.unwrapped):
        chances = [p for p, state, reward, done in env.P[14][2]]
        assert sum(chances) == pytest.approx(1)
        assert len(chances) == 3


def test_states_of_the_taxi() -> None:
    env: Any = gym.make("Taxi-v2")
    assert env.env.s in range(500)  # before the first reset, too
    env.reset()
    row, column, passenger, goal = env.env.decode(env.env.s)
    assert env.env.encode(row, column, passenger, goal) == env.env.s
    env.env.s = env.env.encode(0, 0, 1, 2)
    assert env.step(0)[0] == env.env.encode(1, 0, 1, 2) == env.env.s


# Subclasses


def test_an_environment() -> None:
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


def test_an_environment_of_2016() -> None:
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


def test_a_wrapper() -> None:
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


def test_wrappers_of_parts() -> None:
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


def test_more_wrappers_of_parts() -> None:
    class Minus(gym.RewardWrapper):
        def _reward(self, reward: Any) -> Any:
            return -reward

    class Fixed(gym.ActionWrapper):
        def action(self, action: Any) -> Any:
            return 0

    env = Minus(Fixed(gym.make("CartPole-v0")))
    env.reset()
    assert env.step("anything")[1] == -1.0


def test_generators() -> None:
    rng, seed = gym.utils.seeding.np_random(5)
    assert seed == 5
    assert rng.choice([10]) == 10
    assert rng.randint(3) in range(3)
    assert 0 <= rng.rand() < 1


def test_a_table_of_transitions() -> None:
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


def test_a_cart_pole_of_ones_own() -> None:
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


def test_thresholds_of_cart_pole() -> None:
    env = gym.envs.classic_control.CartPoleEnv()
    assert (env.x_threshold, round(env.theta_threshold_radians, 3)) == (2.4, 0.209)


def test_a_lake_without_an_id() -> None:
    env: gym.Env = gym.envs.toy_text.frozen_lake.FrozenLakeEnv(is_slippery=False)
    env = gym.wrappers.TimeLimit(env, max_episode_steps=2)
    env.reset()
    assert [env.step(2)[:3] for _ in range(2)] == [(1, 0, False), (2, 0, True)]


def test_a_lake_that_is_not_slippery() -> None:
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


def test_actions_of_games() -> None:
    env: Any = gym.make("Pong-v0").unwrapped
    assert env.get_action_meanings()[:2] == ["NOOP", "FIRE"]
    assert env.get_keys_to_action() == {(): 0, (32,): 1, (100,): 2, (97,): 3, (32, 100): 4, (32, 97): 5}
    assert [int(env._action_set[a]) for a in range(3)] == [0, 1, 3]


def test_the_emulator(tmp_path: Path) -> None:
    env: Any = gym.make("BreakoutNoFrameskip-v4")
    env.reset()
    gray = np.empty((210, 160), np.uint8)
    env.env.ale.getScreenGrayscale(gray)
    assert (env.ale.lives(), env.unwrapped.ale.getRAM().shape, gray.max() > 0) == (5, (128,), True)
    before = env.unwrapped.ale.getRAM()
    env.unwrapped.ale.act(env.unwrapped._action_set[1])
    assert (env.unwrapped.ale.getRAM() != before).any()
    env.ale.saveScreenPNG(str(tmp_path / "screen.png").encode())
    assert (tmp_path / "screen.png").stat().st_size > 100


def test_the_generator_of_a_game() -> None:
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


def test_the_class_of_games() -> None:
    assert gym.envs.atari.atari_env.AtariEnv is gym.envs.atari.AtariEnv
    made = {env_id: gym.make(env_id).unwrapped for env_id in ("PongNoFrameskip-v4", "ALE/Pong-v5", "CartPole-v1")}
    assert hasattr(gym.envs, "atari")
    assert [isinstance(env, gym.envs.atari.AtariEnv) for env in made.values()] == [True, True, False]
    env = gym.envs.atari.AtariEnv(game="ms_pacman", obs_type="image", frameskip=5)
    assert (env.reset().shape, env.spec, env.step(0)[3]["frame_number"]) == ((210, 160, 3), None, 5)
    assert gym.make("Pong-v0", obs_type="image").reset().shape == (210, 160, 3)


def test_states_of_games() -> None:
    env: Any = gym.make("Breakout-v0").unwrapped
    env.reset()
    env.step(1)
    for clone, restore in ((env.clone_full_state, env.restore_full_state), (env.clone_state, env.restore_state)):
        state, image = clone(), env._get_image()
        env.step(2)
        assert (env._get_image() != image).any()
        restore(state)
        np.testing.assert_array_equal(env._get_image(), image)


def test_frames_of_a_step() -> None:
    env: Any = gym.make("PongDeterministic-v4")
    env.unwrapped.frameskip = 1
    env.reset()
    assert [env.step(0)[3]["episode_frame_number"] for _ in range(3)] == [1, 2, 3]


def test_lives_in_the_info() -> None:
    env = gym.make("SpaceInvaders-v0")
    env.reset()
    info = env.step(0)[3]
    assert info["ale.lives"] == info["lives"] == 3


# Registry


def test_specs() -> None:
    spec = gym.spec("CartPole-v0")
    assert (spec.timestep_limit, spec.max_episode_steps, spec.reward_threshold) == (200, 200, 195.0)
    assert spec.tags.get("wrapper_config.TimeLimit.max_episode_steps") == 200
    assert not spec.tags.get("atari", False)
    assert gym.envs.make("CartPole-v0").spec == spec


def test_kinds_of_environments() -> None:
    """Baselines finds the kind of an environment by the module of its class."""
    kinds = {spec.id: str(spec._entry_point).split(":")[0].split(".")[-1] for spec in gym.envs.registry.all()}
    ids = ("PongNoFrameskip-v4", "Breakout-ram-v0", "CartPole-v0", "Acrobot-v1", "FrozenLake-v1")
    assert [kinds[env_id] for env_id in ids] == ["atari", "atari", *["classic_control"] * 2, "toy_text"]
    assert "Pong-v0" in gym.envs.registry.env_specs
    assert "Pong-v9" not in gym.envs.registry.env_specs


def test_classes_of_specs() -> None:
    for env_id in ("PongNoFrameskip-v4", "Pong-ram-v0", "MountainCar-v0", "FrozenLake8x8-v1"):
        spec: Any = gym.envs.registry.env_specs[env_id]
        env = gym.envs.registration.load(spec.entry_point)(**spec._kwargs)
        made = gym.make(env_id)
        assert type(env) is type(made.unwrapped)
        assert spec.nondeterministic is False
        assert env.observation_space == made.observation_space
        assert env.action_space == made.action_space


def test_benchmarks() -> None:
    task = gym.benchmark_spec("Atari40M").tasks[3]
    assert (task.env_id, task.max_timesteps) == ("PongNoFrameskip-v4", 40_000_000)
    assert gym.make(gym.benchmark_spec("Atari200M").tasks[1].env_id).action_space.n == 4  # type: ignore[attr-defined]


def test_the_package() -> None:
    level = gym.logger.INFO
    gym.undo_logger_setup()
    assert gym.version.VERSION == gym.__version__ < "0.22"
    gym.upload("results", algorithm_id="random")
    for name in ("set_level", "setLevel"):
        getattr(gym.logger, name)(level)
    gym.logger.set_level(30)


def test_levels() -> None:
    assert gym.logger.DEBUG < gym.logger.INFO < gym.logger.WARN < gym.logger.ERROR


# Recorders


def test_a_monitor(tmp_path: Path) -> None:
    env = gym.wrappers.Monitor(gym.make("CartPole-v0"), str(tmp_path), video_callable=lambda episode: episode == 1)
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
    (stats,) = tmp_path.glob("*.stats.json")
    assert len(json.loads(stats.read_text())["episode_lengths"]) == 3
    assert len(list(tmp_path.glob("*.mp4"))) == 1


def test_a_monitor_of_2016(tmp_path: Path) -> None:
    env = gym.make("CartPole-v0")
    env.monitor.start(str(tmp_path), force=True, seed=0, video_callable=lambda episode: False)
    env.reset()
    while not env.step(0)[2]:
        pass
    env.monitor.close()
    assert len(list(tmp_path.glob("*.stats.json"))) == 1


def test_a_recorder_of_videos(tmp_path: Path) -> None:
    env = gym.wrappers.RecordVideo(gym.make("CartPole-v0"), str(tmp_path))
    env.reset()
    while not env.step(0)[2]:
        pass
    env.close()
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        "rl-video-episode-0.meta.json",
        "rl-video-episode-0.mp4",
    ]


def test_a_window_for_images() -> None:
    from atari.classic.envs.classic_control import rendering

    viewer = rendering.SimpleImageViewer()
    viewer.imshow(np.zeros((210, 160, 3), np.uint8))
    assert viewer.isopen
    viewer.close()
    assert not viewer.isopen


def test_play() -> None:
    """`test_play.py` plays."""
    from atari.classic.utils.play import play as function

    assert callable(function)


# Gym's last years


def test_cleanrls_wrappers() -> None:
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


def test_a_flat_dictionary() -> None:
    class Reach(gym.Env):
        action_space = gym.spaces.Discrete(2)
        observation_space = gym.spaces.Dict(
            {"observation": gym.spaces.Box(0, 9, (2,)), "desired_goal": gym.spaces.Box(0, 9, (3,))}
        )

        def reset(self) -> Any:
            return {"observation": np.ones(2), "desired_goal": np.zeros(3)}

    env = gym.wrappers.FlattenDictWrapper(Reach(), ["observation", "desired_goal"])
    assert (env.observation_space.shape, env.reset().tolist()) == ((5,), [1, 1, 0, 0, 0])


def test_running_moments() -> None:
    samples = np.random.default_rng(0).normal(5, 3, (1000, 2))
    moments = gym.wrappers.normalize.RunningMeanStd(shape=(2,))
    for batch in np.split(samples, 10):
        moments.update(batch)
    np.testing.assert_allclose(moments.mean, samples.mean(axis=0), rtol=1e-5)
    np.testing.assert_allclose(moments.var, samples.var(axis=0), rtol=1e-4)


def test_a_vector() -> None:
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


def test_removed_names_of_numpy(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "import numpy as np\nprint(np.zeros(1, np.bool), np.array([1.5]).astype(np.int), np.cast[np.uint8](3.5))"
    )
    result = subprocess.run([sys.executable, "-m", "atari.classic", str(script)], capture_output=True, text=True)
    assert result.stdout == "[False] [1] 3\n", result.stderr
