"""Deep Q-learning (Mnih et al. 2015), with double Q-learning (van Hasselt et al. 2016), a dueling network (Wang et al.
2016), n-step returns and prioritised replay (Schaul et al. 2016) as options.

All options together are Rainbow (Hessel et al. 2018) without noisy layers and without distributions.

    python -m atari.learning.agents.dqn pong --fast
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor, nn

from atari.learning import (
    Agent,
    Encoder,
    ReplayMemory,
    Replicas,
    RunFolder,
    TrainingEnvironments,
    TrainingLoop,
    TrainingOptions,
    main,
)


@dataclass(frozen=True, kw_only=True)
class DQNOptions(TrainingOptions):
    """The options of DQN; the defaults are those of Mnih et al. 2015.

    Attributes:
        memory: the capacity of the replay memory in steps; a shorter training has a smaller memory.
        keep_memory: keep the memory's file when the training is complete.
        compress: compress the frames in the memory.
        learning_starts: steps before the first update.
        train_every: steps between two updates of the network.
        batch: steps in a batch.
        target_update: updates after which the target network is copied.
        epsilon: probability of a random action at the end of `exploration`; it begins at 1.
        exploration: steps over which epsilon falls.
        lane_epsilon: give each environment an epsilon of its own after `exploration`, in place of `epsilon`:
            environment i of N plays with lane_epsilon ** (1 + 7 i / (N - 1)), as in Ape-X (Horgan et al. 2018), where
            it is 0.4. The score in the log is that of the environments below 0.01. None is one epsilon for all.
        optimizer: rmsprop, with the constants of Mnih et al. 2015, or adam.
        double: let the network choose the next action, and the target network rate it.
        dueling: compute a value of the state and advantages of the actions, instead of values of the actions.
        n_step: rewards that are summed before the value of the last state.
        priority: exponent of the priorities, 0.5 in Rainbow; none is uniform replay.
        priority_beta: exponent of the importance weights at the beginning; it rises to 1 over the training.
    """

    default_preset: ClassVar[str] = "dqn2015"
    ram_padding: ClassVar[str] = "zero"

    total_steps: int = 50_000_000
    num_envs: int = 1
    memory: int = 1_000_000
    keep_memory: bool = False
    compress: bool = False
    learning_starts: int = 50_000
    train_every: int = 4
    batch: int = 32
    target_update: int = 10_000
    epsilon: float = 0.1
    exploration: int = 1_000_000
    lane_epsilon: float | None = None
    optimizer: str = "rmsprop"
    double: bool = False
    dueling: bool = False
    n_step: int = 1
    priority: float | None = None
    priority_beta: float = 0.4

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.optimizer not in ("rmsprop", "adam"):
            raise ValueError(f"optimizer must be one of rmsprop, adam, got {self.optimizer!r}")
        if self.batch % self.workers:
            raise ValueError(f"batch must be a multiple of workers, got {self.batch} and {self.workers}")
        if (self.lane_epsilon or 0) > 1:
            raise ValueError(f"lane_epsilon must be within 0..1, got {self.lane_epsilon}")
        if self.memory < self.learning_starts:
            raise ValueError(f"memory must hold learning_starts steps, got {self.memory} and {self.learning_starts}")
        if self.total_steps <= self.learning_starts:
            raise ValueError(
                "total_steps must be above learning_starts, or nothing is learned, got "
                f"{self.total_steps} and {self.learning_starts}"
            )
        for name in ("life_loss_info", "seamless_lives"):
            if getattr(self.task, name):
                raise ValueError(
                    f"the replay memory begins a stack anew after each end, and the task has {name}=True; leave it out"
                )


FAST: dict[str, Any] = {
    "total_steps": 2_000_000,
    "preset": "envpool",
    "episodic_life": True,
    "img_height": 42,
    "img_width": 42,
    "network": "small",
    "normalize": True,
    "bfloat16": "auto",
    "workers": 2,
    "num_envs": 16,
    "memory": 200_000,
    "learning_starts": 10_000,
    "train_every": 16,
    "batch": 256,
    "target_update": 500,
    "epsilon": 0.01,
    "exploration": 100_000,
    "optimizer": "adam",
    "double": True,
    "dueling": True,
    "n_step": 3,
}
"""Options for pixels, found by measurement on two cores; see docs/learning.md."""


_UPDATE = 1000
"""Steps of an update, rounded to the number of environments."""


class QNetwork(nn.Module):
    """Action values; with `dueling`, the sum of a state's value and the actions' advantages (Wang et al. 2016)."""

    def __init__(self, encoder: Encoder, actions: int, dueling: bool) -> None:
        super().__init__()
        self.encoder = encoder
        self.advantage = nn.Linear(encoder.width, actions)
        self.value = nn.Linear(encoder.width, 1) if dueling else None

    def forward(self, observations: Tensor) -> Tensor:
        """Values of the actions, (batch, actions)."""
        features = self.encoder(observations)
        advantage: Tensor = self.advantage(features)
        if self.value is None:
            return advantage
        return self.value(features) + advantage - advantage.mean(1, keepdim=True)

    scores = forward

    def values(self, observations: Tensor) -> Tensor:
        """The highest value of an action, (batch,)."""
        return self(observations).amax(1)


class DQN(Agent):
    """Environments, replay memory, network, target network and optimiser."""

    options_class = DQNOptions
    fast = FAST
    sample = False
    memory: ReplayMemory

    def __init__(self, options: DQNOptions, run: RunFolder | None = None) -> None:
        torch.manual_seed(options.seed)
        self.options, self.device = options, options.torch_device
        self.steps = self.updates = 0
        self.losses: list[float] = []  # of the present update
        self.values: list[float] = []
        self.generator = np.random.default_rng(options.seed)
        envs = TrainingEnvironments(options, options.num_envs, options.workers, stacked=False)
        self.envs, self.environments = envs, [envs]
        lanes = options.lane_epsilon
        self.last_epsilon: Any = options.epsilon if lanes is None else envs.lane_epsilons(lanes)
        first = envs.reset(options.environment_seeds(options.seed, options.num_envs))
        self.in_folder = run is not None
        self.memory = self._make_memory(run, first)
        stack = self.memory.observations().shape[1:]
        self.network = self.make_network(options, stack, len(envs.actions)).to(self.device)
        self.target = self.make_network(options, stack, len(envs.actions)).to(self.device)
        self.target.load_state_dict(self.network.state_dict())
        self.replicas = Replicas(self.network, options.replicas)
        self.optimizer = self._make_optimizer()
        self.batch = self.memory.make_batch(options.batch, torch=True, pin_memory=self.device != "cpu")

    def _make_memory(self, run: RunFolder | None, first: Any) -> ReplayMemory:
        """The memory of a training that goes on, or a new one with the first observations."""
        if run is not None and run.memory is not None:
            return run.memory
        options = self.options
        steps = options.num_envs * (self._rows_of_update() + -(-options.total_steps // options.num_envs))
        memory = ReplayMemory(
            min(options.memory, steps),
            options.num_envs,
            self.envs.shape,
            stack_num=options.task.stack_num or 1,
            padding=options.task.padding,
            autoreset_mode="same_step",
            priority_exponent=options.priority,
            compress=options.compress,
            seed=options.seed,
            num_threads=options.workers,
            path=None if run is None else run.path / "memory.replay",
            margin=None if run is None else options.memory // 8 if options.memory < steps else 0,
            autoflush=run is None,
        )
        memory.reset(first)
        return memory

    def _rows_of_update(self) -> int:
        return max(1, _UPDATE // self.options.num_envs)

    def _make_optimizer(self) -> torch.optim.Optimizer:
        if self.options.optimizer == "adam":
            return torch.optim.Adam(self.network.parameters(), self.options.learning_rate, eps=1.5e-4, fused=True)
        return torch.optim.RMSprop(
            self.network.parameters(), self.options.learning_rate, alpha=0.95, eps=0.01, centered=True
        )

    @staticmethod
    def make_network(options: DQNOptions, shape: tuple[int, ...], actions: int) -> QNetwork:
        """The network for observations of a shape."""
        encoder = Encoder(shape, options.network, normalize=options.normalize, bfloat16=options.computes_bfloat16)
        return QNetwork(encoder, actions, options.dueling)

    def train(self, training: TrainingLoop) -> None:
        """The loop: update after update, a row of the log for each, and a checkpoint now and then."""
        while training.goes_on():
            training.log(self.update(training.save_for_memory))
            training.save_when_due()

    def update(self, save: Callable[[], None] | None = None) -> dict[str, float]:
        """Play some steps, and learn meanwhile. Returns the columns of the log.

        Args:
            save: writes a checkpoint, which the memory needs now and then before a further step.
        """
        is_complete = False
        while not is_complete:
            if save is not None and self.memory.must_flush:
                save()
            observations = self.memory.observations()
            if self.options.normalize and self.steps < 100_000:  # then they are fixed, as the memory has older frames
                self._normalize(observations)
            self._play(observations)
            while self._due():
                loss, value = self._learn()
                self.losses.append(loss)
                self.values.append(value)
            is_complete = self.steps // self.options.num_envs % self._rows_of_update() == 0
        losses, values = self.losses or [0.0], self.values or [0.0]
        self.losses, self.values = [], []
        return {
            "loss": float(np.mean(losses)),
            "value": float(np.mean(values)),
            "epsilon": float(np.mean(self._epsilon())),
            "updates": self.updates,
        }

    def _play(self, observations: Any) -> None:
        """Play one step in each environment, into the memory."""
        count, random = self.options.num_envs, self.generator.random(self.options.num_envs) < self._epsilon()
        actions = self.generator.integers(len(self.envs.actions), size=count)
        if not random.all():
            with torch.no_grad():
                values = self.network(torch.from_numpy(observations).to(self.device))
            actions = np.where(random, actions, values.argmax(1).cpu().numpy())
        _, *results = self.envs.step(actions, out=self.memory.frames())
        self.memory.add(actions, *results)
        self.steps += count

    def _epsilon(self) -> Any:
        """The probability of a random action in each environment, or in all of them."""
        return np.maximum(self.last_epsilon, 1 - (1 - self.last_epsilon) * self.steps / self.options.exploration)

    def _due(self) -> bool:
        wanted = (self.steps - self.options.learning_starts) // self.options.train_every
        return self.updates < wanted and self.memory.count(self.options.n_step) > 0

    def _learn(self) -> tuple[float, float]:
        """Learn from one batch; returns the loss and the mean value."""
        options = self.options
        beta = None
        if options.priority is not None:
            beta = options.priority_beta + (1 - options.priority_beta) * min(1, self.steps / options.total_steps)
        batch = self.memory.sample(options.batch, n=options.n_step, gamma=options.gamma, beta=beta, out=self.batch)
        shares = torch.arange(options.batch).chunk(options.replicas)
        batches = [batch] * options.replicas
        results = self.replicas.map(self._gradient, self.replicas.networks, batches, shares)
        if options.priority is not None:
            self.memory.update_priorities(batch.indices, torch.cat([errors for errors, _, _ in results]).numpy())
        self.replicas.average_gradients()
        self.optimizer.step()
        self.updates += 1
        if self.updates % options.target_update == 0:
            self.target.load_state_dict(self.network.state_dict())
        return float(np.mean([loss for _, loss, _ in results])), float(np.mean([value for _, _, value in results]))

    def _gradient(self, network: QNetwork, batch: Any, share: Tensor) -> tuple[Tensor, float, float]:
        """Compute the gradients of the loss on a share of a batch; returns errors, loss and mean value."""
        rows, device = slice(int(share[0]), int(share[-1]) + 1), self.device
        observations, actions, rewards, following, discounts, weights = (
            part[rows].to(device, non_blocking=True)
            for part in (
                batch.observations,
                batch.actions,
                batch.rewards,
                batch.next_observations,
                batch.discounts,
                batch.weights,
            )
        )
        with torch.no_grad():
            following = network.encoder.prepare(following)  # once for both networks, whose statistics are equal
            rated = self.target(following)
            chosen = (network(following) if self.options.double else rated).argmax(1, keepdim=True)
            targets = rewards + discounts * rated.gather(1, chosen)[:, 0]
        values = network(observations).gather(1, actions[:, None])[:, 0]
        loss = (weights * F.smooth_l1_loss(values, targets, reduction="none")).mean()
        network.zero_grad()
        loss.backward()
        return (targets - values).abs().detach().cpu(), loss.item(), values.mean().item()

    def _normalize(self, observations: Any) -> None:
        self.network.encoder.observe(torch.from_numpy(observations).to(self.device))
        self.target.encoder.normalize.load_state_dict(self.network.encoder.normalize.state_dict())

    def state(self) -> dict[str, Any]:
        """Everything that the next update depends on, except a memory in the folder of the training."""
        return {
            "steps": self.steps,
            "updates": self.updates,
            "losses": self.losses,
            "values": self.values,
            "network": self.network.state_dict(),
            "target": self.target.state_dict(),
            "optimizer": self.optimizer.state_dict(),
            "generator": self.generator.bit_generator.state,
            "environments": self.envs.state(),
            "memory": None if self.in_folder else self.memory.state(),
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from a state of `state`."""
        self.steps = state["steps"]
        self.updates = state["updates"]
        self.losses, self.values = list(state.get("losses", [])), list(state.get("values", []))
        self.network.load_state_dict(state["network"])
        self.target.load_state_dict(state["target"])
        self.optimizer.load_state_dict(state["optimizer"])
        self.generator.bit_generator.state = state["generator"]
        self.envs.restore(state["environments"])
        if not self.in_folder:
            self.memory.restore(state["memory"])

    def close(self) -> None:
        """Close environments and memory, and end the threads."""
        self.replicas.close()
        self.envs.close()
        self.memory.close()


if __name__ == "__main__":
    main(DQN)
