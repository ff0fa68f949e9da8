"""Stable-Baselines3 learns the same weights, to the bit, on `AtariVecEnv` and on its own environments."""

from typing import Any

import pytest

pytestmark = pytest.mark.peers


def own_environments(seed: int) -> Any:
    """Stable-Baselines3's environments around ale-py's, stacked."""
    import gymnasium
    from ale_py.env import AtariEnv
    from stable_baselines3.common.env_util import make_atari_env
    from stable_baselines3.common.vec_env import VecFrameStack

    def make(**options: Any) -> Any:
        options.pop("render_mode", None)
        return AtariEnv("breakout", frameskip=1, repeat_action_probability=0.0, **options)

    gymnasium.register("AleBreakout-v0", make, max_episode_steps=None)
    try:
        return VecFrameStack(make_atari_env("AleBreakout-v0", n_envs=4, seed=seed), 4)
    finally:
        del gymnasium.registry["AleBreakout-v0"]


def our_environments(seed: int) -> Any:
    from atari.sb3 import AtariVecEnv

    envs = AtariVecEnv("breakout", 4, preset="baselines", channels_last=True)
    envs.seed(seed)
    return envs


def weights(algorithm: str, envs: Any, steps: int) -> dict[str, Any]:
    import stable_baselines3
    import torch

    torch.set_num_threads(1)
    options: dict[str, Any] = {
        "PPO": {"n_steps": 128, "batch_size": 256, "n_epochs": 2},
        "DQN": {"buffer_size": 2000, "learning_starts": 200, "train_freq": 4, "target_update_interval": 400},
    }[algorithm]
    policy = {"net_arch": [16], "features_extractor_kwargs": {"features_dim": 16}}
    model = getattr(stable_baselines3, algorithm)(
        "CnnPolicy", envs, seed=3, device="cpu", policy_kwargs=policy, **options
    )
    model.learn(steps)
    return dict(model.policy.state_dict())


@pytest.mark.parametrize("algorithm", ["PPO", "DQN"])
def test_equal_weights(algorithm: str) -> None:
    import torch

    steps = 2048
    ours = weights(algorithm, our_environments(3), steps)
    theirs = weights(algorithm, own_environments(3), steps)
    assert ours.keys() == theirs.keys()
    for name, value in ours.items():
        assert torch.equal(value, theirs[name]), name


def test_weights_depend_on_the_environments() -> None:
    """So that the test above can fail."""
    import torch

    from atari.sb3 import AtariVecEnv

    ours = weights("PPO", our_environments(3), 1024)
    other = weights("PPO", AtariVecEnv("breakout", 4, preset="dopamine", channels_last=True), 1024)
    assert any(not torch.equal(value, other[name]) for name, value in ours.items())
