"""`Agent`: what the training loop needs of an agent."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import torch

from atari.learning.environments import TrainingEnvironments
from atari.learning.options import TrainingOptions


class Agent(ABC):
    """Plays in environments and learns from it.

    Attributes:
        options_class: class of the options.
        fast: options found by measurement, for pixels, as `options_class.of` takes them.
        sample: whether the policy draws its actions; otherwise it takes the one with the highest score.
        steps: agent steps so far, of all environments together.
        network: the weights; its method `scores` rates the actions.
        environments: those that it plays.

    Args:
        options: of the training.
        folder: where a large memory may have its file; None keeps it in RAM.
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
        """Play some steps and learn from them; returns what belongs into the log, `loss` among it."""

    @abstractmethod
    def state(self) -> dict[str, Any]:
        """All that the next update depends on, but for what `commit` saves."""

    @abstractmethod
    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from a state, as if nothing had happened."""

    def commit(self) -> None:  # noqa: B027 - most agents have nothing else
        """Save what belongs to the last `state` but is not in it."""

    def fits(self, state: Mapping[str, Any]) -> bool:
        """Whether what `commit` has saved belongs to this state."""
        return True

    @property
    def must_save(self) -> bool:
        """Whether a checkpoint is needed before the next update."""
        return False

    @abstractmethod
    def close(self) -> None:
        """Release environments and threads."""
