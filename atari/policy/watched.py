"""`WatchedPolicy`: a policy that keeps the scores from which it has chosen its last actions."""

import copy
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.policy import Array, LoadedPolicy, ScoresPolicy


class WatchedPolicy(LoadedPolicy):
    """A policy that keeps the scores of its last call.

    Attributes:
        last_scores: (n, A) float32, for the rows of the last call a score of each of the policy's own actions; None for
            a policy that gives none, such as a function that returns actions.

    Args:
        policy: the policy. It is not changed: of a `ScoresPolicy` a copy is watched.

    Example:
        >>> import numpy as np
        >>> from atari.learning import ScoresPolicy, load_policy
        >>> from atari.policy.watched import WatchedPolicy
        >>> watched = WatchedPolicy(load_policy(ScoresPolicy(lambda observations: np.eye(4)[[1]])))
        >>> watched(np.zeros((1, 84, 84), np.uint8), np.zeros(1, np.int64)), watched.last_scores
        (array([1]), array([[0., 1., 0., 0.]], dtype=float32))
    """

    def __init__(self, policy: LoadedPolicy) -> None:
        self.last_scores: npt.NDArray[np.float32] | None = None
        inner = policy._policy
        if isinstance(inner, ScoresPolicy):
            inner = copy.copy(inner)
            inner._scores, inner._generators = self._keep(inner._scores), {}
        super().__init__(inner)
        self.name = policy.name

    def _keep(self, scores: Callable[[Any], Array]) -> Callable[[Any], Array]:
        def kept(observations: Any) -> Array:
            values = np.asarray(scores(observations))
            self.last_scores = values.astype(np.float32) if values.ndim == 2 else None
            return values

        return kept
