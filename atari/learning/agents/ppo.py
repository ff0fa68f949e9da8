"""Proximal policy optimisation (Schulman et al. 2017, arXiv:1707.06347).

The environments are divided among workers, each a thread. A worker plays its environments for `horizon` steps, and
computes the gradients of its share of each minibatch. Each step of the optimiser takes the mean of these gradients.

    python -m atari.learning.agents.ppo pong --fast
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import torch
import torch.nn.functional as F
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
class PPOOptions(RestartOptions):
    """The options of PPO; the defaults are those of the paper's Atari experiments.

    Attributes:
        horizon: steps of each environment between two updates.
        minibatch: steps in a minibatch.
        epochs: how often the network learns from each step.
        gae_lambda: lambda of the generalised advantage estimation (Schulman et al. 2016).
        clip: the largest change of an action's probability in an update, as a ratio.
        entropy: weight of the policy's entropy in the loss.
        value_weight: weight of the value function's loss.
        max_gradient: norm to which gradients are clipped.
        anneal: let learning rate and clip fall to 0 over the training.
        kl_target: after each epoch, multiply or divide the learning rate by 1.5 to hold the KL divergence of an update
            near this; none leaves the rate alone.
        normalize_returns: let the value function predict returns with a mean of 0 and a variance of 1.
    """

    horizon: int = 128
    minibatch: int = 256
    epochs: int = 3
    gae_lambda: float = 0.95
    clip: float = 0.1
    entropy: float = 0.01
    value_weight: float = 1.0
    max_gradient: float = 0.5
    anneal: bool = True
    kl_target: float | None = None
    normalize_returns: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
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
    "minibatch": 1024,
    "learning_rate": 3e-4,
    "clip": 0.2,
    "max_gradient": 1.0,
    "anneal": False,
    "kl_target": 0.01,
    "normalize_returns": True,
}
"""Options for pixels, found by measurement on two cores; see docs/learning.md."""


@dataclass
class Returns:
    """Running mean and variance of returns, by which the value function's outputs are scaled."""

    running: bool
    mean: float = 0.0
    variance: float = 1.0
    count: float = 1e-4

    @property
    def deviation(self) -> float:
        """The standard deviation."""
        return float(self.variance**0.5) + 1e-5 if self.running else 1.0

    def update(self, returns: Tensor) -> None:
        """Add returns to the statistics (Chan et al. 1979)."""
        if not self.running:
            return
        mean, variance, count = returns.mean().item(), returns.var(correction=0).item(), returns.numel()
        difference, total = mean - self.mean, self.count + count
        squares = self.variance * self.count + variance * count + difference**2 * self.count * count / total
        self.mean += difference * count / total
        self.variance, self.count = squares / total, total


class ActorCritic(nn.Module):
    """A policy and a value function on common features."""

    def __init__(self, encoder: Encoder, actions: int) -> None:
        super().__init__()
        self.encoder = encoder
        self.policy, self.value = nn.Linear(encoder.width, actions), nn.Linear(encoder.width, 1)
        for head, gain in ((self.policy, 0.01), (self.value, 1.0)):
            nn.init.orthogonal_(head.weight, gain)
            nn.init.zeros_(head.bias)

    def forward(self, observations: Tensor) -> tuple[Tensor, Tensor]:
        """Logits of the actions, (batch, actions), and values, (batch,)."""
        features = self.encoder(observations)
        return self.policy(features), self.value(features)[:, 0]

    def scores(self, observations: Tensor) -> Tensor:
        """The logits alone."""
        return self.policy(self.encoder(observations))

    def values(self, observations: Tensor) -> Tensor:
        """The values alone."""
        return self.value(self.encoder(observations))[:, 0]


class Rollout:
    """A worker's share of the environments, and arrays (horizon, environments, ...) of the steps played in them."""

    def __init__(self, options: PPOOptions, index: int) -> None:
        self.options, self.device = options, options.torch_device
        count, threads = options.num_envs // options.replicas, options.workers // options.replicas
        self.environments = TrainingEnvironments(
            options, count, threads, restart_share=options.restart_share, restart_from=options.restart_from
        )
        self.generator = torch.Generator().manual_seed(options.seed * options.replicas + index)
        first = options.seed * options.num_envs + index * count
        self.observations = self.environments.reset(options.environment_seeds(first, count))
        size = (options.horizon, count)
        self.actions = torch.zeros(*size, dtype=torch.int64)
        self.log_probs, self.rewards, self.ends = torch.zeros(3, *size).unbind()
        self.values = torch.zeros(options.horizon + 1, size[1])
        self.advantages, self.returns = torch.zeros(2, *size).unbind()
        self.learned: list[Tensor]

    def begin(self, network: ActorCritic) -> None:
        """Take the network, whose encoder decides how the steps' observations are kept."""
        self.network = network
        one = self._prepare(self.observations[:1])
        self.seen = one.new_zeros(*self.actions.shape, *one.shape[1:])

    @torch.no_grad()
    def play(self, returns: Returns) -> Tensor:
        """Play `horizon` steps, and estimate advantages and returns. Returns a part of the observations."""
        part = []
        for step in range(self.options.horizon):
            seen = self._prepare(self.observations)
            logits, values = self._evaluate(seen)
            log_probs = F.log_softmax(logits, 1)
            actions = torch.multinomial(log_probs.exp(), 1, generator=self.generator)
            self.seen[step], self.values[step] = seen, values
            self.actions[step], self.log_probs[step] = actions[:, 0], log_probs.gather(1, actions)[:, 0]
            if step % 8 == 0:
                part.append(torch.from_numpy(self.observations))
            self.observations, rewards, terminations, truncations, info = self.environments.step(actions[:, 0].numpy())
            self.rewards[step] = torch.from_numpy(rewards)
            self.ends[step] = torch.from_numpy(terminations | truncations)
            if truncations.any():  # the game goes on unseen: add the value of its rest
                _, values = self._evaluate(self._prepare(info["final_obs"]))
                values = values * returns.deviation + returns.mean
                self.rewards[step] += self.options.gamma * values * torch.from_numpy(truncations & ~terminations)
        self.values[-1] = self._evaluate(self._prepare(self.observations))[1]
        self._estimate(self.values * returns.deviation + returns.mean)
        return torch.cat(part)

    def _prepare(self, observations: Any) -> Tensor:
        return self.network.encoder.prepare(torch.from_numpy(observations).to(self.device))

    def _evaluate(self, seen: Tensor) -> tuple[Tensor, Tensor]:
        logits, values = self.network(seen)
        return logits.cpu(), values.cpu()

    def _estimate(self, values: Tensor) -> None:
        following = torch.zeros(self.environments.num_envs)
        for step in reversed(range(self.options.horizon)):
            goes_on = 1 - self.ends[step]
            error = self.rewards[step] + self.options.gamma * values[step + 1] * goes_on - values[step]
            following = error + self.options.gamma * self.options.gae_lambda * goes_on * following
            self.advantages[step] = following
        torch.add(self.advantages, values[:-1], out=self.returns)

    def gradient(self, chosen: Tensor, clip: float) -> Tensor:
        """Compute the gradients of the loss on some steps; returns loss, KL divergence, entropy and value loss."""
        actions, old, advantages, targets = (array[chosen] for array in self.learned)
        logits, values = self.network(self.seen.flatten(0, 1).index_select(0, chosen))
        log_probs = F.log_softmax(logits, 1)
        difference = log_probs.gather(1, actions[:, None])[:, 0] - old
        ratio = difference.exp()
        policy_loss = -torch.min(advantages * ratio, advantages * ratio.clamp(1 - clip, 1 + clip)).mean()
        value_loss = 0.5 * (values - targets).square().mean()
        entropy = -(log_probs.exp() * log_probs).sum(1).mean()
        loss = policy_loss + self.options.value_weight * value_loss - self.options.entropy * entropy
        self.network.zero_grad()
        loss.backward()
        divergence = (ratio - 1 - difference).mean()  # an estimate that is never negative (Schulman 2020)
        return torch.stack([loss, divergence, entropy, value_loss]).detach()


class PPO(Agent):
    """Rollouts, network and optimiser."""

    options_class = PPOOptions
    fast = FAST
    sample = True

    def __init__(self, options: PPOOptions, run: RunFolder | None = None) -> None:
        torch.manual_seed(options.seed)
        self.options, self.device = options, options.torch_device
        self.steps = 0
        self.returns = Returns(options.normalize_returns)
        self.generator = torch.Generator().manual_seed(options.seed)
        self.rollouts = [Rollout(options, index) for index in range(options.replicas)]
        self.environments = [rollout.environments for rollout in self.rollouts]
        self.generators = [self.generator, *(rollout.generator for rollout in self.rollouts)]
        self.network = self.make_network(options, self.environments[0].shape, len(self.environments[0].actions))
        self.network.to(self.device)
        self.replicas = Replicas(self.network, options.replicas)
        for rollout, network in zip(self.rollouts, self.replicas.networks, strict=True):
            rollout.begin(network)
        self.learning_rate = options.learning_rate
        self.optimizer = torch.optim.Adam(self.network.parameters(), self.learning_rate, eps=1e-5, fused=True)
        self._normalize([torch.from_numpy(rollout.observations) for rollout in self.rollouts])

    @staticmethod
    def make_network(options: PPOOptions, shape: tuple[int, ...], actions: int) -> ActorCritic:
        """The network for observations of a shape."""
        encoder = Encoder(shape, options.network, normalize=options.normalize, bfloat16=options.computes_bfloat16)
        return ActorCritic(encoder, actions)

    def train(self, training: TrainingLoop) -> None:
        """The loop: update after update, a row of the log for each, and a checkpoint now and then."""
        while training.goes_on():
            training.log(self.update())
            training.save_when_due()

    def update(self) -> dict[str, float]:
        """Play `horizon` steps in each environment and learn from them. Returns the columns of the log."""
        options = self.options
        left = 1 - self.steps / options.total_steps if options.anneal else 1.0
        if options.kl_target is None:
            self.learning_rate = options.learning_rate * left
        seen = self.replicas.map(lambda rollout: rollout.play(self.returns), self.rollouts)
        self.steps += options.horizon * options.num_envs
        self._scale()
        metrics = torch.stack([self._learn(options.clip * left) for _ in range(options.epochs)])
        self._normalize(seen)
        loss, divergence, entropy, value_loss = metrics.mean(0).tolist()
        return {
            "loss": loss,
            "kl": divergence,
            "entropy": entropy,
            "value_loss": value_loss,
            "learning_rate": self.learning_rate,
        }

    def _scale(self) -> None:
        """Normalise advantages, and with `normalize_returns` the returns, and take the arrays to the device."""
        self.returns.update(torch.cat([rollout.returns for rollout in self.rollouts]))
        advantages = torch.cat([rollout.advantages for rollout in self.rollouts])
        mean, deviation = advantages.mean(), advantages.std() + 1e-8
        for rollout in self.rollouts:
            rollout.advantages.sub_(mean).div_(deviation)
            rollout.returns.sub_(self.returns.mean).div_(self.returns.deviation)
            arrays = (rollout.actions, rollout.log_probs, rollout.advantages, rollout.returns)
            rollout.learned = [array.flatten().to(self.device) for array in arrays]

    def _learn(self, clip: float) -> Tensor:
        """Learn from all steps once; returns the means of the minibatches' metrics."""
        options = self.options
        steps, size = options.horizon * options.num_envs // options.replicas, options.minibatch // options.replicas
        orders = [torch.randperm(steps, generator=self.generator).to(self.device) for _ in self.rollouts]
        metrics = []
        for start in range(0, steps, size):
            shares = [order[start : start + size] for order in orders]
            metrics += self.replicas.map(lambda rollout, share: rollout.gradient(share, clip), self.rollouts, shares)
            self._step()
        mean = torch.stack(metrics).mean(0)
        if options.kl_target is not None:
            divergence = mean[1].item()
            factor = 1 / 1.5 if divergence > 2 * options.kl_target else 1.5 if divergence < options.kl_target / 2 else 1
            self.learning_rate = min(max(self.learning_rate * factor, 1e-6), 1e-2)
        return mean

    def _step(self) -> None:
        self.replicas.average_gradients()
        nn.utils.clip_grad_norm_(self.network.parameters(), self.options.max_gradient, foreach=True)
        self.optimizer.param_groups[0]["lr"] = self.learning_rate
        self.optimizer.step()

    def _normalize(self, observations: list[Tensor]) -> None:
        self.network.encoder.observe(torch.cat(observations).to(self.device))

    def state(self) -> dict[str, Any]:
        """Everything that the next update depends on."""
        return {
            "steps": self.steps,
            "network": self.network.state_dict(),
            "optimizer": self.optimizer.state_dict(),
            "learning_rate": self.learning_rate,
            "returns": vars(self.returns),
            "generators": [generator.get_state() for generator in self.generators],
            "environments": [rollout.environments.state() for rollout in self.rollouts],
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from a state of `state`."""
        self.steps, self.learning_rate = state["steps"], state["learning_rate"]
        self.network.load_state_dict(state["network"])
        self.optimizer.load_state_dict(state["optimizer"])
        self.returns = Returns(**state["returns"])
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
    main(PPO)
