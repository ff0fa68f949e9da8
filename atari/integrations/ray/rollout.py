"""`Rollout`: a batch of steps of an actor's environments; and `FrameTable`, which stores images once."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

Bytes = npt.NDArray[np.uint8]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Rollout:
    """Steps of the environments of one actor: `steps` of each of its `num_envs` environments.

    Arrays from Ray's object store are read-only views of its memory. The memory stays in use as long as one of these
    arrays exists.

    Attributes:
        actor: index of the actor.
        number: number of this batch among the batches of its actor, 0, 1, ... without gaps.
        version: version of the weights that chose the actions, 0 before the first `set_weights`.
        observations_table: uint8 (entries, ...), single frames, or whole observations if nothing is stacked.
        observations_index: int32 (steps + 1, num_envs, stack_num), the entry in the table of each frame of each
            observation; None if nothing is stacked: then the table is (steps + 1, num_envs, ...).
        actions: (steps, num_envs), the policy's results.
        rewards: (steps, num_envs).
        terminations, truncations: bool (steps, num_envs).
        valid: bool (steps, num_envs), false for a step that only began a new episode and ignored its action: it is no
            transition.
        extras: the arrays that the policy returned beside actions, by name, (steps, num_envs, ...) each.
        scores, lengths: for the whole games that ended, in order: the sum of the rewards without clipping, float64
            (n,), and the number of emulated frames, int64 (n,).

    Example:
        >>> for rollout in actors:  # doctest: +SKIP
        ...     observations = rollout.observations_at(*np.nonzero(rollout.valid))
        ...     learn(observations, rollout.actions[rollout.valid], rollout.rewards[rollout.valid])
    """

    actor: int
    number: int
    version: int
    observations_table: Bytes
    observations_index: npt.NDArray[np.int32] | None
    actions: npt.NDArray[Any]
    rewards: npt.NDArray[Any]
    terminations: Bools
    truncations: Bools
    valid: Bools
    extras: dict[str, npt.NDArray[Any]] = field(default_factory=dict)
    scores: npt.NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    lengths: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))

    @property
    def observations(self) -> Bytes:
        """All observations, uint8 (steps + 1, num_envs, ...): row t is before step t, row t + 1 after it.

        If frames are stacked, each call makes a new array; `observations_at` makes the observations of a minibatch.
        """
        table, index = self.observations_table, self.observations_index
        return table if index is None else table[index]

    def observations_at(self, steps: Any, environments: Any) -> Bytes:
        """The observations before some steps, uint8 (n, ...).

        Args:
            steps: integers (n,), 0..steps; the last is after the last step.
            environments: integers (n,), of the actor's environments.

        Raises:
            IndexError: there is no such step or environment.

        Example:
            `rollout.observations_at(*np.nonzero(rollout.valid))` are the observations of all transitions.
        """
        table, index = self.observations_table, self.observations_index
        return table[steps, environments] if index is None else table[index[steps, environments]]

    @property
    def nbytes(self) -> int:
        """Bytes of all arrays."""
        arrays = [value for value in vars(self).values() if isinstance(value, np.ndarray)]
        return sum(array.nbytes for array in (*arrays, *self.extras.values()))


class FrameTable:
    """Stacked observations of a rollout, as a table of single frames and an index.

    An observation has one new frame, and shares the others with the observation before it. At the start and after the
    end of an episode it shares no frame: `whole` marks these observations, and all their frames are stored.

    Args:
        steps: number of steps of a rollout.
        shape: shape of the observations, (num_envs, stack_num, ...).
    """

    def __init__(self, steps: int, shape: tuple[int, ...]) -> None:
        self._num_envs, self._stack, *frame = shape
        self.index = np.zeros((steps + 1, self._num_envs, self._stack), np.int32)
        # Most rollouts have few ends: an eighth more than the new frames and the first stacks is enough.
        entries = (steps + self._stack) * self._num_envs
        self._table = np.zeros((entries + entries // 8, *frame), np.uint8)
        self._used = 0

    def begin(self, observations: Bytes) -> None:
        """Begin a rollout with its first observations; it overwrites the memory of earlier tables."""
        self._used = 0
        self._add_whole(0, np.arange(self._num_envs), observations)

    def add(self, row: int, observations: Bytes, whole: Bools) -> None:
        """Add the observations of row `row`; those in `whole` (num_envs,) share no frames with the last row."""
        self.index[row, :, :-1] = self.index[row - 1, :, 1:]
        self.index[row, :, -1] = self._add(observations[:, -1])
        if whole.any():
            rows = np.flatnonzero(whole)
            self._add_whole(row, rows, observations[rows])

    @property
    def table(self) -> Bytes:
        """The frames, (entries, ...): a view, until the next `begin`."""
        return self._table[: self._used]

    def _add_whole(self, row: int, environments: npt.NDArray[np.int64], observations: Bytes) -> None:
        flat = observations.reshape(-1, *observations.shape[2:])
        self.index[row, environments] = self._add(flat).reshape(-1, self._stack)

    def _add(self, frames: Bytes) -> npt.NDArray[np.int64]:
        start, end = self._used, self._used + len(frames)
        if end > len(self._table):
            self._table = np.concatenate([self._table, np.zeros_like(self._table[: max(end, len(self._table) // 2)])])
        self._table[start:end] = frames
        self._used = end
        return np.arange(start, end)
