"""`AtariTorchRLEnv`: TorchRL's specs, checks, partial resets and collectors around a vector environment."""

from typing import Any

import numpy as np
import pytest

import atari

pytestmark = pytest.mark.peers
torch = pytest.importorskip("torch", reason="needs PyTorch, which scripts/test --peers installs")
pytest.importorskip("torchrl", reason="needs TorchRL, which scripts/test --peers installs")

OPTIONS = {"frameskip": (2, 5), "max_num_frames_per_episode": 60}  # so that episodes end one by one


def make(**options: Any) -> atari.AtariVectorEnv:
    return atari.AtariVectorEnv("breakout", 3, autoreset_mode="Disabled", **{**OPTIONS, **options})


def wrap(**options: Any) -> Any:
    from atari.integrations.torchrl import AtariTorchRLEnv

    return AtariTorchRLEnv(make(**options))


def test_a_game_instead_of_environments() -> None:
    from atari.integrations.torchrl import AtariTorchRLEnv

    task = atari.Task.of("pong", obs_type="ram")
    for made in (AtariTorchRLEnv(task, num_envs=2), AtariTorchRLEnv("ALE/Pong-v5", num_envs=2, obs_type="ram")):
        assert made.task == task
        assert made.rollout(3)["observation"].shape == (2, 3, 128)


@pytest.mark.parametrize("options", [{}, {"obs_type": "ram"}, {"obs_type": "dict"}, {"continuous": True}], ids=str)
def test_its_checks_pass(options: Any) -> None:
    from torchrl.envs.utils import check_env_specs

    check_env_specs(wrap(**options))
    check_env_specs(wrap(**options), break_when_any_done="both")


def test_data_are_those_of_a_twin() -> None:
    envs, twin = wrap(), make()
    envs.set_seed(7)
    data = envs.rollout(120, break_when_any_done=False)
    observation, info = twin.reset(seed=7)
    ends = 0
    for step in range(120):
        row = data[:, step]
        np.testing.assert_array_equal(row["observation"], observation)
        np.testing.assert_array_equal(row["lives"], info["lives"])
        observation, reward, terminated, truncated, info = twin.step(row["action"].numpy())
        following = row["next"]
        np.testing.assert_array_equal(following["observation"], observation)
        np.testing.assert_array_equal(following["reward"][:, 0], reward)
        np.testing.assert_array_equal(following["terminated"][:, 0], terminated)
        np.testing.assert_array_equal(following["truncated"][:, 0], truncated)
        done = terminated | truncated
        np.testing.assert_array_equal(following["done"][:, 0], done)
        ends += int(done.sum())
        if done.any():
            observation, info = twin.reset(options={"reset_mask": done})
    assert ends >= 9


def test_a_collector() -> None:
    from torchrl.collectors import Collector

    envs = wrap(obs_type="ram")
    collector = Collector(envs, None, frames_per_batch=60, total_frames=180)
    batches = list(collector)
    assert [batch["observation"].shape for batch in batches] == [(3, 20, 128)] * 3
    collector.shutdown()
    assert envs.is_closed


def test_what_it_cannot_use_is_named() -> None:
    from atari.integrations.torchrl import AtariTorchRLEnv

    with pytest.raises(ValueError, match="autoreset_mode='Disabled'"):
        AtariTorchRLEnv(atari.AtariVectorEnv("pong", 2))
    with pytest.raises(ValueError, match="leave batch_size out"):
        AtariTorchRLEnv(atari.AtariVectorEnv("pong", 2, batch_size=1, autoreset_mode="Disabled"))
    with pytest.raises(ValueError, match="one player"):
        AtariTorchRLEnv(atari.AtariVectorEnv("pong", 2, players=2, autoreset_mode="Disabled"))
