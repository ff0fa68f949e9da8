"""`Agent`: the interface between the training loop and an agent."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import torch

from atari.learning.environments import TrainingEnvironments
from atari.learning.memory import ReplayMemory
from atari.learning.options import TrainingOptions
from atari.learning.run import RunFolder

if TYPE_CHECKING:
    from atari.learning.training import Training


class Agent(ABC):
    """An agent: it plays in environments and learns from the steps.

    Attributes:
        options_class: the class of the options.
        fast: options found by measurement, for pixels, as `options_class.of` takes them.
        sample: whether the policy draws its actions; otherwise it takes the action with the highest score.
        steps: agent steps so far, of all environments together.
        network: the network with the weights; its method `scores` rates the actions.
        environments: the environments that the agent plays.
        memory: a replay memory; None for an agent without one.

    Args:
        options: the options of the training.
        run: the folder of the training, which can have the file of a memory; None keeps a memory in main memory.

    Example:
        >>> from atari.learning import Agent
        >>> from atari.learning.agents.ppo import PPO, PPOOptions
        >>> issubclass(PPO, Agent), PPO.options_class is PPOOptions
        (True, True)
        >>> agent = PPO(PPOOptions.of("pong", num_envs=2, horizon=8, minibatch=16))  # without a folder
        >>> sorted(agent.update()), agent.steps
        (['entropy', 'kl', 'learning_rate', 'loss', 'value_loss'], 16)
        >>> agent.close()
    """

    options_class: ClassVar[type[TrainingOptions]]
    fast: ClassVar[Mapping[str, Any]]
    sample: ClassVar[bool] = False

    steps: int
    network: torch.nn.Module
    environments: Sequence[TrainingEnvironments]
    memory: ReplayMemory | None = None

    @abstractmethod
    def __init__(self, options: Any, run: RunFolder | None = None) -> None: ...

    @staticmethod
    @abstractmethod
    def make_network(options: Any, shape: tuple[int, ...], actions: int) -> torch.nn.Module:
        """The network for observations of a shape."""

    @abstractmethod
    def train(self, training: "Training") -> None:
        """Play and learn while `training.goes_on()`, and log and save by it."""

    @abstractmethod
    def state(self) -> dict[str, Any]:
        """Everything that the next update depends on, except a memory in the folder of the training."""

    @abstractmethod
    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from a state of `state`."""

    @abstractmethod
    def close(self) -> None:
        """Release environments, threads and memory."""
