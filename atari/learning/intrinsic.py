"""`IntrinsicRewards`: what a program of the user's adds to the rewards of each step, such as a bonus for new states."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
import torch

from atari.vector import AtariVectorEnv


class IntrinsicReward(Protocol):
    """An object that pays for steps; the option `intrinsic_reward` is a class or function that makes it.

    It is made as `make(envs, seed)`, for the environments of one worker and with the seed of the training. Its optional
    method `columns()` returns numbers by name for the log.
    """

    def __call__(self, observations: Any, actions: Any, info: Mapping[str, Any]) -> Any:
        """The intrinsic rewards of a step of all environments.

        Args:
            observations: those after the step, (num_envs, ...) uint8; the next step overwrites them. An environment
                whose episode has ended shows the next one; `info["final_obs"]` has the last observation.
            actions: the actions of the step, int64 (num_envs,).
            info: the `info` of `AtariVectorEnv.step`, with SAME_STEP autoreset.

        Returns:
            Finite numbers (num_envs,), an array or a tensor.
        """

    def state(self) -> Any:
        """Everything that the next rewards depend on, which can be pickled."""

    def restore(self, state: Any) -> None:
        """Continue from a state of `state`."""


class IntrinsicRewards:
    """Adds the rewards of a user's object to the environments' rewards, and counts them for the log.

    Gradients can be computed in the object, although the agents play without them.

    Args:
        make: makes the object, see `IntrinsicReward`.
        envs: the environments.
        seed: the seed of the training.

    Raises:
        TypeError: the object cannot be called, or has no state.
    """

    def __init__(self, make: Callable[..., IntrinsicReward], envs: AtariVectorEnv, seed: int) -> None:
        self._name = f"intrinsic_reward {getattr(make, '__name__', make)}"
        try:
            self._program = make(envs, seed)
        except TypeError as error:
            raise TypeError(f"{self._name} is called with the vector environment and a seed: {error}") from error
        if not all(callable(getattr(self._program, name, None)) for name in ("__call__", "state", "restore")):
            raise TypeError(
                f"{self._name} must make an object that is called with observations, actions and info, and has the "
                f"methods state() and restore(state), got {self._program!r:.60}"
            )
        self._sum, self._steps = 0.0, 0

    def add_to(self, rewards: Any, observations: Any, actions: Any, info: Mapping[str, Any]) -> Any:
        """The sum of rewards and intrinsic rewards, float64 (num_envs,).

        Raises:
            RuntimeError: the object has raised an error.
            ValueError: the object has not returned a finite number for each environment.
        """
        try:
            with torch.enable_grad():
                paid = self._program(observations, actions, info)
        except Exception as error:
            raise RuntimeError(f"{self._name} failed in a step: {type(error).__name__}: {error}") from error
        paid = np.asarray(paid.detach().cpu() if isinstance(paid, torch.Tensor) else paid)
        if paid.dtype.kind not in "biuf" or paid.shape != rewards.shape or not np.isfinite(paid).all():
            raise ValueError(f"{self._name} must return finite numbers {rewards.shape}, got {paid.dtype} {paid!r:.200}")
        self._sum += float(paid.mean())
        self._steps += 1
        return rewards + paid.astype(np.float64)

    def take_columns(self) -> dict[str, float]:
        """The mean intrinsic reward of the steps since the last call, and the columns of the object."""
        mean = self._sum / self._steps if self._steps else float("nan")
        self._sum, self._steps = 0.0, 0
        return {"intrinsic_reward": mean, **getattr(self._program, "columns", dict)()}

    def state(self) -> tuple[Any, ...]:
        """All that the next steps depend on beside the environments; it changes with them."""
        return self._program.state(), self._sum, self._steps

    def restore(self, state: tuple[Any, ...]) -> None:
        """Continue from a state of `state`."""
        program, self._sum, self._steps = state
        self._program.restore(program)
