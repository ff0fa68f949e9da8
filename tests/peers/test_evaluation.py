"""`atari.learning` beside others: models of Stable-Baselines3, TorchScript and ONNX files, statistics of rliable."""

import ale_py
import numpy as np
import pytest

from atari.learning import Published, compare, evaluate, load_policy
from atari.learning.evaluation.evaluate import episode_seed
from atari.learning.evaluation.statistics import estimate_of_runs, profile

pytestmark = pytest.mark.peers

EPISODES = 3


def trained(name, folder, obs_type="grayscale"):
    """A model after a few steps, in a file."""
    import sb3_contrib
    import stable_baselines3

    from atari.sb3 import AtariVecEnv

    preset = {"preset": "baselines"} if obs_type == "grayscale" else {"obs_type": "ram"}
    envs = AtariVecEnv("breakout", 2, **preset)
    options = {
        "PPO": {"n_steps": 16, "batch_size": 16, "n_epochs": 1},
        "A2C": {},
        "DQN": {"buffer_size": 100, "learning_starts": 20},
        "QRDQN": {"buffer_size": 100, "learning_starts": 20},
    }[name]
    policy = "CnnPolicy" if obs_type == "grayscale" else "MlpPolicy"
    module = sb3_contrib if name == "QRDQN" else stable_baselines3
    model = getattr(module, name)(policy, envs, seed=0, device="cpu", **options)
    model.learn(64)
    model.save(folder / "model.zip")
    envs.close()
    return model


def scores_of_sb3(model, game):
    """The scores of Stable-Baselines3's own wrappers on ale-py and its `evaluate_policy`, for the same seeds."""
    from stable_baselines3.common.atari_wrappers import AtariWrapper
    from stable_baselines3.common.evaluation import evaluate_policy
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import DummyVecEnv, VecFrameStack, VecTransposeImage

    scores = []
    for episode in range(EPISODES):
        env = ale_py.AtariEnv(game, frameskip=1, repeat_action_probability=0.0, max_num_frames_per_episode=108_000)
        envs = VecTransposeImage(VecFrameStack(DummyVecEnv([lambda env=env: AtariWrapper(Monitor(env))]), 4))
        envs.seed(episode_seed(0, game, episode))
        rewards, _ = evaluate_policy(model, envs, 1, deterministic=True, return_episode_rewards=True)
        scores.append(float(rewards[0]))
    return tuple(scores)


@pytest.mark.parametrize("name", ["PPO", "A2C", "DQN", "QRDQN"])
def test_scores_are_those_of_sb3s_evaluate_policy(name, tmp_path):
    model = trained(name, tmp_path)
    policy = load_policy(tmp_path / "model.zip")
    assert policy.name == f"{name} (model.zip)"
    assert policy.training_frames == 4 * model.num_timesteps
    result = evaluate(policy, "breakout", "baselines", episodes=EPISODES, num_envs=1)
    assert result["breakout"].scores == scores_of_sb3(model, "breakout")


def test_sampled_actions_have_the_models_probabilities(tmp_path):
    import torch

    model = trained("PPO", tmp_path)
    policy = load_policy(tmp_path / "model.zip", sample=True)
    observations = np.random.default_rng(0).integers(0, 256, (1, 4, 84, 84), np.uint8)
    tensor, _ = model.policy.obs_to_tensor(observations)
    with torch.no_grad():
        expected = model.policy.get_distribution(tensor).distribution.probs.numpy()[0]
    policy.begin("breakout", ("NOOP", "FIRE", "RIGHT", "LEFT"), np.arange(1), np.array([3]))
    drawn = [int(policy(observations, np.arange(1))[0]) for _ in range(2000)]
    np.testing.assert_allclose(np.bincount(drawn, minlength=4) / 2000, expected, atol=0.05)


def test_a_model_of_ram(tmp_path):
    trained("PPO", tmp_path, "ram")
    policy = load_policy(tmp_path / "model.zip")
    assert policy.environment["obs_type"] == "ram"
    assert evaluate(policy, "breakout", "dqn2015", episodes=2)["breakout"].scores


def test_damaged_models(tmp_path):
    import zipfile

    trained("PPO", tmp_path)
    with zipfile.ZipFile(tmp_path / "model.zip") as whole, zipfile.ZipFile(tmp_path / "bad.zip", "w") as bad:
        for name in whole.namelist():
            bad.writestr(name, whole.read(name) if name != "policy.pth" else b"damaged")
    with pytest.raises(ValueError, match=r"bad\.zip cannot be loaded as a model of PPO"):
        load_policy(tmp_path / "bad.zip")


def network():
    import torch

    torch.manual_seed(0)
    return torch.nn.Sequential(torch.nn.Flatten(), torch.nn.Linear(2 * 42 * 42, 4)).eval()


def test_torch_script(tmp_path):
    import torch

    class Scores(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.network = network()

        def forward(self, observations: torch.Tensor) -> torch.Tensor:
            return self.network(observations / 255.0)

    environment = '{"img_height": 42, "img_width": 42, "stack_num": 2, "full_action_space": false}'
    file = tmp_path / "policy.pt"
    torch.jit.save(torch.jit.script(Scores()), file, _extra_files={"environment.json": environment})
    policy = load_policy(file)
    assert policy.environment["stack_num"] == 2
    plain = network()

    def scores(observations):
        with torch.no_grad():
            return plain(torch.from_numpy(observations) / 255.0).argmax(1).numpy()

    scores.environment = policy.environment
    expected = evaluate(scores, "breakout", "dqn2015", episodes=2)
    assert evaluate(policy, "breakout", "dqn2015", episodes=2).games == expected.games

    file.write_bytes(file.read_bytes()[:-200])
    with pytest.raises(ValueError, match=r"policy\.pt"):
        load_policy(file)
    torch.save(plain.state_dict(), file)
    with pytest.raises(ValueError, match="weights without a network"):
        load_policy(file)


@pytest.mark.parametrize("dtype", ["UINT8", "FLOAT"])
def test_onnx(tmp_path, dtype):
    onnx = pytest.importorskip("onnx")
    helper, kinds = onnx.helper, onnx.TensorProto
    weights = np.random.default_rng(0).normal(size=(128, 4)).astype(np.float32)
    graph = helper.make_graph(
        [
            helper.make_node("Cast", ["ram"], ["floats"], to=kinds.FLOAT),
            helper.make_node("MatMul", ["floats", "weights"], ["scores"]),
        ],
        "policy",
        [helper.make_tensor_value_info("ram", getattr(kinds, dtype), ["n", 128])],
        [helper.make_tensor_value_info("scores", kinds.FLOAT, ["n", 4])],
        [onnx.numpy_helper.from_array(weights, "weights")],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    file = tmp_path / "policy.onnx"
    onnx.save(model, file)

    def scores(observations):
        return (observations.astype(np.float32) @ weights).argmax(1)

    scores.environment = {"obs_type": "ram"}
    expected = evaluate(scores, "breakout", "dqn2015", episodes=2)
    assert evaluate(load_policy(file), "breakout", "dqn2015", episodes=2).games == expected.games
    file.write_bytes(b"damaged")
    with pytest.raises(ValueError, match="no ONNX file"):
        load_policy(file)


def test_plot(tmp_path):
    result = evaluate("random", ["breakout", "pong"], "dopamine", episodes=2)
    comparison = compare(result, ["dopamine/rainbow", "cleanrl/ppo"], mixed=True)
    comparison.plot(tmp_path / "comparison.svg")
    assert (tmp_path / "comparison.svg").read_text().startswith("<?xml")
    with pytest.raises(ValueError, match="xyz"):
        comparison.plot(tmp_path / "comparison.xyz")


@pytest.mark.parametrize("name", ["dopamine/rainbow", "dreamerv3/atari57/ppo"])
def test_summaries_and_intervals_are_those_of_rliable(name):
    from rliable import library, metrics

    agent, human = Published(name), Published.human_scores()
    games = [game for game in agent.games if game in human and len(agent.final(game)) == 5]
    scores = {game: (agent.final(game) - human[game][0]) / (human[game][1] - human[game][0]) for game in games}
    matrix = np.stack(list(scores.values()), 1)

    def aggregate(runs):
        names = (metrics.aggregate_median, metrics.aggregate_mean, metrics.aggregate_iqm)
        return np.array([each(runs) for each in names])

    values, intervals = library.get_interval_estimates({"agent": matrix}, aggregate, reps=4000)
    ours = estimate_of_runs(scores, 4000, 0)
    for number, summary in enumerate(("median", "mean", "iqm")):
        assert ours[summary].value == pytest.approx(values["agent"][number], rel=1e-12)
        low, high = intervals["agent"][:, number]
        assert ours[summary].low == pytest.approx(low, abs=0.05 * (high - low) + 0.001)
        assert ours[summary].high == pytest.approx(high, abs=0.05 * (high - low) + 0.001)
    thresholds = np.linspace(0, 8, 50)
    profiles, _ = library.create_performance_profile({"agent": matrix}, thresholds, reps=10)
    np.testing.assert_allclose(profile(scores, thresholds), profiles["agent"], atol=1e-12)
