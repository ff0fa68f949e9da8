"""Inside policies of Stable-Baselines3 and ONNX; `tests/learning/test_inside.py` has those of PyTorch."""

import numpy as np
import pytest

from atari.learning import load_policy
from atari.policy.inside import FORMATS, METHODS

pytestmark = pytest.mark.peers


def methods_of(policy):
    return tuple(method for method in METHODS if hasattr(policy, method))


def model_of(name, file):
    """An untrained model in a file, as Stable-Baselines3 saves it."""
    import sb3_contrib
    import stable_baselines3

    from atari.sb3 import AtariVecEnv

    envs = AtariVecEnv("breakout", 2, preset="baselines")
    module = sb3_contrib if name == "QRDQN" else stable_baselines3
    options = {"buffer_size": 100} if name in ("DQN", "QRDQN") else {}
    model = getattr(module, name)("CnnPolicy", envs, seed=0, device="cpu", **options)
    model.save(file)
    envs.close()
    return model


@pytest.mark.parametrize("name", ["PPO", "A2C", "DQN", "QRDQN"])
def test_a_model_of_sb3_shows_what_its_policy_computes(name, tmp_path):
    import torch

    model = model_of(name, tmp_path / "model.zip")
    policy = load_policy(tmp_path / "model.zip")
    (format_,) = (one for one in FORMATS if one.startswith("models") and name in one.replace("QR-DQN", "QRDQN"))
    assert methods_of(policy) == FORMATS[format_]
    seen = np.random.default_rng(0).integers(0, 256, (3, 4, 84, 84), np.uint8)
    tensor, _ = model.policy.obs_to_tensor(seen)
    assert policy.features(seen).shape == (3, 512)
    with torch.no_grad():
        if name in ("PPO", "A2C"):
            distribution, values = (
                model.policy.get_distribution(tensor).distribution,
                model.policy.predict_values(tensor),
            )
            np.testing.assert_allclose(policy.probabilities(seen), distribution.probs, rtol=1e-5)
            np.testing.assert_allclose(policy.values(seen), values[:, 0], rtol=1e-5)
            features = model.policy.mlp_extractor.forward_actor(model.policy.extract_features(tensor))
            np.testing.assert_allclose(policy.features(seen), features, rtol=1e-4, atol=1e-6)
        else:
            expected = model.policy.q_net(tensor) if name == "DQN" else model.policy.quantile_net(tensor).mean(1)
            np.testing.assert_allclose(policy.scores(seen), expected, rtol=1e-5, atol=1e-7)
            np.testing.assert_array_equal(policy.values(seen), policy.scores(seen).max(1))


def test_an_onnx_file_shows_its_scores(tmp_path):
    onnx = pytest.importorskip("onnx")
    helper, kind = onnx.helper, onnx.TensorProto.FLOAT
    weights = np.random.default_rng(0).normal(size=(128, 4)).astype(np.float32)
    graph = helper.make_graph(
        [helper.make_node("MatMul", ["ram", "weights"], ["scores"])],
        "policy",
        [helper.make_tensor_value_info("ram", kind, ["n", 128])],
        [helper.make_tensor_value_info("scores", kind, ["n", 4])],
        [onnx.numpy_helper.from_array(weights, "weights")],
    )
    onnx.save(
        helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8), tmp_path / "policy.onnx"
    )
    policy = load_policy(tmp_path / "policy.onnx")
    assert methods_of(policy) == FORMATS["ONNX files"]
    ram = np.arange(256, dtype=np.uint8).reshape(2, 128)
    np.testing.assert_allclose(policy.scores(ram), ram.astype(np.float32) @ weights, rtol=1e-5)
    assert methods_of(load_policy(tmp_path / "policy.onnx", sample=True)) == ("scores", "probabilities")
