"""TorchRL's `GymWrapper` around single and vector environments."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import atari

pytestmark = pytest.mark.peers


class Recorder(atari.AtariVectorEnv):
    """Keeps copies of the data before and after each step."""

    def reset(self, **arguments: Any) -> Any:
        observation, info = super().reset(**arguments)
        self.starts: list[Any] = []
        self.ends: list[Any] = []
        self.rewards: list[Any] = []
        self.last = observation.copy()
        return observation, info

    def step(self, actions: Any, out: Any = None) -> Any:
        self.starts.append(self.last)
        observation, reward, terminated, truncated, info = super().step(actions, out)
        self.last = observation.copy()
        end = self.last.copy()
        if "final_obs" in info:
            end[info["_final_obs"]] = info["final_obs"][info["_final_obs"]]
        self.ends.append(end)
        self.rewards.append(reward)
        return observation, reward, terminated, truncated, info


class PatientRecorder(Recorder):
    """Also records the resets of environments that are done."""

    def reset(self, *, options: Any = None, **arguments: Any) -> Any:
        if options is None:
            return super().reset(**arguments)
        observation, info = atari.AtariVectorEnv.reset(self, options=options, **arguments)
        self.last = observation.copy()
        return observation, info


def rollout(env: Any, steps: int) -> Any:
    """Steps of random actions over several episodes, after TorchRL's own checks."""
    import torch
    from torchrl.envs.libs.gym import GymWrapper
    from torchrl.envs.utils import check_env_specs

    wrapped = GymWrapper(env)
    check_env_specs(wrapped)
    torch.manual_seed(0)
    wrapped.set_seed(0)
    return wrapped.rollout(steps, break_when_any_done=False)


@pytest.mark.parametrize("mode", ["Disabled", "SameStep"])
@pytest.mark.parametrize("obs_type", ["grayscale", "ram"])
def test_a_vector_is_seen_as_it_is(mode: str, obs_type: Any) -> None:
    options = {"frameskip": (2, 5), "max_num_frames_per_episode": 40}  # so that episodes end one by one
    envs = PatientRecorder("breakout", 3, autoreset_mode=mode, obs_type=obs_type, **options)
    data = rollout(envs, 60)
    dones = data["next", "done"].numpy()[..., 0]
    assert (dones.sum(1) >= 3).all()
    assert not np.array_equal(dones[0], dones[1])
    np.testing.assert_array_equal(data["next", "truncated"].numpy()[..., 0], dones)
    np.testing.assert_array_equal(data["observation"].numpy(), np.stack(envs.starts, 1))
    np.testing.assert_array_equal(data["next", "observation"].numpy(), np.stack(envs.ends, 1))
    np.testing.assert_array_equal(data["next", "reward"].numpy()[..., 0], np.stack(envs.rewards, 1))
    for steps in (data["observation"].numpy(), data["next", "observation"].numpy()):
        assert all(np.any(steps[:, step] != steps[:, step + 1]) for step in range(59))


def test_a_mode_that_it_cannot_use_is_named() -> None:
    from torchrl.envs.libs.gym import GymWrapper

    with pytest.raises(RuntimeError, match="one of SAME_STEP or DISABLED"):
        GymWrapper(atari.AtariVectorEnv("breakout", 2))


def test_a_single_environment_with_a_preset() -> None:
    env, twin = (atari.make("breakout", preset="dqn2015") for _ in range(2))
    data = rollout(gymnasium.wrappers.TimeLimit(env, 25), 60)
    assert data["observation"].shape == (60, 4, 84, 84)
    assert data["next", "done"].numpy()[:, 0].tolist() == [step % 25 == 24 for step in range(60)]
    twin.reset(seed=0)
    observation, _ = twin.reset()
    for step in range(25):
        np.testing.assert_array_equal(data["observation"][step].numpy(), observation)
        observation, reward, *_ = twin.step(int(data["action"][step].argmax()))
        np.testing.assert_array_equal(data["next", "observation"][step].numpy(), observation)
        assert data["next", "reward"][step].item() == reward


@pytest.mark.parametrize("preset", ["dqn2015", "baselines", "dopamine", "envpool"])
def test_a_vector_with_a_preset(preset: str) -> None:
    envs = PatientRecorder("breakout", 2, preset=preset, autoreset_mode="Disabled")
    data = rollout(envs, 80)
    assert data["observation"].shape == (2, 80, 4, 84, 84)
    np.testing.assert_array_equal(data["next", "observation"].numpy(), np.stack(envs.ends, 1))
    np.testing.assert_array_equal(data["next", "reward"].numpy()[..., 0], np.stack(envs.rewards, 1))


@pytest.mark.parametrize("skip", [1, 4])
@pytest.mark.parametrize(("env_id", "shape"), [("ALE/Pong-ram-v5", (128,)), ("ALE/Pong-v5", (210, 160, 3))])
def test_a_registered_id(env_id: str, shape: tuple[int, ...], skip: int) -> None:
    """TorchRL calls the observation `pixels` if it has three dimensions, and replaces the frame skip of the ID."""
    from torchrl.envs.libs.gym import GymEnv

    env, twin = GymEnv(env_id, frame_skip=skip), gymnasium.make(env_id, frameskip=skip)
    assert GymEnv(env_id)._env.spec.kwargs["frameskip"] == 1
    env.set_seed(0)
    data = env.rollout(50)
    key = "pixels" if len(shape) == 3 else "observation"
    assert data[key].shape == (50, *shape)
    twin.reset(seed=0)
    observation, _ = twin.reset()
    for step in range(50):
        np.testing.assert_array_equal(data[key][step].numpy(), observation)
        observation, reward, *_ = twin.step(int(data["action"][step].argmax()))
        np.testing.assert_array_equal(data["next", key][step].numpy(), observation)
        assert data["next", "reward"][step].item() == reward


PROCESSES = """
import sys
from torchrl.envs import GymEnv, ParallelEnv

def make():
    return GymEnv("atari:ALE/Pong-v5")

if __name__ == "__main__":
    envs = ParallelEnv(2, make, mp_start_method="spawn")
    print(*envs.rollout(5)["pixels"].shape)
    envs.close()
"""


def test_processes(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(PROCESSES)
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stdout) == (0, "2 5 210 160 3\n"), done.stderr
