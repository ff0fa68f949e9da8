"""What users of Stable-Baselines3 and its zoo do around environments, with ours: videos, memory, statistics, files."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from video_reader import video_frames

import atari
from atari.base.wrapped import page_of
from atari.recording import RecordVideo, Replay

pytestmark = pytest.mark.peers


def make(game: str = "breakout", num_envs: int = 2, **options: Any) -> Any:
    from atari.sb3 import AtariVecEnv

    return AtariVecEnv(game, num_envs, **{"preset": "baselines", **options})


def dqn(envs: Any, **options: Any) -> Any:
    import torch
    from stable_baselines3 import DQN

    torch.set_num_threads(1)
    policy = {"net_arch": [8]}
    sizes: dict[str, Any] = {"buffer_size": 400, "learning_starts": 50, "batch_size": 8, "train_freq": 16}
    return DQN("CnnPolicy", envs, policy_kwargs=policy, seed=0, device="cpu", **sizes, **options)


def ppo(envs: Any, policy: str = "CnnPolicy", **options: Any) -> Any:
    import torch
    from stable_baselines3 import PPO

    torch.set_num_threads(1)
    return PPO(policy, envs, n_steps=16, batch_size=32, n_epochs=1, seed=0, device="cpu", **options)


def rollout(envs: Any, steps: int) -> list[tuple[Any, ...]]:
    """Observations, rewards and ends of random actions."""
    rng = np.random.default_rng(0)
    results: list[tuple[Any, ...]] = []
    for _ in range(steps):
        observation, reward, done, _ = envs.step(rng.integers(envs.action_space.n, size=envs.num_envs))
        results.append((np.array(observation), reward.copy(), done.copy()))
    return results


def assert_equal(some: list[tuple[Any, ...]], others: list[tuple[Any, ...]]) -> None:
    for one, other in zip(some, others, strict=True):
        for part, counterpart in zip(one, other, strict=True):
            np.testing.assert_array_equal(part, counterpart)


def test_our_recorder_does_the_job_of_vec_video_recorder(tmp_path: Path) -> None:
    from atari.sb3 import RecordVideo

    plain, recorded = make(), make()
    recorded = RecordVideo(
        recorded, tmp_path / "v", step_trigger=lambda step: step in (0, 40), video_length=20, sound=False
    )
    for envs in (plain, recorded):
        envs.seed(3)
    assert np.array_equal(plain.reset(), recorded.reset())
    assert_equal(rollout(recorded, 300), rollout(plain, 300))
    assert recorded.get_attr("lives") == plain.get_attr("lives")
    recorded.close()
    files = sorted(path.name for path in (tmp_path / "v").iterdir())
    assert files == ["rl-video-step-0.mp4", "rl-video-step-40.mp4"]
    assert 60 <= len(video_frames(tmp_path / "v" / files[1])) <= 90  # 20 steps of 4 frames, and resets


def test_a_replay_of_one_of_them(tmp_path: Path) -> None:
    from atari.sb3 import RecordReplay

    plain, recorded = make(), RecordReplay(make(), tmp_path / "second.a26r", index=1)
    for envs in (plain, recorded):
        envs.seed(3)
        envs.reset()
    assert_equal(rollout(recorded, 50), rollout(plain, 50))
    recorded.close()
    assert Replay.load(tmp_path / "second.a26r").verify()
    with pytest.raises(
        TypeError, match=r"an atari\.sb3\.AtariVecEnv is recorded, before other wrappers; got RecordReplay"
    ):
        RecordReplay(RecordReplay(make(), tmp_path / "a.a26r"), tmp_path / "b.a26r")


def test_training_is_recorded(tmp_path: Path) -> None:
    envs = make()
    envs.vector = RecordVideo(
        envs.vector, tmp_path / "v", step_trigger=lambda step: step == 5, video_length=10, sound=False
    )
    ppo(envs).learn(64)
    envs.close()
    assert [path.name for path in (tmp_path / "v").iterdir()] == ["rl-video-step-5.mp4"]


def test_a_memory_that_keeps_each_observation_once() -> None:
    envs = make("pong")
    model = dqn(envs, optimize_memory_usage=True, replay_buffer_kwargs={"handle_timeout_termination": False})
    model.learn(300)
    memory = model.replay_buffer
    assert memory.optimize_memory_usage
    sample = memory.sample(16)
    assert sample.observations.shape == sample.next_observations.shape == (16, 4, 84, 84)
    assert (memory.observations[1:100, :, 0] == memory.observations[:99, :, 1]).mean() > 0.9  # the stack moves on


def test_vec_normalize(tmp_path: Path) -> None:
    from stable_baselines3.common.vec_env import VecNormalize

    envs = VecNormalize(make(num_envs=4), norm_obs=False)
    ppo(envs).learn(256)
    envs.save(str(tmp_path / "normalize.pkl"))
    loaded = VecNormalize.load(str(tmp_path / "normalize.pkl"), make(num_envs=4))
    assert loaded.ret_rms.var == envs.ret_rms.var
    assert loaded.reset().shape == (4, 4, 84, 84)


def test_vec_monitor_warns_and_files_are_written(tmp_path: Path) -> None:
    from stable_baselines3.common.vec_env import VecMonitor

    with pytest.warns(UserWarning, match="already wrapped with a `Monitor` wrapper"):
        envs = VecMonitor(make(), str(tmp_path))
    envs.seed(0)
    envs.reset()
    dones = sum(done.sum() for _, _, done in rollout(envs, 400))
    envs.close()
    lines = (tmp_path / "monitor.csv").read_text().splitlines()
    assert len(lines) - 2 == dones > 4  # lives, which VecMonitor takes for episodes, below a header of two lines


def test_evaluation_counts_whole_games() -> None:
    from stable_baselines3.common.evaluation import evaluate_policy

    model = ppo(make())
    envs = make(num_envs=3)
    returns, lengths = evaluate_policy(model, envs, 4, deterministic=False, return_episode_rewards=True)
    assert len(returns) == len(lengths) == 4
    assert min(lengths) > 300
    assert evaluate_policy(model, make(num_envs=1), 1, deterministic=False)[0] >= 0


@pytest.mark.parametrize("algorithm", ["dqn", "ppo"])
def test_a_model_is_saved_and_loaded(tmp_path: Path, algorithm: str) -> None:
    model = {"dqn": dqn, "ppo": ppo}[algorithm](make())
    model.learn(64)
    model.save(tmp_path / "model")
    envs = make()
    loaded = type(model).load(tmp_path / "model", env=envs, device="cpu")
    envs.seed(0)
    observation = envs.reset()
    actions = model.predict(observation, deterministic=True)[0]
    assert np.array_equal(loaded.predict(observation, deterministic=True)[0], actions)
    assert loaded.num_timesteps == model.num_timesteps
    loaded.learn(64, reset_num_timesteps=False)
    assert loaded.num_timesteps == 2 * model.num_timesteps


@pytest.mark.parametrize("vector", ["DummyVecEnv", "SubprocVecEnv"])
def test_make_atari_env(vector: str, tmp_path: Path) -> None:
    from stable_baselines3.common import env_util, vec_env

    kwargs = {"start_method": "fork"} if vector == "SubprocVecEnv" else None
    envs = env_util.make_atari_env(
        "BreakoutNoFrameskip-v4",
        n_envs=2,
        seed=5,
        monitor_dir=str(tmp_path),
        vec_env_cls=getattr(vec_env, vector),
        vec_env_kwargs=kwargs,
    )
    envs = vec_env.VecFrameStack(envs, n_stack=4)
    ours = make()
    ours.seed(5)
    try:
        assert np.array_equal(envs.reset().transpose(0, 3, 1, 2), ours.reset())
        for one, other in zip(rollout(envs, 200), rollout(ours, 200), strict=True):
            np.testing.assert_array_equal(one[0].transpose(0, 3, 1, 2), other[0])
            np.testing.assert_array_equal(one[1:], other[1:])
        assert [space.n for space in envs.get_attr("action_space")] == [4, 4]
        page = str(page_of(envs))
        assert page.startswith("<p>2 environments</p>")
        assert page.count("<img") == 2
        if vector == "DummyVecEnv":  # ale-py's interface cannot be pickled either
            assert all(isinstance(env, atari.AtariEnv) for env in envs.get_attr("unwrapped"))
            assert [interface.lives() for interface in ours.get_attr("ale")] == [
                env.unwrapped.ale.lives() for env in envs.get_attr("unwrapped")
            ]
    finally:
        envs.close()


SPAWN = """
import sys
import numpy as np
from stable_baselines3.common.env_util import make_atari_env
from stable_baselines3.common.vec_env import SubprocVecEnv

if __name__ == "__main__":
    options = {"vec_env_cls": SubprocVecEnv, "vec_env_kwargs": {"start_method": "spawn"}}
    envs = make_atari_env("atari:BreakoutNoFrameskip-v4", n_envs=2, seed=5, **options)
    np.savez("steps.npz", envs.reset(), *(envs.step(np.array([2, 3]))[0] for _ in range(30)))
    print(envs.get_attr("spec")[1].entry_point)
    envs.close()
"""


def test_spawned_processes_that_do_not_import_the_package(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(SPAWN)
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stdout) == (0, "atari.registry.making:make_AtariEnv\n"), done.stderr
    ours = make()
    ours.seed(5)
    expected = [ours.reset(), *(ours.step(np.array([2, 3]))[0] for _ in range(30))]
    with np.load(tmp_path / "steps.npz") as steps:
        for name, observation in zip(steps, expected, strict=True):
            np.testing.assert_array_equal(steps[name][..., 0], observation[:, -1])


def test_attributes_are_those_of_one_environment() -> None:
    envs = make(num_envs=3)
    envs.reset()
    assert envs.get_attr("action_space") == [envs.action_space] * 3
    assert envs.get_attr("observation_space", [0, 2]) == [envs.observation_space] * 2
    assert isinstance(envs.get_attr("action_space", 0)[0], gymnasium.spaces.Discrete)
    ale = envs.get_attr("ale")[1]
    assert (ale.lives(), ale.getFrameNumber() > 0, ale.getRAMSize()) == (5, True, 128)
    ale.setRAM(5, 77)
    assert ale.getRAM()[5] == ale.getRAM(np.empty(128, np.uint8))[5] == 77
    assert ale.getScreenRGB().shape == (*ale.getScreenDims(), 3)
    with pytest.raises(AttributeError, match="act"):
        ale.act(0)
    with pytest.raises(ValueError, match=r"must be a uint8 array of shape \(128,\)"):
        ale.getRAM(np.empty(3, np.uint8))


def test_a_second_stack_warns() -> None:
    from stable_baselines3.common.vec_env import VecFrameStack, VecNormalize

    with pytest.warns(UserWarning, match="which are stacks already; leave VecFrameStack out"):
        VecFrameStack(VecNormalize(make(), norm_obs=False), 4).reset()


@pytest.mark.filterwarnings("error")
def test_a_first_stack_does_not_warn() -> None:
    from stable_baselines3.common.vec_env import VecFrameStack

    envs = VecFrameStack(make(preset=None, stack_num=1), 4, channels_order="first")
    assert envs.reset().shape == (2, 4, 84, 84)
    make().reset()


@pytest.mark.parametrize("algorithm", ["ppo", "dqn"])
def test_the_zoo_trains_and_plays(algorithm: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the zoo's own hyperparameters for Atari, whose `env_wrapper` is SB3's `AtariWrapper`."""
    pytest.importorskip("rl_zoo3", reason="rl_zoo3 is not installed")
    import torch
    from rl_zoo3 import enjoy, train

    torch.set_num_threads(1)
    small = {
        "ppo": ["n_envs:2", "n_steps:16", "batch_size:16", "n_epochs:1"],
        "dqn": ["buffer_size:200", "learning_starts:40"],
    }[algorithm]
    monkeypatch.chdir(tmp_path)
    common = ["--algo", algorithm, "--env", "BreakoutNoFrameskip-v4", "--gym-packages", "atari", "--device", "cpu"]
    training = ["-n", "96", "--log-folder", "logs", "--eval-freq", "-1", "--num-threads", "1", "--hyperparams", *small]
    monkeypatch.setattr(sys, "argv", ["train.py", *common, "--seed", "1", *training])
    train.train()
    assert list(tmp_path.glob(f"logs/{algorithm}/BreakoutNoFrameskip-v4_1/BreakoutNoFrameskip-v4.zip"))
    assert str(gymnasium.spec("BreakoutNoFrameskip-v4").entry_point) == "atari.registry.making:make_AtariEnv"
    monkeypatch.setattr(sys, "argv", ["enjoy.py", *common, "-f", "logs", "--exp-id", "1", "--no-render", "-n", "40"])
    enjoy.enjoy()
