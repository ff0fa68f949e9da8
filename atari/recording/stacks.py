"""The stacks of observations of which each frame is stored once: how a stack follows from the stack before it."""

from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


class Stacking(IntEnum):
    """How the stack of a state follows from that of the state before it, and from the state's own frame."""

    ADDED = 0
    """The oldest frame is dropped, and the state's frame is added."""
    BEGUN = 1
    """The stack begins with the state's frame; the padding fills the other places."""
    ADDED_TWICE = 2
    """As `ADDED`, two times: by the step that lost a life, and by a reset that keeps the stack (`seamless_lives`)."""


def next_stack(stack: Array, frame: Array, stacking: int, padding: str, blank: int = 0) -> Array:
    """The stack of a state, (stack_num, ...).

    Args:
        stack: the stack of the state before; its values have no effect where a stack begins.
        frame: the state's frame, or the number of its row.
        stacking: a value of `Stacking`.
        padding: "zero" or "reset", see `atari.Task`.
        blank: the value of padding with zeros.
    """
    if stacking == Stacking.BEGUN:
        begun = np.full_like(stack, blank) if padding == "zero" else np.broadcast_to(frame, stack.shape).copy()
        begun[-1] = frame
        return begun
    count = min(2 if stacking == Stacking.ADDED_TWICE else 1, len(stack))
    return np.concatenate([stack[count:], *[frame[None]] * count])


def stacking_of(before: Array | None, stack: Array, begins: bool, padding: str) -> Stacking:
    """How a stack follows from the one before it.

    Args:
        before: the stack of the state before; None in the first state of a game.
        stack: the stack.
        begins: whether a reset has made it.
        padding: see `next_stack`.

    Raises:
        ValueError: it does not follow from its newest frame.
    """
    likely = (Stacking.BEGUN, Stacking.ADDED_TWICE, Stacking.ADDED) if begins else (Stacking.ADDED,)
    for stacking in likely[: 1 if before is None else None]:
        if np.array_equal(next_stack(stack if before is None else before, stack[-1], stacking, padding), stack):
            return stacking
    raise ValueError(
        "a reset after a lost life adds several frames to the stack (seamless_lives with on_reset='noop'), and a data "
        'set has one frame of each state; write the screens (observations="screen")'
    )


def rows_of_stacks(stackings: npt.NDArray[np.uint8], stack_num: int, padding: str) -> npt.NDArray[np.int64]:
    """The rows of the frames in the stack of each state, (states, stack_num), the oldest first; -1 is a frame of zeros.

    Args:
        stackings: (states,), see `Stacking`.
        stack_num: frames in a stack.
        padding: see `next_stack`.

    Example:
        >>> import numpy as np
        >>> rows_of_stacks(np.array([1, 0, 1], np.uint8), 3, "zero").tolist()
        [[-1, -1, 0], [-1, 0, 1], [-1, -1, 2]]
    """
    rows = np.empty((len(stackings), stack_num), np.int64)
    stack = np.full(stack_num, -1, np.int64)
    for row, stacking in enumerate(stackings.tolist()):
        stack = rows[row] = next_stack(stack, np.int64(row), stacking, padding, blank=-1)
    return rows
