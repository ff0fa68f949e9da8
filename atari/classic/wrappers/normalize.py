"""`RunningMeanStd`: the mean and variance of all numbers so far."""

from typing import Any

import numpy as np
import numpy.typing as npt


class RunningMeanStd:
    """The mean and variance of batches, updated by the parallel algorithm (Chan et al. 1979).

    Args:
        epsilon: the weight of the initial mean 0 and variance 1, as a number of samples.
        shape: the shape of a sample.

    Example:
        >>> from atari.classic.wrappers.normalize import RunningMeanStd
        >>> moments = RunningMeanStd(shape=(2,))
        >>> moments.update([[1.0, 2.0], [3.0, 6.0]])
        >>> moments.mean.round(2).tolist()
        [2.0, 4.0]
    """

    def __init__(self, epsilon: float = 1e-4, shape: tuple[int, ...] = ()) -> None:
        self.mean: npt.NDArray[Any] = np.zeros(shape, "float64")
        self.var: npt.NDArray[Any] = np.ones(shape, "float64")
        self.count = epsilon

    def update(self, x: npt.ArrayLike) -> None:
        """Add a batch, (samples, *shape)."""
        batch = np.asarray(x)
        self.update_from_moments(np.mean(batch, axis=0), np.var(batch, axis=0), batch.shape[0])

    def update_from_moments(self, batch_mean: Any, batch_var: Any, batch_count: int) -> None:
        """Add a batch by its mean, its variance and the number of its samples."""
        delta, count = batch_mean - self.mean, self.count + batch_count
        squares = self.var * self.count + batch_var * batch_count + delta**2 * self.count * batch_count / count
        self.mean, self.var, self.count = self.mean + delta * batch_count / count, squares / count, count
