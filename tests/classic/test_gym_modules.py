"""Gym's small modules: they can be imported by their paths, and their functions do what Gym's did."""

from importlib import import_module
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import atari.classic as gym
from atari.classic import gym_modules, spaces
from atari.classic.utils.closer import Closer
from atari.classic.utils.env_checker import check_env
from atari.classic.utils.reraise import ReraisedException, reraise
from atari.classic.utils.save_video import save_video
from atari.classic.vector import utils


def test_every_module_of_the_table_has_its_names() -> None:
    for name, homes in gym_modules.MODULES.items():
        module = import_module(f"atari.classic.{name}")
        names = {each.partition("=")[0] for each in " ".join(homes.values()).split()}
        assert set(module.__all__) == names  # type: ignore[attr-defined]
        assert names <= set(vars(module))
    assert callable(gym.utils.colorize)  # a function, although a module has its name
    with pytest.raises(ModuleNotFoundError, match=r"atari\.classic\.wrappers\.nothing"):
        import_module("atari.classic.wrappers.nothing")


def test_elements_of_spaces_as_arrays() -> None:
    space = spaces.Dict(a=spaces.Discrete(3), b=spaces.Box(0, 1, (2,)), c=spaces.MultiBinary(2))
    value = {"a": 2, "b": np.array([0.5, 1], np.float32), "c": np.array([0, 1], np.int8)}
    flat = spaces.flatten(space, value)
    assert (spaces.flatdim(space), flat.tolist()) == (7, [0, 0, 1, 0.5, 1, 0, 1])
    assert (spaces.utils.flatdim(spaces.Discrete(4)), spaces.flatten_space(space).shape) == (4, (7,))
    back: Any = spaces.unflatten(space, flat)
    assert (int(back["a"]), back["b"].tolist(), back["c"].tolist()) == (2, [0.5, 1], [0, 1])
    assert str(spaces.flatten_space(space)) == "Box(7,)"


def test_spaces_with_seeds() -> None:
    for make in (
        lambda seed: spaces.Discrete(99, seed),
        lambda seed: spaces.Box(0, 1, (3,), seed=seed),
        lambda seed: spaces.MultiDiscrete([9, 9, 9], seed=seed),
        lambda seed: spaces.MultiBinary(20, seed),
        lambda seed: spaces.Tuple([spaces.Discrete(99)] * 2, seed),
        lambda seed: spaces.Dict({"a": spaces.Discrete(99)}, seed=seed),
    ):
        assert str(make(7).sample()) == str(make(7).sample())
    shifted = spaces.Discrete(3, start=5)
    assert (shifted.contains(5), shifted.contains(0), str(shifted)) == (True, False, "Discrete(3, start=5)")
    graph = spaces.Graph(spaces.Box(0, 1, (2,)), spaces.Discrete(4), seed=1)
    sample = graph.sample(num_nodes=3, num_edges=5)
    assert (sample.nodes.shape, sample.edge_links.shape) == ((3, 2), (5, 2))  # type: ignore[union-attr]
    assert sample in graph
    assert not np.array_equal(sample.nodes, graph.sample(num_nodes=3).nodes)


def test_batches_in_both_orders_of_arguments() -> None:
    space = spaces.Box(0, 9, (2,))
    out: Any = utils.create_empty_array(space, 2)
    for arguments in (([[1, 2], [3, 4]], out, space), (space, [[1, 2], [3, 4]], out)):
        assert utils.concatenate(*arguments).tolist() == [[1, 2], [3, 4]]  # type: ignore[arg-type]
    memory = utils.create_shared_memory(space, 2)
    utils.write_to_shared_memory(1, np.array([5, 6]), memory, space)
    utils.write_to_shared_memory(space, 0, np.array([7, 8]), memory)  # type: ignore[arg-type]
    for arguments in ((memory, space, 2), (space, memory, 2)):  # type: ignore[assignment]
        assert utils.read_from_shared_memory(*arguments).tolist() == [[7, 8], [5, 6]]  # type: ignore[arg-type]


def test_a_closer_closes_what_is_left() -> None:
    class Thing:
        def __init__(self, name: str) -> None:
            self.number, self.name = closer.register(self), name

        def close(self) -> None:
            closed.append(self.name)

    closed: list[str] = []
    closer = Closer(atexit_register=False)
    first, second = Thing("first"), Thing("second")
    closer.unregister(first.number)
    closer.unregister(first.number)
    Thing("gone")
    closer.close()
    assert (closed, second.number) == (["second"], 1)
    with pytest.raises(TypeError, match=r"that have a method close\(\), got 3$"):
        closer.register(3)


def test_an_exception_with_more_text() -> None:
    def load() -> None:
        try:
            raise LookupError("no file")
        except LookupError:
            reraise("while loading", "try again")

    text = r"^while loading\nThe original exception was:\n\nLookupError: no file\n\ntry again$"
    with pytest.raises(ReraisedException, match=text):
        load()


def test_the_checker_of_environments() -> None:
    check_env(gym.make("CartPole-v1"))

    class Outside(gym.Env):
        action_space, observation_space = gym.spaces.Discrete(2), gym.spaces.Discrete(3)

        def reset(self) -> int:
            return 5

        def step(self, action: Any) -> Any:
            return 0, 0.0, False, {}

    with pytest.raises(ValueError, match=r"^the observation 5 is not in the observation space$"):
        check_env(Outside())


def test_frames_as_videos(tmp_path: Path) -> None:
    frames = [np.full((4, 6, 3), 9 * n, np.uint8) for n in range(5)]
    save_video(frames, tmp_path, fps=10, episode_index=8)
    save_video(frames, tmp_path, fps=10, episode_index=9)
    save_video(frames, tmp_path, fps=10, step_trigger=lambda step: step == 12, step_starting_index=10, video_length=2)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["rl-video-episode-8.mp4", "rl-video-step-12.mp4"]


def test_limits_and_new_episodes_of_make() -> None:
    env = gym.make("CartPole-v1", max_episode_steps=2, autoreset=True)
    env.reset()
    assert [env.step(0)[2] for _ in range(4)] == [False, True, False, True]
    with pytest.raises(gym.error.Error, match=r"^register\(\) has no autoreset=True"):
        gym.register("Endless-v0", gym.Env, autoreset=True)


def test_a_game_whose_subclass_sees_something_else() -> None:
    class Bright(gym.envs.atari.AtariEnv):
        def _get_image(self) -> Any:
            return 255 - super()._get_image()

    dark, bright = (kind("pong", obs_type="image", frameskip=4) for kind in (gym.envs.atari.AtariEnv, Bright))
    for env in (dark, bright):
        env.seed(3)
    np.testing.assert_array_equal(bright.reset(), 255 - dark.reset())
    np.testing.assert_array_equal(bright.step(2)[0], 255 - dark.step(2)[0])
    np.testing.assert_array_equal(bright.render(mode="rgb_array"), 255 - dark.render(mode="rgb_array"))


def test_the_version_the_levels_and_the_benchmarks(monkeypatch: pytest.MonkeyPatch) -> None:
    assert gym.version.VERSION == gym.__version__ < "0.22"
    gym.undo_logger_setup()
    assert gym.logger.DEBUG < gym.logger.INFO < gym.logger.WARN < gym.logger.ERROR
    monkeypatch.setattr(gymnasium.logger, "min_level", gym.logger.WARN)
    for name, level in (("set_level", gym.logger.INFO), ("setLevel", gym.logger.ERROR)):
        getattr(gym.logger, name)(level)
        assert gym.logger.min_level == gym.logger.MIN_LEVEL == level  # type: ignore[attr-defined]
    task = gym.benchmark_spec("Atari40M").tasks[3]
    assert (task.env_id, task.max_timesteps) == ("PongNoFrameskip-v4", 40_000_000)
    assert gym.make(gym.benchmark_spec("Atari200M").tasks[1].env_id).action_space.n == 4  # type: ignore[attr-defined]
