"""`Choice`: how the action of a step was chosen."""

from enum import IntEnum
from typing import Any


class Choice(IntEnum):
    """How the action of a step was chosen; the values stand in data sets."""

    UNKNOWN = 0
    """By a person, or by a policy that does not say how."""
    GREEDY = 1
    """By the policy, without a draw."""
    SAMPLED = 2
    """Drawn by the policy."""
    EXPLORATION = 3
    """Drawn in place of the policy's action, with the probability epsilon of an evaluation protocol."""

    @classmethod
    def of(cls, policy: Any) -> "Choice":
        """How a policy chooses, according to its attribute `sample`."""
        sample = getattr(policy, "sample", None)
        return (cls.SAMPLED if sample else cls.GREEDY) if isinstance(sample, bool) else cls.UNKNOWN
