"""Parallelised Q-network (Gallici et al. 2024, arXiv:2407.04811).

Q-learning without a replay memory and without a target network: layer normalisation keeps it stable. As in PPO, many
environments are played for some steps, from which the network then learns. Targets are lambda-returns.

    python -m atari.learning.agents.pqn pong --fast
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from atari.learning import (
    Agent,
    Encoder,
    Replicas,
    RestartOptions,
    RunFolder,
    TrainingEnvironments,
    TrainingLoop,
    main,
)


@dataclass(frozen=True, kw_only=True)
class PQNOptions(RestartOptions):
    """The options of PQN; the defaults are those of the paper's Atari experiments.

    Attributes:
        horizon: steps of each environment between two updates.
        minibatch: steps in a minibatch.
        epochs: how often the network learns from each step.
        q_lambda: weight of later steps in the lambda-returns.
        epsilon: probability of a random action at the end; it begins at 1.
        exploration: the first part of the training, over which epsilon falls.
        epsilon_middle: epsilon after `exploration`, from which it falls to `epsilon` until the end of the training;
            none is `epsilon`, as in the paper.
        lane_epsilon: give each environment an epsilon of its own after `exploration`: environment i of N plays with
            lane_epsilon ** (1 + 7 i / (N - 1)) until the end, as in Ape-X (Horgan et al. 2018), where it is 0.4. The
            score in the log is that of the environments below 0.01. None is one epsilon for all.
        max_gradient: norm to which gradients are clipped.
        anneal: let the learning rate fall to 0 over the training, or over its last part.
        anneal_from: the part of the training before the learning rate falls.
    """

    total_steps: int = 50_000_000
    num_envs: int = 128
    horizon: int = 32
    minibatch: int = 128
    epochs: int = 2
    q_lambda: float = 0.65
    epsilon: float = 0.001
    exploration: float = 0.1
    epsilon_middle: float | None = None
    lane_epsilon: float | None = None
    max_gradient: float = 10.0
    anneal: bool = True
    anneal_from: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0 < self.exploration <= 1:
            raise ValueError(f"exploration must be above 0 and at most 1, got {self.exploration}")
        for name in ("epsilon", "epsilon_middle", "lane_epsilon"):
            if (getattr(self, name) or 0) > 1:
                raise ValueError(f"{name} must be within 0..1, got {getattr(self, name)}")
        if self.anneal_from >= 1:
            raise ValueError(f"anneal_from must be below 1, got {self.anneal_from}")
        if self.minibatch % self.workers or self.num_envs * self.horizon % self.minibatch:
            raise ValueError(
                f"num_envs * horizon must be a multiple of minibatch, and minibatch of workers; got "
                f"{self.num_envs} * {self.horizon}, {self.minibatch} and {self.workers}"
            )


FAST: dict[str, Any] = {
    "total_steps": 2_000_000,
    "num_envs": 64,
    "preset": "envpool",
    "episodic_life": True,
    "img_height": 42,
    "img_width": 42,
    "network": "small",
    "normalize": True,
    "bfloat16": "auto",
    "workers": 2,
    "minibatch": 256,
    "q_lambda": 0.9,
    "anneal": False,
    "exploration": 0.02,
    "lane_epsilon": 0.4,
    "learning_rate": 5e-4,
}
"""Options for pixels, found by measurement on two cores; see docs/learning.md."""


def rectification(update: int, decay: float = 0.999) -> float:
    """The factor of Adam's step size by which it is RAdam's (Liu et al. 2020), which PQN's authors use.

    It is 0 for the first five updates, and then rises to 1: until then the mean squares of the gradients are uncertain.
    """
    longest = 2 / (1 - decay) - 1
    length = longest - 2 * update * decay**update / (1 - decay**update)
    if length <= 5:
        return 0.0
    return float(((length - 4) * (length - 2) * longest / ((longest - 4) * (longest - 2) * length)) ** 0.5)


class QNetwork(nn.Module):
    """The values of the actions."""

    def __init__(self, encoder: Encoder, actions: int) -> None:
        super().__init__()
        self.encoder = encoder
        self.advantage = nn.Linear(encoder.width, actions)

    def forward(self, observations: Tensor) -> Tensor:
        """Values of the actions, (batch, actions)."""
        return self.advantage(self.encoder(observations))

    scores = forward

    def values(self, observations: Tensor) -> Tensor:
        """The highest value of an action, (batch,)."""
        return self(observations).amax(1)


class Rollout:
    """A worker's share of the environments, and arrays (horizon, environments, ...) of the steps played in them."""

    def __init__(self, options: PQNOptions, index: int) -> None:
        self.options, self.device = options, options.torch_device
        count, threads = options.num_envs // options.replicas, options.workers // options.replicas
        self.environments = TrainingEnvironments(
            options, count, threads, restart_share=options.restart_share, restart_from=options.restart_from
        )
        self.lane_epsilons: Tensor | None = None
        if options.lane_epsilon is not None:
            self.lane_epsilons = torch.from_numpy(self.environments.lane_epsilons(options.lane_epsilon))
        self.generator = torch.Generator().manual_seed(options.seed * options.replicas + index)
        first = options.seed * options.num_envs + index * count
        self.observations = self.environments.reset(options.environment_seeds(first, count))
        size = (options.horizon, count)
        self.actions = torch.zeros(*size, dtype=torch.int64)
        self.rewards, self.ends, self.targets = torch.zeros(3, *size).unbind()
        self.greatest = torch.zeros(options.horizon + 1, size[1])
        self.learned: list[Tensor]

    def begin(self, network: QNetwork) -> None:
        """Take the network, whose encoder decides how the steps' observations are kept."""
        self.network = network
        one = self._prepare(self.observations[:1])
        self.seen = one.new_zeros(*self.actions.shape, *one.shape[1:])

    @torch.no_grad()
    def play(self, done: float) -> Tensor:
        """Play `horizon` steps, and compute the targets. Returns a part of the observations.

        Args:
            done: the part of the training that is done.
        """
        count, actions, part = self.environments.num_envs, len(self.environments.actions), []
        self.epsilon = self._epsilon(done)
        for step in range(self.options.horizon):
            seen = self._prepare(self.observations)
            self.greatest[step], chosen = self.network(seen).cpu().max(1)
            random = torch.randint(actions, (count,), generator=self.generator)
            chosen = torch.where(torch.rand(count, generator=self.generator) < self.epsilon, random, chosen)
            self.seen[step], self.actions[step] = seen, chosen
            if step % 8 == 0:
                part.append(torch.from_numpy(self.observations))
            self.observations, rewards, terminations, truncations, info = self.environments.step(chosen.numpy())
            self.rewards[step] = torch.from_numpy(rewards)
            self.ends[step] = torch.from_numpy(terminations | truncations)
            if truncations.any():  # the game goes on unseen: add the value of its rest
                values = self.network(self._prepare(info["final_obs"])).cpu().amax(1)
                self.rewards[step] += self.options.gamma * values * torch.from_numpy(truncations & ~terminations)
        self.greatest[-1] = self.network(self._prepare(self.observations)).cpu().amax(1)
        self._estimate()
        self.learned = [array.flatten().to(self.device) for array in (self.actions, self.targets)]
        return torch.cat(part)

    def _prepare(self, observations: Any) -> Tensor:
        return self.network.encoder.prepare(torch.from_numpy(observations).to(self.device))

    def _epsilon(self, done: float) -> Tensor:
        """The probability of a random action in each environment, or in all of them."""
        if self.lane_epsilons is not None:
            return 1 - min(1, done / self.options.exploration) * (1 - self.lane_epsilons)
        last, middle = self.options.epsilon, self.options.epsilon_middle
        falls = (1, last if middle is None else middle, last)
        return torch.tensor(np.interp(done, (0, self.options.exploration, 1), falls))

    def _estimate(self) -> None:
        following = self.greatest[-1]
        for step in reversed(range(self.options.horizon)):
            value = self.options.q_lambda * following + (1 - self.options.q_lambda) * self.greatest[step + 1]
            following = self.rewards[step] + self.options.gamma * (1 - self.ends[step]) * value
            self.targets[step] = following

    def gradient(self, chosen: Tensor) -> tuple[Tensor, Tensor]:
        """Compute the gradients of the loss on some steps; returns the loss and the mean value."""
        actions, targets = (array[chosen] for array in self.learned)
        seen = self.seen.flatten(0, 1).index_select(0, chosen)
        values = self.network(seen).gather(1, actions[:, None])[:, 0]
        loss = 0.5 * (values - targets).square().mean()
        self.network.zero_grad()
        loss.backward()
        return loss.detach(), values.detach().mean()


class PQN(Agent):
    """Rollouts, network and optimiser."""

    options_class = PQNOptions
    fast = FAST
    sample = False

    def __init__(self, options: PQNOptions, run: RunFolder | None = None) -> None:
        torch.manual_seed(options.seed)
        self.options, self.device = options, options.torch_device
        self.steps = 0
        self.generator = torch.Generator().manual_seed(options.seed)
        self.rollouts = [Rollout(options, index) for index in range(options.replicas)]
        self.environments = [rollout.environments for rollout in self.rollouts]
        self.generators = [self.generator, *(rollout.generator for rollout in self.rollouts)]
        self.network = self.make_network(options, self.environments[0].shape, len(self.environments[0].actions))
        self.network.to(self.device)
        self.replicas = Replicas(self.network, options.replicas)
        for rollout, network in zip(self.rollouts, self.replicas.networks, strict=True):
            rollout.begin(network)
        self.optimizer = torch.optim.Adam(self.network.parameters(), options.learning_rate, fused=True)
        self.updates = 0
        self._normalize([torch.from_numpy(rollout.observations) for rollout in self.rollouts])

    @staticmethod
    def make_network(options: PQNOptions, shape: tuple[int, ...], actions: int) -> QNetwork:
        """The network for observations of a shape."""
        encoder = Encoder(
            shape, options.network, normalize=options.normalize, layer_norm=True, bfloat16=options.computes_bfloat16
        )
        return QNetwork(encoder, actions)

    def train(self, training: TrainingLoop) -> None:
        """The loop: update after update, a row of the log for each, and a checkpoint now and then."""
        while training.goes_on():
            training.log(self.update())
            training.save_when_due()

    def update(self) -> dict[str, float]:
        """Play `horizon` steps in each environment and learn from them. Returns the columns of the log."""
        options = self.options
        done = self.steps / options.total_steps
        left = min(1.0, (1 - done) / (1 - options.anneal_from)) if options.anneal else 1.0
        learning_rate = options.learning_rate * left
        seen = self.replicas.map(lambda rollout: rollout.play(done), self.rollouts)
        self.steps += options.horizon * options.num_envs
        metrics = torch.stack([metric for _ in range(options.epochs) for metric in self._learn(learning_rate)])
        self._normalize(seen)
        loss, value = metrics.mean(0).tolist()
        return {
            "loss": loss,
            "value": value,
            "epsilon": self.rollouts[0].epsilon.mean().item(),
            "learning_rate": learning_rate,
        }

    def _learn(self, learning_rate: float) -> list[Tensor]:
        options = self.options
        steps, size = options.horizon * options.num_envs // options.replicas, options.minibatch // options.replicas
        orders = [torch.randperm(steps, generator=self.generator).to(self.device) for _ in self.rollouts]
        metrics: list[Tensor] = []
        for start in range(0, steps, size):
            shares = [order[start : start + size] for order in orders]
            metrics += map(torch.stack, self.replicas.map(Rollout.gradient, self.rollouts, shares))
            self.replicas.average_gradients()
            nn.utils.clip_grad_norm_(self.network.parameters(), options.max_gradient, foreach=True)
            self.updates += 1
            self.optimizer.param_groups[0]["lr"] = learning_rate * rectification(self.updates)
            self.optimizer.step()
        return metrics

    def _normalize(self, observations: list[Tensor]) -> None:
        self.network.encoder.observe(torch.cat(observations).to(self.device))

    def state(self) -> dict[str, Any]:
        """Everything that the next update depends on."""
        return {
            "steps": self.steps,
            "updates": self.updates,
            "network": self.network.state_dict(),
            "optimizer": self.optimizer.state_dict(),
            "generators": [generator.get_state() for generator in self.generators],
            "environments": [rollout.environments.state() for rollout in self.rollouts],
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from a state of `state`."""
        self.steps, self.updates = state["steps"], state["updates"]
        self.network.load_state_dict(state["network"])
        self.optimizer.load_state_dict(state["optimizer"])
        for generator, at in zip(self.generators, state["generators"], strict=True):
            generator.set_state(at)
        for index, rollout in enumerate(self.rollouts):
            rollout.observations = rollout.environments.restore(state["environments"][index])

    def close(self) -> None:
        """Close the environments and end the threads."""
        self.replicas.close()
        for environments in self.environments:
            environments.close()


if __name__ == "__main__":
    main(PQN)
