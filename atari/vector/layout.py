"""`Layout`: the axes and the dtype in which a vector environment returns the engine's observations."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from atari.task import Task
from atari.task.checks import check_bool

_DTYPES = ("uint8", "float32")


@dataclass(frozen=True)
class Layout:
    """The axes and the dtype of returned observations. The engine writes uint8, with the stack before height and width.

    Attributes:
        channels_last: images are (height, width, stack), in RGB (height, width, 3 * stack).
        stacked: images have an axis for the stack; otherwise the stack is one image.
        dtype: "uint8" or "float32"; the values stay 0..255.
        indicators: the number of players with their own observations, which have an indicator of the player; 0 means
            one observation for all.
    """

    channels_last: bool = False
    dtype: str = "uint8"
    indicators: int = 0
    stacked: bool = True

    @classmethod
    def check(cls, task: Task, channels_last: Any, dtype: Any) -> "Layout":
        """The layout of the observations of a task.

        Raises:
            TypeError, ValueError: there is no such dtype, or the observations have no channels.
        """
        channels_last = check_bool("channels_last", channels_last)
        if channels_last and not task.kind.image:
            raise ValueError("obs_type='ram' has no channels; leave channels_last=True out")
        if channels_last and task.stack_num is None:
            raise ValueError(
                "channels_last=True puts the stack last, and stack_num=None has none; leave one of them out"
            )
        if task.agent_indicator and task.kind.colours and task.stack_num is not None and not channels_last:
            raise ValueError("agent_indicator adds channels, which RGB images have last; add channels_last=True")
        try:
            name = np.dtype(dtype).name
        except TypeError:
            raise TypeError(f"dtype must be 'uint8' or 'float32', got {dtype!r}") from None
        if dtype is None or name not in _DTYPES:
            raise ValueError(f"dtype must be 'uint8' or 'float32', got {dtype!r}")
        stacked = not task.kind.image or task.stack_num is not None
        return cls(channels_last, name, task.players if task.agent_indicator else 0, stacked)

    @property
    def is_engines(self) -> bool:
        """Whether observations are returned in the engine's form."""
        return self == Layout()

    def given(self) -> str:
        """The options that change the engine's form."""
        options = {
            "channels_last": self.channels_last,
            "dtype": self.dtype != "uint8",
            "agent_indicator": self.indicators,
            "stack_num=None": not self.stacked,
        }
        return " and ".join(name for name, differs in options.items() if differs)

    def space(self, space: spaces.Space[Any]) -> spaces.Space[Any]:
        """The space of one observation in this layout, from the engine's space."""
        if self.is_engines:
            return space
        if isinstance(space, spaces.Dict):
            return spaces.Dict({name: self.space(part) for name, part in space.spaces.items()})
        row = np.empty((1, *(space.shape or ())), np.uint8)
        return spaces.Box(0, 255, self._array(row).shape[1:], np.dtype(self.dtype).type)

    def apply(self, observation: Any) -> Any:
        """A batch of the engine's observations in this layout: a view, or a copy if float32 or stacked in RGB."""
        if isinstance(observation, dict):
            return {name: self._array(part) for name, part in observation.items()}
        return self._array(observation)

    def _array(self, array: npt.NDArray[Any]) -> npt.NDArray[Any]:
        if not self.stacked and array.ndim >= 4:
            array = array[:, 0]
        if self.channels_last and array.ndim >= 4:
            count, stack, height, width, *colours = array.shape
            array = array.transpose(0, 2, 3, 1, *range(4, array.ndim))
            array = array.reshape(count, height, width, stack * colours[0]) if colours else array
        if self.indicators:
            array = self._with_indicators(array)
        return array if self.dtype == "uint8" else array.astype(np.float32)  # `astype` keeps the strides

    def _with_indicators(self, array: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """An observation for each player, (batch, players, ...), with a channel a player added: 255 in its own, else 0.

        This is the indicator of SuperSuit's `agent_indicator_v0`. The channels of RAM are its bytes.
        """
        players = self.indicators
        axis = 2 if array.ndim == 4 and self.stacked and not self.channels_last else -1  # the result's channels
        one_each = np.broadcast_to(array[:, None], (len(array), players, *array.shape[1:]))
        widths = [(0, 0)] * one_each.ndim
        widths[axis] = (0, players)
        result = np.pad(one_each, widths)
        channels = np.moveaxis(result, axis, 2)
        for player in range(players):
            channels[:, player, player - players] = 255
        return result
