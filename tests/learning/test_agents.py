"""The agents: their targets are right, and a training that was killed goes on to the same weights."""

import copy
import pickle
import signal
import subprocess
import sys
import time
from contextlib import closing
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from crash_trainings import outcome  # noqa: E402
from small_trainings import SUPPORT, make_options  # noqa: E402

from atari.learning import Replicas, TrainingOptions  # noqa: E402
from atari.learning.agents import AGENTS, find_agent, ppo, pqn  # noqa: E402
from atari.learning.run_folder import RunFolder  # noqa: E402
from atari.learning.training import Training  # noqa: E402
from atari.task.arguments import descriptions  # noqa: E402


def equal(one: Any, other: Any) -> bool:
    assert one.keys() == other.keys()
    return all(torch.equal(one[name], other[name]) for name in one)


@pytest.mark.parametrize("options", [TrainingOptions, *(find_agent(agent).options_class for agent in AGENTS)])
def test_every_option_is_described(options: Any) -> None:
    texts = descriptions(options)
    assert set(texts) == {field.name for field in fields(options)}
    assert all(len(text) > 10 and "  " not in text for text in texts.values())
    assert ppo.PPOOptions.of("pong").clip == 0.1


STEPS = {"ppo": 256, "pqn": 256, "dqn": 800}
"""Four updates of PPO and PQN, and six of DQN, which learns from step 500 on."""

Weights = dict[str, Any]


@pytest.fixture(scope="module", params=[(agent, obs) for agent in AGENTS for obs in ("grayscale", "ram")], ids="-".join)
def trainings(request: pytest.FixtureRequest) -> list[tuple[Weights, Weights]]:
    """The weights before and after a training with seed 1, another one with seed 1, and one with seed 2."""
    agent, obs = request.param

    def train(seed: int) -> tuple[Weights, Weights]:
        trained = find_agent(agent)(make_options(agent, obs_type=obs, seed=seed))
        before = {name: value.clone() for name, value in trained.network.named_parameters()}
        while trained.steps < STEPS[agent]:
            assert np.isfinite(trained.update()["loss"])
        trained.close()
        return before, {name: value.clone() for name, value in trained.network.state_dict().items()}

    return [train(seed) for seed in (1, 1, 2)]


def test_equal_seeds_give_equal_weights_and_others_do_not(trainings: list[tuple[Weights, Weights]]) -> None:
    first, again, other = (after for _, after in trainings)
    assert equal(first, again)
    assert not equal(first, other)


def test_the_weights_move(trainings: list[tuple[Weights, Weights]]) -> None:
    before, after = trainings[0]
    assert [name for name in before if torch.equal(before[name], after[name])] == []


TRAINING = f"""
import sys
sys.path.insert(0, {SUPPORT!r})
from pathlib import Path
from small_trainings import make_options
from atari.learning.training import Training
options = make_options("dqn", total_steps=3000, checkpoint_minutes=0.0005)
Training.begin("dqn", options, Path(sys.argv[1])).run()
"""


def test_a_killed_training_ends_with_the_same_weights(tmp_path: Path) -> None:
    """The process of a training is killed; `test_crashes.py` has all moments of all agents."""
    options = make_options("dqn", total_steps=3000, checkpoint_minutes=0.0005)
    with closing(Training.begin("dqn", options, tmp_path / "whole")) as training:
        training.run()
    killed = subprocess.Popen([sys.executable, "-c", TRAINING, str(tmp_path / "killed")])
    checkpoint = tmp_path / "killed" / "checkpoint.pt"
    while not checkpoint.exists() and killed.poll() is None:
        time.sleep(0.01)
    time.sleep(0.05)
    killed.send_signal(signal.SIGKILL)
    assert killed.wait() == -signal.SIGKILL, "the training ended before it could be killed"
    with closing(Training.resume(tmp_path / "killed")) as training:
        training.run()
    whole, resumed = (outcome(tmp_path / name) for name in ("whole", "killed"))
    assert equal(whole[0], resumed[0])
    assert whole[1] == resumed[1]


def test_ppo_estimates_advantages() -> None:
    options = make_options("ppo", workers=1, num_envs=2, minibatch=32)
    agent = ppo.PPO(options)
    worker = agent.rollouts[0]
    worker.play(ppo.Returns(False))
    rewards, ends, values = worker.rewards.numpy(), worker.ends.numpy().copy(), worker.values.numpy()
    ends[5, 1] = 1
    worker.ends[5, 1] = 1
    worker._estimate(worker.values)
    for lane in range(2):
        for start in range(16):
            expected, weight = 0.0, 1.0  # the sum of discounted errors, by its definition
            for step in range(start, 16):
                goes_on = 1 - ends[step, lane]
                expected += weight * (
                    rewards[step, lane] + 0.99 * values[step + 1, lane] * goes_on - values[step, lane]
                )
                weight *= 0.99 * 0.95 * goes_on
            assert worker.advantages[start, lane] == pytest.approx(expected, abs=1e-4)
    assert torch.allclose(worker.returns, worker.advantages + worker.values[:-1])
    agent.close()


@pytest.mark.parametrize(("middle", "expected"), [(None, [1, 0.55, 0.1, 0.1, 0.1]), (0.5, [1, 0.75, 0.5, 0.3, 0.1])])
def test_pqn_explores_less_and_less(middle: float | None, expected: list[float]) -> None:
    with closing(
        pqn.PQN(make_options("pqn", epsilon=0.1, epsilon_middle=middle, exploration=0.2, lane_epsilon=None))
    ) as agent:
        epsilons = [agent.rollouts[0]._epsilon(done).item() for done in (0, 0.1, 0.2, 0.6, 1)]
    assert epsilons == pytest.approx(expected)


@pytest.mark.parametrize("name", ["pqn", "dqn"])
def test_lanes_with_epsilons_of_their_own(name: str) -> None:
    options = make_options(name, lane_epsilon=0.4, num_envs=8, workers=1, exploration={"pqn": 0.2, "dqn": 100}[name])
    with closing(find_agent(name)(options)) as agent:
        last = [0.4 ** (1 + lane) for lane in range(8)]
        found = []
        for part in (0, 0.5, 1):  # of the time over which all epsilons fall from 1
            agent.steps = round(100 * part)
            found.append(agent._epsilon() if name == "dqn" else agent.rollouts[0]._epsilon(0.2 * part))
        np.testing.assert_allclose(found[0], 1)
        np.testing.assert_allclose(found[1], [(1 + epsilon) / 2 for epsilon in last], rtol=1e-4)
        np.testing.assert_allclose(found[2], last, rtol=1e-4)
        assert agent.environments[0].scored.tolist() == [epsilon < 0.01 for epsilon in last]


@pytest.mark.parametrize(
    ("name", "options", "games"),
    [
        ("ppo", {}, 100),
        ("pqn", {"lane_epsilon": 0.4, "num_envs": 8}, 38),  # three of eight are scored
        ("dqn", {"lane_epsilon": 0.4, "num_envs": 8}, 38),
        ("ppo", {"restart_share": 0.25, "num_envs": 8}, 75),
    ],
)
def test_the_score_is_of_as_many_games_of_each_scored_environment(
    name: str, options: dict[str, Any], games: int, tmp_path: Path
) -> None:
    training = Training.begin(name, make_options(name, workers=1, **options), tmp_path / name)
    with closing(training):
        assert [scores.maxlen for scores in training.scores.values()] == [games]


@pytest.mark.parametrize("name", ["pqn", "dqn"])
def test_lanes_without_a_greedy_one_are_refused(name: str) -> None:
    with pytest.raises(ValueError, match=r"with lane_epsilon=0\.9 none of the 4 environments .* is greedy"):
        find_agent(name)(make_options(name, lane_epsilon=0.9, num_envs=4, workers=1))


def test_a_refused_training_leaves_no_folder(tmp_path: Path) -> None:
    options = {"num_envs": 8, "workers": 1}
    with pytest.raises(ValueError, match="is greedy"):
        Training.begin("pqn", make_options("pqn", lane_epsilon=0.99, **options), tmp_path / "run")
    assert not any(tmp_path.iterdir())
    Training.begin("pqn", make_options("pqn", lane_epsilon=0.4, **options), tmp_path / "run").close()


@pytest.mark.parametrize(
    ("name", "value"),
    [("exploration", 0.0), ("exploration", 1.5), ("epsilon_middle", 1.5), ("epsilon", 2), ("lane_epsilon", 1.5)],
)
def test_pqn_refuses_parts_above_1(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"{name} must be .*, got {value}"):
        make_options("pqn", **{name: value})


def test_replicas_refuse_other_networks_and_counts() -> None:
    for network, count, error in (
        (3, 2, TypeError),
        *((torch.nn.Linear(1, 1), count, ValueError) for count in (0, 2**40)),
    ):
        with pytest.raises(error, match="network must be" if network == 3 else "count"):
            Replicas(network, count)


def test_replicas_give_the_gradient_of_the_whole_batch() -> None:
    network = torch.nn.Linear(3, 1)
    data = torch.randn(8, 3)
    network(data).square().mean().backward()
    assert network.weight.grad is not None
    expected = network.weight.grad.clone()
    replicas = Replicas(network, 2)

    def gradient(replica: Any, share: Any) -> None:
        replica.zero_grad()
        replica(share).square().mean().backward()

    replicas.map(gradient, replicas.networks, data.chunk(2))
    replicas.average_gradients()
    assert torch.allclose(network.weight.grad, expected)
    replicas.close()


def test_a_copy_of_replicas_has_a_network_and_threads_of_its_own() -> None:
    one = Replicas(torch.nn.Linear(3, 1), 2)
    for other in (copy.deepcopy(one), pickle.loads(pickle.dumps(one))):
        assert torch.equal(other.network.weight, one.network.weight)
        other.network.weight.data.zero_()
        assert other.map(lambda network: network.weight.sum().item(), other.networks) == [0.0, 0.0]
        assert one.network.weight.abs().sum() > 0
        other.close()
    one.close()


def test_one_replica_is_the_network_itself() -> None:
    network = torch.nn.Linear(3, 1)
    replicas = Replicas(network, 1)
    assert replicas.networks == [network]
    assert replicas.map(lambda one, two: one + two, [1, 2], [3, 4]) == [4, 6]
    replicas.networks[0](torch.ones(1, 3)).sum().backward()
    replicas.average_gradients()
    assert torch.equal(network.weight.grad, torch.ones(1, 3))
    replicas.close()


@pytest.mark.parametrize("update", [1, 5, 6, 7, 100, 5000])
def test_pqn_steps_as_radam(update: int) -> None:
    def steps(make: Any, factor: Any) -> "torch.Tensor":
        weights = torch.nn.Parameter(torch.ones(3))
        optimizer = make([weights], lr=1.0)
        for number in range(1, update + 1):
            before = weights.detach().clone()
            optimizer.param_groups[0]["lr"] = factor(number)
            weights.grad = torch.tensor([1.0, -2.0, 0.5]) * (-1) ** number + 0.3
            optimizer.step()
        return weights.detach() - before

    if update <= 5:  # RAdam takes steps without mean squares, which Adam cannot take
        assert pqn.rectification(update) == 0
    else:
        expected = steps(torch.optim.RAdam, lambda _: 1.0)
        assert torch.allclose(steps(torch.optim.Adam, pqn.rectification), expected, atol=1e-6)


def test_a_loss_that_is_no_number_stops_the_training(tmp_path: Path) -> None:
    training = Training.begin("ppo", make_options("ppo", checkpoint_minutes=0.0), tmp_path / "run")
    agent: Any = training.agent

    def spoil(steps: int, score: float) -> None:
        agent.network.value.bias.data.fill_(float("nan"))

    with pytest.raises(FloatingPointError, match=r"the loss is nan at step 128; the last checkpoint in .* is good"):
        training.run(progress=spoil)
    training.close()
    weights = RunFolder.open(tmp_path / "run").load_weights()
    assert all(value.isfinite().all() for value in weights.values())
    resumed = Training.resume(tmp_path / "run")
    assert resumed.agent.steps == 64
    assert np.isfinite(resumed.agent.update()["loss"])
    resumed.close()
