"""`AtariVectorEnv.ale`: the environments of a vector under the method names of ale-py's `ALEVectorInterface`."""

import operator
from collections.abc import Sequence
from typing import Any

import numpy as np

from atari.base.validation import check_strength
from atari.cores.ale_actions import Action as AleAction


class AleVectorInterface:
    """The methods of ale-py's `ALEVectorInterface`.

    Arrays and errors are those of `AtariVectorEnv`.
    """

    def __init__(self, envs: Any) -> None:  # an AtariVectorEnv, whose module imports this one
        self._envs = envs

    def get_num_envs(self) -> int:
        """The number of environments."""
        return int(self._envs.num_envs)

    def handle(self) -> Any:
        """The handle of the environments for functions compiled by XLA, (8,) uint8; see `atari.integrations.jax`."""
        return np.frombuffer(self._envs.xla_port().handle, np.uint8)

    def get_action_set(self) -> list[AleAction]:
        """The action of each index of the action space."""
        return [AleAction(action) for action in self._envs.options.actions[0]]

    def get_observation_shape(self) -> tuple[int, ...]:
        """The shape of the observation of one environment."""
        return tuple(self._envs.single_observation_space.shape or ())

    def reset(self, reset_indices: Sequence[int], reset_seeds: Sequence[int]) -> tuple[Any, dict[str, Any]]:
        """Reset these environments, each with its seed; -1 keeps the generator.

        Raises:
            IndexError: there is no such environment.
            TypeError, ValueError: an index occurs twice, or see `AtariVectorEnv.reset`.
        """
        count = self._envs.num_envs
        indices = [operator.index(index) for index in reset_indices]
        for place, index in enumerate(indices):
            if not 0 <= index < count:
                raise IndexError(f"environment {index} is out of range; there are {count}")
            if index in indices[:place]:
                raise ValueError(f"duplicate env_id {index}; reset an environment once")
        if len(reset_seeds) != len(indices):
            raise ValueError(f"there must be one seed for each of {len(indices)} environments, got {len(reset_seeds)}")
        mask = np.zeros(count, np.bool_)
        mask[indices] = True
        seeds = [reset_seeds[place] for place in np.argsort(indices)]
        options = None if mask.all() else {"reset_mask": mask}
        return self._envs.reset(seed=seeds, options=options)

    def send(self, action_ids: Any, paddle_strengths: Any) -> None:
        """Begin a step, with the index of an action and the strength of a paddle for each environment of the batch.

        Raises:
            TypeError, ValueError: an argument is of the wrong kind, shape or range; nothing is played.
        """
        envs, shape = self._envs, (self._envs.batch_size,)
        engine = envs._open()
        envs._check_idle()
        indices, strengths = np.asarray(action_ids), np.asarray(paddle_strengths)
        if indices.dtype.kind not in "iu" or strengths.dtype.kind not in "iuf":
            raise TypeError(f"actions must be integers and strengths floats, got {indices.dtype} and {strengths.dtype}")
        if indices.shape != shape or strengths.shape != shape:
            raise ValueError(f"both must have the shape {shape}, got {indices.shape} and {strengths.shape}")
        for strength in strengths.tolist():
            check_strength(strength)
        envs._start(engine, np.ascontiguousarray(indices, np.int64), np.ascontiguousarray(strengths, np.float32), None)

    def recv(self) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Wait for a batch of results."""
        return self._envs.recv()
