"""`standstill`: when the score of a training stopped to rise, and how much the agent explored and learned then."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from atari.learning.diagnosis.findings import percent

_NEAR = 0.05
"""A score within this part of the whole rise is as good as the last one."""
_LEAST = 0.2
"""A standstill is at least this part of a training."""


@dataclass(frozen=True)
class Standstill:
    """The last part of a training, in which the score did not rise.

    Attributes:
        score: the score at its end.
        frames, of_frames: emulated frames at its beginning, and of the whole training.
        epsilon: the probability of a random action at its beginning; None for an agent without.
        rate: the learning rate there, as a part of the first one; None if the log does not say it.
        lanes: whether environments had epsilons of their own.

    Example:
        >>> from atari.learning.diagnosis.training_log import Standstill
        >>> print(Standstill(8090.0, 114e6, 199e6, 0.045, None, False))
        The score is at 8,090 from 114 of 199 million frames on. Then epsilon is 0.045.
    """

    score: float
    frames: float
    of_frames: float
    epsilon: float | None
    rate: float | None
    lanes: bool

    def __str__(self) -> str:
        first = (
            f"The score is at {self.score:,.0f} from {self.frames / 1e6:.0f} of {self.of_frames / 1e6:.0f} million "
            "frames on."
        )
        facts = [
            *([] if self.epsilon is None or self.lanes else [f"epsilon is {self.epsilon:.2g}"]),
            *([] if self.rate is None else [f"the learning rate is {percent(self.rate)} of the first one"]),
        ]
        return f"{first} Then {' and '.join(facts)}." if facts else first

    @property
    def options(self) -> tuple[str, ...]:
        """Options of `atari train` to try: more exploration and a higher rate where the score stood still."""
        return (
            *(["--lane-epsilon 0.4"] if self.epsilon is not None and not self.lanes and self.epsilon < 0.1 else []),
            *(["--anneal-from 0.8"] if self.rate is not None and self.rate < 0.5 else []),
        )


def standstill(rows: Sequence[Mapping[str, float]], options: Mapping[str, Any]) -> Standstill | None:
    """The standstill at the end of a training; None if the score rose until then.

    Args:
        rows: the rows of the log, see `RunFolder.rows`.
        options: the options of the training, as in its configuration.

    Example:
        >>> from atari.learning.diagnosis.training_log import standstill
        >>> rows = [{"step": n, "frames": 4 * n, "score": min(n, 50), "epsilon": 0.1} for n in range(100)]
        >>> standstill(rows, {"total_steps": 100}).frames
        192
    """
    known = [row for row in rows if np.isfinite(row["score"])]
    if len(known) < 20:
        return None
    scores = np.array([row["score"] for row in known])
    width = max(1, len(scores) // 50)
    smooth = np.convolve(np.pad(scores, (width - 1, 0), mode="edge"), np.full(width, 1 / width), "valid")
    near = smooth >= smooth[-1] - _NEAR * (smooth.max() - smooth.min())
    first = known[int(np.flatnonzero(~near)[-1]) + 1] if not near.all() else known[0]
    last = known[-1]
    if smooth[-1] < smooth.max() - 2 * _NEAR * (smooth.max() - smooth.min()):  # it fell: another matter
        return None
    if last["frames"] - first["frames"] < _LEAST * last["frames"]:
        return None
    return Standstill(
        score=float(smooth[-1]),
        frames=first["frames"],
        of_frames=last["frames"],
        epsilon=first.get("epsilon"),
        rate=_rate(first, options),
        lanes=options.get("lane_epsilon") is not None,
    )


def _rate(row: Mapping[str, float], options: Mapping[str, Any]) -> float | None:
    """The learning rate of a row as a part of the first one."""
    if "learning_rate" in row and options.get("learning_rate"):
        return row["learning_rate"] / options["learning_rate"]
    if not options.get("anneal") or not options.get("total_steps"):
        return None
    start = options.get("anneal_from", 0.0)
    return min(1.0, (1 - row["step"] / options["total_steps"]) / (1 - start))
