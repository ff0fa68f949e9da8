"""Gymnasium's vector classes under the names of its newest release, also with older ones; and a caller of `step`.

Gymnasium 1.1 added `AutoresetMode`; Gymnasium 1.0 added `VectorWrapper` and the type parameters of `VectorEnv`. In some
releases, a deleted `VectorWrapper` closes its environment, which the program may still use, or recurses without end.
"""

import sys
from enum import Enum
from types import FrameType
from typing import TYPE_CHECKING, Any

from gymnasium import vector, wrappers

if TYPE_CHECKING or hasattr(vector, "AutoresetMode"):
    from gymnasium.vector import AutoresetMode, VectorEnv, VectorWrapper
else:

    class AutoresetMode(Enum):
        """The time at which a vector resets an environment that is done."""

        NEXT_STEP = "NextStep"
        SAME_STEP = "SameStep"
        DISABLED = "Disabled"

    class VectorEnv(vector.VectorEnv):
        """Gymnasium's class, with the attributes that 0.29 sets in `__init__`, which newer releases need not call."""

        closed = False
        is_vector_env = True
        viewer = None

    class VectorWrapper(getattr(vector, "VectorWrapper", None) or vector.VectorEnvWrapper):
        """Gymnasium's class, with the attributes that the wrapper of 0.29 does not take from its environment."""

        metadata = property(lambda self: self.env.metadata)
        render_mode = property(lambda self: self.env.render_mode)
        spec = property(lambda self: self.env.spec)

        def render(self):
            """Return the images of the environment."""
            return self.env.render()


if not TYPE_CHECKING and hasattr(VectorWrapper, "__del__"):

    class VectorWrapper(VectorWrapper):
        """Gymnasium's class, whose destructor leaves the environment open, as the newest release does."""

        def __del__(self):
            """Do nothing."""


def autoreset_mode(mode: Any) -> AutoresetMode:
    """The mode that a user gives: a member of `AutoresetMode`, its value, or its name in upper or lower case.

    Raises:
        ValueError: there is no such mode.
    """
    for member in AutoresetMode:
        if mode in (member, member.value, member.name, member.name.lower()):
            return member
    modes = ", ".join(repr(member.value) for member in AutoresetMode)
    raise ValueError(f"autoreset_mode must be an AutoresetMode or one of {modes}, got {mode!r}")


_RECORDERS = (wrappers, getattr(wrappers, "vector", wrappers))
_RECORDING = {module.RecordEpisodeStatistics.step.__code__ for module in _RECORDERS}


def adds_episode(env: Any) -> bool:
    """Whether Gymnasium's `RecordEpisodeStatistics` around `env` is calling `step`, and will add "episode" to `info`.

    It raises an error if the key exists. An inner environment does not know its wrappers, but its callers.
    """
    frame: FrameType | None = sys._getframe(1)
    while frame is not None:
        if frame.f_code in _RECORDING:
            wrapper = frame.f_locals["self"]
            if wrapper.unwrapped is env.unwrapped and getattr(wrapper, "_stats_key", "episode") == "episode":
                return True
        frame = frame.f_back
    return False


__all__ = ["AutoresetMode", "VectorEnv", "VectorWrapper", "adds_episode"]
