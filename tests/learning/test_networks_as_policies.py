"""Networks of PyTorch as policies: instances, classes, names, and errors for networks that do not fit."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from atari.learning import PROTOCOLS, evaluate, load_policy  # noqa: E402
from atari.learning.evaluation.protocols import EvaluationProtocol  # noqa: E402
from atari.task import Task  # noqa: E402

MODULE = """
import torch

class Net(torch.nn.Module):
    environment = {"preset": "baselines", "img_height": 42, "img_width": 42}

    def __init__(self, actions=6):
        super().__init__()
        torch.manual_seed(0)
        self.dropout = torch.nn.Dropout(0.5)
        self.layers = torch.nn.Sequential(torch.nn.Flatten(), torch.nn.Linear(4 * 42 * 42, actions))

    def forward(self, images):
        return self.layers(self.dropout(images / 255))
"""


@pytest.fixture
def net(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(__import__("sys").modules, "nets", raising=False)
    (tmp_path / "nets.py").write_text(MODULE + "\nnet = Net()\n")
    import nets  # type: ignore[import-not-found]

    return nets


def short() -> EvaluationProtocol:
    task = Task.of("pong", preset="baselines", max_num_frames_per_episode=400)
    return EvaluationProtocol.of_task(task, name="short", source="", epsilon=0.0, episodes=1)


def test_a_network_is_a_policy_in_every_form(net: Any, tmp_path: Any) -> None:
    torch.jit.script(net.Net()).save("net.pt", _extra_files={"environment.json": json.dumps(net.Net.environment)})
    forms = [net.Net, net.Net(), "nets:Net", "nets:net", "net.pt", net.Net().eval()]
    results = [evaluate(form, "pong", short()) for form in forms]
    assert len({(one.games[0].scores, one.games[0].frames) for one in results}) == 1
    assert results[0].games[0].observation["img_height"] == 42
    assert [one.policy for one in results] == ["Net", "Net", "nets:Net", "nets:net", "net.pt", "Net"]


def test_a_network_stays_in_its_mode(net: Any) -> None:
    module = net.Net()
    module.dropout.eval()
    policy = load_policy(module)
    images = np.full((3, 4, 42, 42), 255, np.uint8)
    assert len({*policy(images, np.arange(3)).tolist()}) == 1
    assert (module.training, module.dropout.training, module.layers.training) == (True, False, True)


def test_actions_of_a_network_are_drawn(net: Any) -> None:
    policy = load_policy(net.Net(), sample=True)
    policy.begin("pong", ("NOOP",) * 6, np.arange(1), np.arange(1))
    images = np.zeros((1, 4, 42, 42), np.uint8)
    assert len({int(policy(images, np.arange(1))[0]) for _ in range(100)}) > 2


def test_a_network_of_another_number_of_actions_or_shape_is_refused(net: Any) -> None:
    with pytest.raises(ValueError, match=r"Net gives scores of 3 actions, and in pong it has 6 \(NOOP"):
        evaluate(net.Net(3), "pong", short())
    module = net.Net()
    module.environment = {}
    with pytest.raises(ValueError, match=r"Net cannot be .* by 255 itself; it does not say .* environment.json"):
        evaluate(module, "pong", short())
    module.environment = {"preset": "baselines"}
    text = r"Net cannot be computed on observations uint8 \(1, 4, 84, 84\): .*shapes.*; a network takes observations as"
    with pytest.raises(ValueError, match=text):
        evaluate(module, "pong", short())
    assert module.training


def test_what_a_network_must_return(net: Any) -> None:
    def forward(returned: Any) -> Any:
        module = net.Net()
        module.forward = lambda images: returned
        module.environment = {}
        return load_policy(module)

    images = np.zeros((2, 4, 42, 42), np.uint8)
    for returned, text in [
        ((torch.zeros(2, 6), torch.zeros(2)), "Net must return one tensor, of scores or of actions, got tuple"),
        (torch.zeros(2, 6) / 0, "Net returned a score that is no number"),
        (
            torch.zeros(2),
            r"Net must return scores \(n, actions\), floats, or actions \(n,\), integers; got float32 \(2,\); it does not say",
        ),
        (torch.zeros(3, dtype=torch.int64), r"policy Net must return integers of shape \(2,\)"),
    ]:
        with pytest.raises(ValueError, match=text):
            forward(returned)(images, np.arange(2))
    assert forward(torch.ones(2, 6, dtype=torch.bfloat16))(images, np.arange(2)).tolist() == [0, 0]
    assert forward(torch.tensor([3, 4]))(images, np.arange(2)).tolist() == [3, 4]


def test_a_network_may_be_a_policy_itself() -> None:
    class Lanes(torch.nn.Module):  # type: ignore[name-defined, misc]
        name = "lanes"

        def forward(self, observations: Any, lanes: Any) -> Any:
            assert isinstance(observations, np.ndarray)
            return lanes + 1

    policy = load_policy(Lanes())
    assert (policy.name, policy(np.zeros((2, 128), np.uint8), np.arange(2)).tolist()) == ("lanes", [1, 2])


def test_a_network_carries_what_it_says() -> None:
    class Ram(torch.nn.Linear):  # type: ignore[name-defined, misc]
        task = Task.of("Pong-ram-v4")
        protocol = PROTOCOLS["dopamine"]
        training_frames = 1000

    policy = load_policy(Ram(128, 6))
    assert (policy.name, policy.task, policy.training_frames) == ("Ram", Ram.task, 1000)
    assert policy.protocol == PROTOCOLS["dopamine"]


@pytest.mark.parametrize(
    ("observations", "error", "got"),
    [
        (np.zeros((2, 4, 84, 84), np.uint8), ValueError, "got uint8 (2, 4, 84, 84)"),
        (np.zeros((3, 2, 42, 42), np.uint8), ValueError, "got uint8 (3, 2, 42, 42)"),
        (np.zeros((2, 2, 42, 42)), TypeError, "got float64 (2, 2, 42, 42)"),
        ([[0, 1], [2, 3]], TypeError, "a NumPy array, got list"),
    ],
)
def test_observations_that_a_run_does_not_take_are_refused(observations: Any, error: type[Exception], got: str) -> None:
    policy = load_policy(Path(__file__).parents[2] / "examples" / "breakout-pqn")
    lanes = np.arange(2)
    policy.begin("breakout", ("NOOP", "FIRE", "RIGHT", "LEFT"), lanes, lanes)
    with pytest.raises(error) as refused:
        policy(observations, lanes)
    assert f"pqn (breakout-pqn) takes observations uint8 (2, 2, 42, 42), {got}" in str(refused.value)
    assert policy(np.zeros((2, 2, 42, 42), np.uint8), lanes).shape == (2,)


def test_a_network_takes_arrays_of_numbers(net: Any) -> None:
    policy, lanes = load_policy(net.Net()), np.arange(1)
    for wrong in (None, [1, 2], np.array([None]), {"image": "text"}):
        with pytest.raises(TypeError, match="Net takes observations as a NumPy array of numbers, or a dict of them"):
            policy(wrong, lanes)
    with pytest.raises(ValueError, match=r"Net cannot be computed on observations uint8 \(1,\)"):
        policy(np.zeros(1, np.uint8), lanes)


def test_a_seed_of_the_attacker() -> None:
    observations = pytest.importorskip("attack.observations")
    observations.attack(1)
