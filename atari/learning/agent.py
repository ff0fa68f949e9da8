"""`Agent`: the interface between the training loop and an agent."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import torch

from atari.learning.environments import TrainingEnvironments
from atari.learning.options import TrainingOptions


class Agent(ABC):
    """An agent: it plays in environments and learns from the steps.

    Attributes:
        options_class: the class of the options.
        fast: options found by measurement, for pixels, as `options_class.of` takes them.
        sample: whether the policy draws its actions; otherwise it takes the action with the highest score.
        steps: agent steps so far, of all environments together.
        network: the network with the weights; its method `scores` rates the actions.
        environments: the environments that the agent plays.

    Args:
        options: the options of the training.
        folder: the folder for the file of a large replay memory; None keeps it in main memory.
    """

    options_class: ClassVar[type[TrainingOptions]]
    fast: ClassVar[Mapping[str, Any]]
    sample: ClassVar[bool] = False

    steps: int
    network: torch.nn.Module
    environments: Sequence[TrainingEnvironments]

    @abstractmethod
    def __init__(self, options: Any, folder: Path | None = None) -> None: ...

    @staticmethod
    @abstractmethod
    def make_network(options: Any, shape: tuple[int, ...], actions: int) -> torch.nn.Module:
        """The network for observations of a shape and a number of actions."""

    @abstractmethod
    def update(self) -> Mapping[str, float]:
        """Play some steps and learn from them. Returns the columns of the log, `loss` among them."""

    @abstractmethod
    def state(self) -> dict[str, Any]:
        """Everything that the next update depends on, except what `commit` saves."""

    @abstractmethod
    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from a state of `state`."""

    def commit(self) -> None:  # noqa: B027 - most agents have everything in `state`
        """Save what the last `state` refers to, such as the file of a replay memory."""

    def fits(self, state: Mapping[str, Any]) -> bool:
        """Whether the last `commit` belongs to this state."""
        return True

    @property
    def must_save(self) -> bool:
        """Whether a checkpoint is needed before the next update."""
        return False

    @abstractmethod
    def close(self) -> None:
        """Release environments and threads."""
