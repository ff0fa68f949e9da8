"""`StepArrays` checks the arrays of a step that a user adds to a `ReplayMemory`."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.learning.memory.options import MemoryOptions, as_numpy


class StepArrays:
    """Checks arrays against the options of a memory, and converts them to what the memory stores.

    All methods raise TypeError or ValueError with the value and its place.

    Attributes:
        shape: (num_envs,).
        frame_shapes: by part, (num_envs, *shape) of one frame.
    """

    def __init__(self, options: MemoryOptions) -> None:
        self.shape = (options.num_envs,)
        self.frame_shapes = {part.name: (*self.shape, *part.shape) for part in options.parts}
        self._action_shape, self._action_dtype = (*self.shape, *options.action_shape), np.dtype(options.action_dtype)

    def flags(self, name: str, values: Any) -> npt.NDArray[np.bool_]:
        """Bools, one for each environment."""
        array = as_numpy(name, values)
        if array.dtype != np.bool_ or array.shape != self.shape:
            raise ValueError(f"{name} must be bool {self.shape}, got {array.dtype} {array.shape}")
        return np.ascontiguousarray(array)

    def rewards(self, values: Any) -> npt.NDArray[np.float32]:
        """Rewards as float32, none of which has become infinite; the extension module refuses others."""
        array = as_numpy("rewards", values)
        if array.dtype.kind not in "iufb" or array.shape != self.shape:
            raise ValueError(f"rewards must be numbers {self.shape}, got {array.dtype} {array.shape}")
        if array.dtype.kind != "f" or array.dtype.itemsize <= 4:
            return np.ascontiguousarray(array, np.float32)
        try:
            with np.errstate(over="raise"):
                return np.ascontiguousarray(array, np.float32)
        except FloatingPointError:
            lane = int(np.argmax(np.abs(array)))
            raise ValueError(
                f"the reward of environment {lane} is {array[lane]}; rewards are stored as float32, at most 3.4e38"
            ) from None

    def actions(self, values: Any) -> npt.NDArray[np.uint8]:
        """The bytes of actions that the memory's dtype can store."""
        array, shape, dtype = as_numpy("actions", values), self._action_shape, self._action_dtype
        if array.dtype != dtype and not np.can_cast(array.dtype, dtype, "same_kind"):
            raise TypeError(f"actions must be {dtype} {shape}, got {array.dtype}")
        if array.shape != shape:
            raise ValueError(f"actions must have the shape {shape}, got {array.shape}")
        if array.dtype == dtype:
            stored = np.ascontiguousarray(array)
        else:
            with np.errstate(over="ignore"):
                stored = np.ascontiguousarray(array, dtype)
        if dtype.kind == "f" or array.dtype != dtype:
            good = np.isfinite(stored) if dtype.kind == "f" else stored == array
            if not good.all():
                place = tuple(int(i) for i in np.argwhere(~good)[0])
                raise ValueError(
                    f"the action of environment {place[0]} is {array[place]}, and action_dtype {dtype} stores finite "
                    "numbers in its range; make the memory with another action_dtype"
                )
        return stored.reshape(-1).view(np.uint8)

    def frames(self, name: str, observations: Any) -> list[npt.NDArray[np.uint8]]:
        """The frames of all environments, by part."""
        named = list(self.frame_shapes) != [""]
        if named and not (isinstance(observations, Mapping) and set(observations) >= set(self.frame_shapes)):
            raise TypeError(f"{name} must be a dict with the keys {', '.join(self.frame_shapes)}")
        result = []
        for part, shape in self.frame_shapes.items():
            array = as_numpy(name, observations[part] if named else observations)
            if array.dtype != np.uint8 or array.shape != shape:
                raise ValueError(f"{name} must be uint8 {shape}, got {array.dtype} {array.shape}")
            result.append(array)
        return result
