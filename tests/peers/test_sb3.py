"""`atari.sb3.AtariVecEnv` beside Stable-Baselines3's own vector environment, and under its algorithms."""

from typing import Any

import ale_py
import numpy as np
import pytest

import atari

pytestmark = pytest.mark.peers


def make(game: Any = "breakout", num_envs: int | None = 2, **options: Any) -> Any:
    from atari.sb3 import AtariVecEnv

    return AtariVecEnv(game, num_envs, **options)


def theirs(game: str, num_envs: int, **options: Any) -> Any:
    """ale-py's environment in `make_atari_env` and `VecFrameStack`."""
    from stable_baselines3.common.atari_wrappers import AtariWrapper
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import DummyVecEnv, VecFrameStack

    def one() -> Any:
        env = ale_py.AtariEnv(game, frameskip=1, repeat_action_probability=0.0, **options)
        return AtariWrapper(Monitor(env))

    return VecFrameStack(DummyVecEnv([one] * num_envs), 4)


@pytest.mark.parametrize(("game", "steps"), [("breakout", 500), ("ms_pacman", 900), ("qbert", 500), ("frogger", 500)])
def test_it_is_theirs_to_the_byte_with_returns_of_whole_games(game: str, steps: int) -> None:
    ours, expected = make(game, 3, preset="baselines"), theirs(game, 3)
    assert ours.seed(3) == expected.seed(3) == [3, 4, 5]
    observation, expected_observation = ours.reset(), expected.reset()
    rng = np.random.default_rng(0)
    lives_lost = games_over = 0
    for _ in range(steps):
        np.testing.assert_array_equal(observation, expected_observation.transpose(0, 3, 1, 2))
        actions = rng.integers(ours.action_space.n, size=3)
        observation, reward, done, infos = ours.step(actions)
        expected_observation, expected_reward, expected_done, expected_infos = expected.step(actions)
        assert reward.dtype == expected_reward.dtype
        np.testing.assert_array_equal(reward, expected_reward)
        np.testing.assert_array_equal(done, expected_done)
        for info, other in zip(infos, expected_infos, strict=True):
            assert info["lives"] >= 0
            assert info["TimeLimit.truncated"] == other["TimeLimit.truncated"]
            assert ("terminal_observation" in info, "episode" in info) == (
                "terminal_observation" in other,
                "episode" in other,
            )
            if "terminal_observation" in info:
                lives_lost += 1
                last = other["terminal_observation"].transpose(2, 0, 1)
                np.testing.assert_array_equal(info["terminal_observation"], last)
            if "episode" in info:
                games_over += 1
                assert (info["episode"]["r"], info["episode"]["l"]) == (other["episode"]["r"], other["episode"]["l"])
                assert info["episode"]["t"] > 0
    assert lives_lost > games_over > 2


def test_a_limit_of_frames_is_a_truncation() -> None:
    envs = make("pong", 2, max_num_frames_per_episode=40)
    envs.reset()
    infos: list[dict[str, Any]]
    for step in range(1, 21):
        _, _, done, infos = envs.step(np.zeros(2, int))
        assert done.tolist() == [step % 10 == 0] * 2
        assert [info["TimeLimit.truncated"] for info in infos] == done.tolist()
    assert [40 <= info["episode"]["l"] < 70 for info in infos] == [True, True]


def test_what_it_returns_is_the_callers() -> None:
    envs = make()
    kept = [envs.reset()]
    copies = [kept[0].copy()]
    for _ in range(4):
        kept.append(envs.step(np.array([1, 2]))[0])
        copies.append(kept[-1].copy())
    assert all(np.array_equal(one, other) for one, other in zip(kept, copies, strict=True))


@pytest.mark.parametrize(
    ("options", "shape"),
    [
        ({}, (4, 84, 84)),
        ({"obs_type": "rgb", "img_height": 40, "img_width": 30}, (12, 40, 30)),
        ({"obs_type": "ram"}, (128,)),
    ],
)
def test_channels_are_first(options: dict[str, Any], shape: tuple[int, ...]) -> None:
    envs = make(**options)
    plain = atari.AtariVectorEnv("breakout", 2, autoreset_mode="SameStep", **options)
    envs.seed(4)
    observation = envs.reset()
    expected = plain.reset(seed=4)[0]
    assert observation.shape == (2, *shape)
    assert envs.observation_space.shape == shape
    assert observation[0] in envs.observation_space
    if expected.ndim == 5:
        assert np.array_equal(observation[:, 3:6], expected[:, 1].transpose(0, 3, 1, 2))
    else:
        assert np.array_equal(observation, expected)


def test_dicts() -> None:
    envs = make(obs_type="dict", max_num_frames_per_episode=4)
    observation = envs.reset()
    assert {name: part.shape for name, part in observation.items()} == {"image": (2, 4, 84, 84), "ram": (2, 128)}
    _, _, done, infos = envs.step(np.zeros(2, int))
    assert done.all()
    assert infos[0]["terminal_observation"] in envs.observation_space


def test_a_lost_life_that_is_only_reported_ends_no_game() -> None:
    envs = make("breakout", 1, life_loss_info=True)
    envs.seed(0)
    envs.reset()
    ends = []
    for step in range(900):
        observation, _, done, (info,) = envs.step(np.array([1 if step % 10 == 0 else 0]))
        if done[0]:
            ends.append("episode" in info)
            assert ends[-1] or np.array_equal(info["terminal_observation"], observation[0])
            if ends[-1]:
                break
    assert ends == [False] * 4 + [True]


def test_rewards_are_clipped_on_request_and_returns_never() -> None:
    def returns(**options: Any) -> tuple[float, float]:
        envs = make("seaquest", 1, max_num_frames_per_episode=1600, **options)
        envs.seed(0)
        envs.reset()
        rng = np.random.default_rng(1)
        total = 0.0
        while True:
            _, reward, done, (info,) = envs.step(rng.integers(18, size=1))
            total += float(reward[0])
            if done[0]:
                return total, info["episode"]["r"]

    clipped, episode = returns()
    assert 0 < clipped < episode
    assert returns(reward_clipping=True) == (clipped, episode)
    assert returns(reward_clipping=False) == (episode, episode)


def test_attributes_and_methods() -> None:
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import VecNormalize

    envs = make("breakout", 3, render_mode="rgb_array")
    envs.reset()
    assert envs.get_attr("lives") == [5, 5, 5]
    assert envs.get_attr("render_mode", 1) == ["rgb_array"]
    assert not envs.has_attr("colour")
    envs.set_attr("difficulty", 1, indices=[0, 2])
    assert envs.get_attr("difficulty") == [1, 0, 1]
    with pytest.raises(ValueError, match="breakout has no mode 7"):
        envs.set_attr("mode", 7, indices=1)
    assert envs.env_method("get_action_meanings", indices=[2]) == [["NOOP", "FIRE", "RIGHT", "LEFT"]]
    envs.env_method("set_ram", 5, 77, indices=0)
    assert [ram[5] == 77 for ram in envs.env_method("ram")] == [True, False, False]
    assert envs.env_is_wrapped(Monitor) == [True, True, True]
    assert envs.env_is_wrapped(VecNormalize, indices=[1]) == [False]
    assert [image.shape for image in envs.get_images()] == [(210, 160, 3)] * 3
    assert envs.render().shape == (420, 320, 3)


def test_seeds_are_used_once() -> None:
    envs = make("alien", 2, obs_type="ram")
    envs.seed(7)
    first = envs.reset()
    assert any(not np.array_equal(envs.reset(), first) for _ in range(5))
    envs.seed(7)
    assert np.array_equal(envs.reset(), first)
    assert all(0 <= seed < 2**31 for seed in envs.seed())
    for bad in (-1, 2**32):
        with pytest.raises(ValueError, match="seed must be within 0"):
            envs.seed(bad)
    envs.reset()


def test_options_of_a_reset_are_checked_and_used_once() -> None:
    envs, single = make("pong", 3), atari.AtariEnv("pong")
    with pytest.raises(TypeError) as expected:
        single.reset(options={"level": 2})
    for wrong in ({"level": 2}, [{}, {"level": 2}, {}]):
        with pytest.raises(TypeError) as refused:
            envs.set_options(wrong)
        assert str(refused.value) == str(expected.value)
    for unequal in ([{}], [{"new_game": True}, {}, {}]):
        with pytest.raises(ValueError, match="a dict, or 3 equal dicts"):
            envs.set_options(unequal)
    envs.set_options([{"new_game": True}] * 3)
    assert envs._options == [{"new_game": True}] * 3
    envs.reset()
    assert envs._options == [{}] * 3


@pytest.mark.parametrize("name", ["autoreset_mode", "batch_size"])
def test_what_it_decides_itself_is_refused(name: str) -> None:
    with pytest.raises(TypeError, match=f"decides about {name}; leave it out"):
        make(**{name: 0})


def parameters(model: Any) -> Any:
    """All weights of a model's policy in one array."""
    return np.concatenate([value.detach().numpy().ravel().copy() for value in model.policy.parameters()])


def registered(seed: int) -> Any:
    """Stable-Baselines3's environments by `make_atari_env`, which takes a registered ID, stacked."""
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


def seeded(seed: int, preset: str = "baselines") -> Any:
    envs = make("breakout", 4, preset=preset, channels_last=True)
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
def test_it_learns_the_same_weights_as_on_theirs(algorithm: str) -> None:
    import torch

    steps = 2048
    ours = weights(algorithm, seeded(3), steps)
    theirs = weights(algorithm, registered(3), steps)
    assert ours.keys() == theirs.keys()
    for name, value in ours.items():
        assert torch.equal(value, theirs[name]), name


def test_weights_depend_on_the_environments() -> None:
    """So that the test above can fail."""
    import torch

    ours = weights("PPO", seeded(3), 1024)
    other = weights("PPO", seeded(3, "dopamine"), 1024)
    assert any(not torch.equal(value, other[name]) for name, value in ours.items())


def test_ppo_learns_from_ram() -> None:
    from stable_baselines3 import PPO

    envs = make("pong", 8, obs_type="ram", max_num_frames_per_episode=800)
    model = PPO("MlpPolicy", envs, n_steps=128, batch_size=256, n_epochs=2, seed=0, device="cpu")
    before = parameters(model)
    model.learn(4096)
    assert not np.array_equal(parameters(model), before)
    assert -10 < np.mean([game["r"] for game in model.ep_info_buffer]) < 0


def test_the_replay_buffer_of_dqn_is_right() -> None:
    from stable_baselines3 import DQN

    envs = make("pong", 4, preset="baselines")
    options: dict[str, Any] = {"buffer_size": 3000, "learning_starts": 3000}
    model = DQN("CnnPolicy", envs, seed=0, device="cpu", **options)
    model.learn(2560)
    memory = model.replay_buffer
    assert memory is not None
    now, after, ends = memory.observations[:600], memory.next_observations[:600], memory.dones[:600] > 0
    assert np.array_equal(after[:-1][~ends[:-1]], now[1:][~ends[:-1]])


def test_rewards_of_the_noops_of_a_reset_are_part_of_a_game() -> None:
    """In Skiing every frame costs a reward."""
    ours, expected = make("skiing", 1, preset="baselines"), theirs("skiing", 1)
    for envs in (ours, expected):
        envs.seed(3)
        envs.reset()
    done = np.zeros(1, bool)
    while not done[0]:
        _, _, done, (info,) = ours.step(np.zeros(1, int))
        *_, (other,) = expected.step(np.zeros(1, int))
    assert (info["episode"]["r"], info["episode"]["l"]) == (other["episode"]["r"], other["episode"]["l"])
