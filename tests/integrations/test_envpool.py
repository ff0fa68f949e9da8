"""`atari.integrations.envpool`: what scripts for EnvPool use, and scripts in their style.

`tests/peers/test_envpool_interface.py` compares it with EnvPool.
"""

import importlib
import inspect
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import VectorEnv

import atari
from atari import Task
from atari.integrations import envpool
from atari.integrations.envpool.__main__ import main, stand_in

SCRIPTS = Path(__file__).parent / "scripts"


def make(env_type: str = "gymnasium", **options: Any) -> Any:
    return envpool.make("Breakout-v5", env_type, **{"num_envs": 3, "seed": 1, "num_threads": 1, **options})


def run(script: Path, *arguments: str) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "atari.integrations.envpool", str(script), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120)


class TestScripts:
    def test_ppo(self) -> None:
        result = run(SCRIPTS / "ppo_style.py", "--num-envs", "4")
        assert result.returncode == 0, result.stderr
        *games, ended = result.stdout.splitlines()
        assert len(games) > 4
        assert int(ended.split()[1]) > 4 * len(games)  # lives
        first = re.fullmatch(r"return (\d+) length (\d+) steps (\d+)", games[0])
        assert first
        assert int(first[2]) >= int(first[3])  # the wrapper counts resets after lost lives as steps

    def test_the_types_module(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(sys, "modules", dict(sys.modules))
        stand_in()
        from envpool.python.protocol import EnvPool  # type: ignore[import-not-found]

        assert EnvPool is importlib.import_module("envpool").EnvPool is envpool.EnvPool

    def test_a_missing_script(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["nothing.py"]) == 2
        text = "atari.integrations.envpool: there is no script 'nothing.py'; usage: "
        assert capsys.readouterr().err.startswith(text)


class TestGym:
    def test_steps_have_four_values(self) -> None:
        envs = make("gym")
        assert isinstance(envs.reset(), np.ndarray)
        observation, reward, done, info = envs.step(np.zeros(3, int))
        assert (observation.shape, observation.dtype) == ((3, 4, 84, 84), np.uint8)
        assert (reward.dtype, done.dtype) == (np.float32, np.bool_)
        assert {*"TimeLimit.truncated env_id lives reward terminated elapsed_step players".split()} <= set(info)

    def test_reset_can_return_info(self) -> None:
        _, info = make("gym", gym_reset_return_info=True).reset()
        assert info["lives"].tolist() == [5, 5, 5]

    def test_spaces_are_gyms(self, monkeypatch: pytest.MonkeyPatch) -> None:
        import atari.classic as gym

        monkeypatch.setitem(sys.modules, "gym", gym)
        monkeypatch.setitem(sys.modules, "gym.spaces", gym.spaces)
        envs = make("gym")
        assert isinstance(envs, gym.Env)
        assert isinstance(envs.action_space, gym.spaces.Discrete)
        assert isinstance(gym.Wrapper(envs).reset(), np.ndarray)
        assert not isinstance(make("gymnasium"), gym.Env)


class TestGymnasium:
    def test_steps_have_five_values(self) -> None:
        envs = make(episodic_life=True)
        observation, _ = envs.reset()
        assert isinstance(envs, VectorEnv)
        assert isinstance(envs, gymnasium.Env)
        assert observation[0] in envs.observation_space
        wrapped = gymnasium.Wrapper(envs)
        wrapped.reset()
        assert len(envs.step(np.zeros(3, int))) == len(wrapped.step(np.zeros(3, int))) == 5
        assert wrapped.get_wrapper_attr("num_envs") == 3

    def test_the_statistics_of_gymnasium(self) -> None:
        envs = gymnasium.wrappers.vector.RecordEpisodeStatistics(make(max_episode_steps=5))
        envs.reset()
        for _ in range(5):
            *_, info = envs.step(np.zeros(3, int))
        assert info["episode"]["l"].tolist() == [5, 5, 5]
        assert info["TimeLimit.truncated"].tolist() == [True] * 3


class TestWhatScriptsUse:
    def test_attributes(self) -> None:
        envs = make(batch_size=2)
        assert (len(envs), envs.num_envs, envs.is_async, envs.is_vector_env) == (3, 3, True, True)
        assert envs.all_env_ids.tolist() == [0, 1, 2]
        assert envs.spec.config.num_envs == 3
        assert envs.config["task"] == "breakout"
        assert envs.spec.reward_threshold is None
        envs.spec.id = "Breakout-v5"
        assert not make().is_async
        for name in ("num_envs", "single_action_space", "single_observation_space", "is_vector_env", "name"):
            setattr(envs, name, 7)
            assert getattr(envs, name) == 7
        assert len(envs) == 3

    def test_reset_of_some_as_adapters_for_sb3_do(self) -> None:
        envs = make("gym", episodic_life=True, num_envs=4)
        observation = envs.reset()
        for _ in range(60):
            observation, _, done, info = envs.step(np.zeros(4, int))
            for one in np.flatnonzero(done):
                observation[one] = envs.reset(np.array([one]))[0]
        assert info["env_id"].tolist() == [0, 1, 2, 3]

    def test_collectors(self) -> None:
        envs = make()
        envs.reset()
        *_, info = envs.step(np.zeros(2, int), np.array([2, 0]))
        assert info["players"]["env_id"].tolist() == [2, 0]
        observation, info = envs.reset(np.array([1]))
        assert (observation.shape[0], info["env_id"].tolist()) == (1, [1])

    def test_asynchronous_loop(self) -> None:
        envs = make(num_envs=4, batch_size=2)
        envs.async_reset()
        steps = np.zeros(4, int)
        for _ in range(20):
            *_, info = envs.recv()
            assert np.array_equal(info["elapsed_step"], steps[info["env_id"]])
            steps[info["env_id"]] += 1
            envs.send(np.zeros(2, int), info["env_id"])
        envs.recv()
        envs.send({"action": np.zeros(2, int), "env_id": envs.vector.reset()[1]["env_id"]})

    def test_the_seed_counts_once(self) -> None:
        first, other = make(), make(seed=[1, 2, 3])
        begun = first.reset()[0]
        assert np.array_equal(begun, other.reset()[0])
        first.seed(1)
        assert np.array_equal(first.reset()[0], begun)
        assert make(seed=2**31 - 1).reset()[0].shape == begun.shape

    def test_close(self) -> None:
        envs = make()
        envs.close()
        envs.close()
        with pytest.raises(gymnasium.error.ClosedEnvironmentError):
            envs.step(np.zeros(3, int))

    def test_xla_without_jax(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setitem(sys.modules, "jax", None)
        with pytest.raises(gymnasium.error.DependencyNotInstalled, match="pip install jax"):
            make().xla()


class TestResults:
    def test_lives_and_games(self) -> None:
        """A lost life ends an episode; `terminated` and `elapsed_step` are of the whole game, `reward` is not clipped."""
        envs = make(episodic_life=True, reward_clip=True, num_envs=8)
        envs.reset()
        rng = np.random.default_rng(0)
        lost = over = points = 0
        for _ in range(400):
            _, reward, terminated, _, info = envs.step(rng.integers(4, size=8))
            assert np.array_equal(np.sign(info["reward"]), reward)
            points = max(points, info["reward"].max())
            assert np.array_equal(info["terminated"] == 1, terminated & (info["lives"] == 0))
            lost += int((terminated & (info["lives"] > 0)).sum())
            over += int(info["terminated"].sum())
        assert lost > over > 0
        assert points >= 1

    def test_rgb_and_ram(self) -> None:
        envs = make(gray_scale=False, stack_num=2)
        observation, info = envs.reset()
        assert observation.shape == (3, 6, 84, 84)
        assert observation[0] in envs.observation_space
        assert np.array_equal(info["ram"][1], envs.vector.lanes[1].ram())


class TestTasks:
    def test_every_game_has_one(self) -> None:
        tasks = envpool.list_all_envs()
        assert len({envpool.make_spec(name).config.task for name in tasks}) == len(tasks) == 104
        assert {"Breakout-v5", "TicTacToe3d-v5", "UpNDown-v5", "Et-v5"} <= set(tasks)

    def test_spec(self) -> None:
        spec = envpool.make_spec("Pong-v5", num_envs=2, full_action_space=True)
        assert (spec.config.task, spec.config.batch_size, spec.action_space.n) == ("pong", 2, 18)
        assert spec.observation_space.shape == (4, 84, 84)

    @pytest.mark.parametrize(
        ("arguments", "error", "words"),
        [
            ({"task_id": "Breakot-v5"}, ValueError, "did you mean 'Breakout-v5'"),
            ({"task_id": "ALE/Pnog-v5"}, ValueError, "did you mean 'Pong-v5'"),
            ({"task_id": Task.of("pong", players=2)}, ValueError, "a game has one player"),
            ({"task_id": Task.of("pong", obs_type="ram")}, ValueError, "use 'dict'"),
            ({"reward_clip": "no"}, TypeError, "reward_clipping must be True or False"),
            ({"env_type": "tf"}, ValueError, "'gym', 'gymnasium' or 'dm', got 'tf'"),
            ({"zero_discount_on_life_loss": True}, ValueError, "use make_dm"),
            ({"render_mode": "ascii"}, ValueError, "render_mode must be None, 'rgb_array' or 'human', got 'ascii'"),
            ({"render_env_id": 1}, ValueError, "render_env_id"),
            ({"num_envs": 2, "env_seed": [1]}, ValueError, "env_seed must have a seed for each of 2"),
            ({"num_env": 3}, TypeError, "did you mean 'num_envs'"),
            ({"task": "pong"}, TypeError, "there is no option 'task'"),
            ({"num_envs": 0}, ValueError, "num_envs"),
            ({"num_envs": 2, "batch_size": 3}, ValueError, "batch_size"),
            ({"noop_max": 0}, ValueError, "noop_max"),
            ({"frame_skip": 0}, ValueError, "frame_skip"),
            ({"stack_num": 2.5}, TypeError, "stack_num"),
            ({"use_inter_area_resize": False}, ValueError, "use_inter_area_resize"),
            ({"max_num_players": 2}, ValueError, "one player"),
            ({"img_height": 500}, ValueError, "500"),
        ],
    )
    def test_mistakes(self, arguments: dict[str, Any], error: type[Exception], words: str) -> None:
        with pytest.raises(error, match=re.escape(words)):
            envpool.make(**{"task_id": "Pong-v5", "env_type": "gym", **arguments})

    @pytest.mark.parametrize(
        "game", ["pong", "Pong-v5", atari.games["pong"], "ALE/Pong-v5", "PongNoFrameskip-v4"], ids=str
    )
    def test_every_form_of_a_game(self, game: Any) -> None:
        sticky = 0.25 if game == "ALE/Pong-v5" else 0.0
        envs = envpool.make_gymnasium(game, num_envs=2, stack_num=3, frame_skip=2)
        wanted = Task.of("pong", preset="envpool", stack_num=3, frameskip=2, obs_type="dict", max_frames=54_000)
        assert envs.task == wanted.replace(repeat_action_probability=sticky)
        assert envs.config["repeat_action_probability"] == sticky

    def test_a_task_keeps_its_fields(self) -> None:
        task = Task.of("breakout", preset="dqn2015", frameskip=3)
        envs = envpool.make_gymnasium(task, num_envs=2)
        assert envs.task == task.replace(obs_type="dict")
        config = envs.config
        assert (config["frame_skip"], config["noop_max"], config["episodic_life"]) == (3, 30, True)
        assert (config["reward_clip"], config["use_fire_reset"], config["task"]) == (True, False, "breakout")
        assert envpool.make_gymnasium(task, num_envs=1, episodic_life=False).task.episodic_life is False

    def test_wrong_steps(self) -> None:
        envs = make()
        with pytest.raises(gymnasium.error.ResetNeeded):
            envs.step(np.zeros(3, int))
        envs.reset()
        for env_id, error in (([0, 0], ValueError), ([3], IndexError), (["a"], TypeError), ([], TypeError)):
            with pytest.raises(error):
                envs.reset(np.array(env_id))
        with pytest.raises(ValueError, match="leave env_id out"):
            make(batch_size=2).reset(np.array([0]))


def test_the_options_are_those_of_the_docstring() -> None:
    described = inspect.getdoc(envpool.make) or ""
    config = envpool.make_spec("Pong-v5").config._asdict()
    hidden = {"task", "base_path", "max_num_players", "zero_discount_on_life_loss", "use_inter_area_resize"}
    assert all(name in described for name in set(config) - hidden)


class TestSpecs:
    def test_the_arrays_of_a_spec_are_those_of_the_results(self) -> None:
        spec = envpool.make_spec("Pong-v5", num_envs=2, gray_scale=False, stack_num=2, img_height=50)
        arrays = spec.state_array_spec
        assert arrays["obs"].shape == [6, 50, 84]
        observations, info = envpool.GymnasiumEnvPool(spec).reset()
        assert [*observations.shape[1:]] == arrays["obs"].shape
        for name, array in arrays.items():
            if name.startswith("info:") and "players" not in name:
                got, shape = info[name.removeprefix("info:")], [size for size in array.shape if size != -1]
                assert (got.dtype, [*got.shape[1:]]) == (array.dtype, shape), name
                assert (got >= array.minimum).all()
                assert (got <= array.maximum).all()
        assert spec.action_array_spec["action"].maximum == 5
        assert envpool.make_spec("Pong-v5", full_action_space=True).action_array_spec["action"].maximum == 17
        text = "ArraySpec(shape=[], dtype=int32, minimum=-2147483648, maximum=2147483647)"
        assert repr(spec.action_array_spec["env_id"]) == text

    def test_a_spec_is_made_from_a_config(self) -> None:
        kinds = envpool.atari
        config = kinds.AtariEnvSpec.gen_config(task="pong", num_envs=2, stack_num=3)
        spec = kinds.AtariEnvSpec(config)
        assert spec.config == envpool.make_spec("Pong-v5", num_envs=2, stack_num=3).config
        assert spec.config.batch_size == 2
        assert kinds.AtariGymnasiumEnvPool(spec).reset()[0].shape == (2, 3, 84, 84)

    def test_a_name_is_registered(self) -> None:
        classes = ("AtariEnvSpec", "AtariDMEnvPool", "AtariGymnasiumEnvPool")
        envpool.register("Two-v5", "envpool.atari", *classes, aliases=["Both-v5"], task="pong", stack_num=2)
        try:
            assert envpool.make("Both-v5", "gymnasium").observation_space.shape == (2, 84, 84)
            assert envpool.make_spec("Two-v5", stack_num=3).config.stack_num == 3
            assert {"Two-v5", "Both-v5"} <= {*envpool.list_all_envs()}
            for arguments, options, words in (
                (("Two-v5", "envpool.atari", *classes), {"task": "pong"}, "'Two-v5' is taken"),
                (("X-v5", "envpool.mujoco", *classes), {"task": "ant"}, "only Atari games can be registered"),
                (("X-v5", "envpool.atari", *classes), {}, "needs task"),
                (("X-v5", "envpool.atari", *classes), {"task": "pong", "stack": 1}, "did you mean"),
            ):
                with pytest.raises((TypeError, ValueError), match=words):
                    envpool.register(*arguments, **options)
            assert "X-v5" not in envpool.list_all_envs()
        finally:
            for name in ("Two-v5", "Both-v5"):
                envpool.spec._REGISTERED.pop(name)

    def test_each_environment_has_a_seed(self) -> None:
        seeded = make(env_seed=[5, 6, 9])
        single = [envpool.make("Breakout-v5", "gymnasium", seed=seed) for seed in (5, 6, 9)]
        seeded.reset()
        for one in single:
            one.reset()
        for _ in range(30):
            observations = seeded.step(np.ones(3, int))[0]
            assert np.array_equal(observations, np.concatenate([one.step(np.ones(1, int))[0] for one in single]))


class TestRender:
    def test_screens(self) -> None:
        envs = make(render_mode="rgb_array", render_env_id=1)
        envs.reset()
        screens = np.stack(envs.vector._screens())
        assert np.array_equal(envs.render(), screens[[1]])
        assert np.array_equal(envs.render([2, 0]), screens[[2, 0]])
        assert np.array_equal(envs.render(2, camera_id=7), screens[[2]])
        with pytest.raises(IndexError):
            envs.render(3)

        small = make(render_mode="rgb_array", render_width=80, render_height=105)
        small.reset()
        means = screens[:1].reshape(1, 105, 2, 80, 2, 3).mean((2, 4))
        assert np.abs(small.render().astype(float) - means).max() <= 1
        with pytest.raises(RuntimeError, match="needs a render mode"):
            make().render()

    def test_window(self) -> None:
        pytest.importorskip("pygame")
        envs = make(render_mode="human")
        envs.reset()
        assert envs.render() is None
        envs.close()


class TestDm:
    def test_time_steps(self) -> None:
        dm_env = pytest.importorskip("dm_env")
        options: dict[str, Any] = {"noop_max": 1, "max_episode_steps": 40}
        envs, same = make("dm", zero_discount_on_life_loss=True, **options), make("gymnasium", **options)
        first, (observations, info) = envs.reset(), same.reset()
        assert isinstance(first, dm_env.TimeStep)
        assert [first.step_type.tolist(), first.discount.tolist()] == [[0] * 3, [1] * 3]
        assert np.array_equal(first.observation.obs, observations)
        lives, kinds = info["lives"], set()
        for _ in range(90):
            step = envs.step(np.ones(3, int))
            observations, rewards, terminated, truncated, info = same.step(np.ones(3, int))
            ends, begins = terminated | truncated, info["elapsed_step"] == 0
            assert step.step_type.tolist() == np.where(ends, 2, np.where(begins, 0, 1)).tolist()
            zero = ends | ((info["lives"] < lives) & ~begins)
            assert step.discount.tolist() == np.where(zero, 0, 1).tolist()
            assert np.array_equal(step.reward, rewards)
            for name in ("env_id", "lives", "reward", "terminated", "ram"):
                assert np.array_equal(getattr(step.observation, name), info[name])
            assert np.array_equal(step.observation.obs, observations)
            kinds |= {*zip(step.step_type.tolist(), step.discount.tolist(), strict=True)}
            lives = info["lives"]
        assert kinds == {(0, 1), (1, 1), (1, 0), (2, 0)}
        part = envs.step(np.zeros(2, int), np.array([2, 0]))
        assert part.observation.env_id.tolist() == part.observation.players.env_id.tolist() == [2, 0]

    def test_specs(self) -> None:
        pytest.importorskip("dm_env")
        envs = make("dm")
        step, spec = envs.reset(), envs.observation_spec()
        for name in spec._fields:
            if name != "players":
                getattr(spec, name).validate(getattr(step.observation, name)[0])
        assert envs.action_spec().num_values == 4
        assert envs.reward_spec().name == "reward"
        assert envs.discount_spec().maximum == 1
        assert envpool.DMEnvPool is envpool.atari.AtariDMEnvPool is type(envs)

    def test_without_dm_env(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setitem(sys.modules, "atari.integrations.envpool.dm", None)
        for use in (lambda: make("dm"), lambda: envpool.make_spec("Pong-v5").action_spec(), lambda: envpool.DMEnvPool):
            with pytest.raises(gymnasium.error.DependencyNotInstalled, match="install dm-env"):
                use()
