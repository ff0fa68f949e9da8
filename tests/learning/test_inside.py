"""Inside policies of PyTorch: scores, values, probabilities and features, and the formats without them.

`tests/peers/test_inside.py` has the formats of other packages.
"""

from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from small_trainings import make_options  # noqa: E402

from atari.learning import ScoresPolicy, load_policy  # noqa: E402
from atari.learning.training import Training  # noqa: E402
from atari.policy.inside import FORMATS, METHODS, SAMPLED  # noqa: E402


def methods_of(policy: Any) -> tuple[str, ...]:
    return tuple(method for method in METHODS if hasattr(policy, method))


def test_sampled_formats_have_scores() -> None:
    assert all("scores" in FORMATS[name] and "probabilities" not in FORMATS[name] for name in SAMPLED)


def images(count: int = 3) -> Any:
    return np.random.default_rng(0).integers(0, 256, (count, 2, 42, 42), np.uint8)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs")
    for agent in ("ppo", "pqn", "dqn"):
        options = {"dueling": True} if agent == "dqn" else {}
        with closing(
            Training.begin(agent, make_options(agent, total_steps=640, **options), folder / agent)
        ) as training:
            training.save()
    return folder


def test_an_actor_critic_shows_everything(runs: Path) -> None:
    policy = load_policy(runs / "ppo")
    assert methods_of(policy) == FORMATS["run folders of PPO"]
    seen = images()
    with torch.no_grad():
        logits, values = policy.network(torch.from_numpy(seen))
        features = policy.network.encoder(torch.from_numpy(seen))
    for found, expected in (
        (policy.scores(seen), logits),
        (policy.values(seen), values),
        (policy.features(seen), features),
        (policy.probabilities(seen), logits.softmax(1)),
    ):
        assert found.dtype == np.float32
        np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("agent", ["pqn", "dqn"])
def test_the_value_of_a_state_is_its_best_action_value(runs: Path, agent: str) -> None:
    policy = load_policy(runs / agent)
    assert methods_of(policy) == FORMATS["run folders of PQN and DQN"]
    seen = images(5)
    scores = policy.scores(seen)
    assert scores.shape == (5, 6)
    np.testing.assert_array_equal(policy.values(seen), scores.max(1))
    assert policy(seen, np.arange(5)).tolist() == scores.argmax(1).tolist()
    with torch.no_grad():
        expected = policy.network.encoder(torch.from_numpy(seen))
    np.testing.assert_array_equal(policy.features(seen), expected)
    drawn = load_policy(runs / agent, sample=True).probabilities(seen)
    np.testing.assert_allclose(drawn, torch.from_numpy(scores).softmax(1), rtol=1e-5)


class Net(torch.nn.Module):  # type: ignore[misc]
    def __init__(self) -> None:
        super().__init__()
        self.hidden, self.out = torch.nn.Linear(128, 5), torch.nn.Linear(5, 4)
        self.unused = torch.nn.Linear(4, 4)

    def forward(self, ram: torch.Tensor) -> torch.Tensor:
        return self.out(torch.relu(self.hidden(ram / 255.0)))


def test_a_network_of_pytorch_shows_its_last_hidden_layer(tmp_path: Path) -> None:
    network = Net()
    policy = load_policy(network)
    assert methods_of(policy) == FORMATS["networks of PyTorch"]
    assert policy.network is network
    ram = np.random.default_rng(1).integers(0, 256, (2, 128), np.uint8)
    with torch.no_grad():
        expected = torch.relu(network.hidden(torch.from_numpy(ram) / 255.0))
    np.testing.assert_array_equal(policy.features(ram), expected)
    assert network.training
    assert not network.out._forward_pre_hooks
    assert methods_of(load_policy(network, sample=True)) == ("scores", "probabilities", "features", "network")

    torch.jit.script(network).save(tmp_path / "net.pt")
    script = load_policy(tmp_path / "net.pt")
    assert methods_of(script) == FORMATS["TorchScript files"]
    np.testing.assert_allclose(script.scores(ram), policy.scores(ram), rtol=1e-6)
    assert methods_of(load_policy(torch.nn.Flatten())) == ("scores", "network")  # no linear layer


def test_new_weights_of_the_network_are_those_of_the_policy(runs: Path) -> None:
    policy = load_policy(runs / "pqn")
    before = policy.features(images())
    for part in policy.network.modules():
        if hasattr(part, "reset_parameters"):
            part.reset_parameters()
    assert np.abs(policy.features(images()) - before).max() > 0.01


def test_an_absent_method_names_the_formats_that_have_it() -> None:
    for name in ("random", "noop"):
        assert methods_of(load_policy(name)) == FORMATS["random and noop"]
    with pytest.raises(
        AttributeError, match="policy random has no values; these have: run folders of PPO; run folders"
    ):
        load_policy("random").values(images())
    policy = load_policy(ScoresPolicy(lambda seen: np.zeros((len(seen), 4)), name="mine"))
    assert methods_of(policy) == ("scores",)
    text = r"policy mine has no probabilities; .*PPO, A2C; .*; ONNX files loaded with sample=True; objects with an attribute"
    with pytest.raises(AttributeError, match=text):
        policy.probabilities(images())
    with pytest.raises(AttributeError, match="policy mine has no network"):
        _ = policy.network


def test_an_object_has_the_methods_that_its_author_gives_it() -> None:
    class Mine:
        def __call__(self, seen: Any) -> Any:
            return [0] * len(seen)

        def values(self, seen: Any) -> Any:
            return np.ones(len(seen), np.float32)

    assert methods_of(load_policy(Mine())) == ("values",)
    own = ScoresPolicy(
        lambda seen: np.zeros((len(seen), 4)),
        logits=True,
        values=lambda seen: seen[:, 0] / 2,
        features=lambda seen: seen,
    )
    ram = np.full((2, 128), 3, np.uint8)
    assert own.values(ram).tolist() == [1.5, 1.5]
    assert own.probabilities(ram).tolist() == [[0.25] * 4] * 2
    with pytest.raises(
        ValueError, match=r"must return floats \(n, width\) here, for 2 observations, got uint8 \(2, 128"
    ):
        own.features(ram)


def test_wrong_observations_are_refused(runs: Path) -> None:
    policy = load_policy(runs / "ppo")
    for method in ("scores", "values", "probabilities", "features"):
        with pytest.raises(ValueError, match=r"takes observations uint8 \(3, 2, 42, 42\), got uint8 \(3, 42, 42\)"):
            getattr(policy, method)(np.zeros((3, 42, 42), np.uint8))
        with pytest.raises(TypeError, match="a NumPy array, got NoneType"):
            getattr(policy, method)(None)
    acts = load_policy(ScoresPolicy(lambda seen: np.zeros(len(seen), np.int64)))
    with pytest.raises(ValueError, match=r"floats \(n, actions\) here, for 3 observations, got int64 \(3,\)"):
        acts.scores(images())
