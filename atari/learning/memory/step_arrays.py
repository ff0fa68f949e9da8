"""`StepArrays` checks the arrays of a step that a user adds to a `ReplayMemory`."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.learning.memory.options import MemoryOptions, as_numpy

_FINAL_KEYS = ("final_obs", "final_observation")


class StepArrays:
    """Checks arrays against the options of a memory, and converts them to what the memory stores.

    All methods raise TypeError or ValueError with the value and its place.

    Attributes:
        shape: (num_envs,).
        frame_shapes: by part, (num_envs, *shape) of one frame.
        named: whether observations are dicts of parts.
    """

    def __init__(self, options: MemoryOptions) -> None:
        self.shape = (options.num_envs,)
        self.frame_shapes = {part.name: (*self.shape, *part.shape) for part in options.parts}
        self.named = list(self.frame_shapes) != [""]
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
        if self.named and not (isinstance(observations, Mapping) and set(observations) >= set(self.frame_shapes)):
            raise TypeError(f"{name} must be a dict with the keys {', '.join(self.frame_shapes)}")
        result = []
        for part, shape in self.frame_shapes.items():
            array = as_numpy(name, observations[part] if self.named else observations)
            if array.dtype != np.uint8 or array.shape != shape:
                raise ValueError(f"{name} must be uint8 {shape}, got {array.dtype} {array.shape}")
            result.append(array)
        return result

    def finals(
        self, info: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None, ended: npt.NDArray[np.bool_]
    ) -> list[npt.NDArray[np.uint8]]:
        """By part, an array (num_envs, *shape) with the last observations of the environments that ended.

        `info` is of a vector environment in SAME_STEP. It has one array or a dict of arrays from `AtariVectorEnv`, and
        an object array of observations from Gymnasium's vector environments. From Gymnasium's `DictInfoToList` it is a
        list with a dict for each environment.
        """
        if isinstance(info, Sequence):
            info = {key: [one.get(key) for one in info] for key in _FINAL_KEYS if any(key in one for one in info)}
        key = next((key for key in _FINAL_KEYS if key in (info or {})), None)
        if info is None or key is None:
            raise ValueError("an episode has ended, and info has no final_obs; autoreset_mode is SAME_STEP here")
        found = info[key]
        by_part = self.named and isinstance(found, Mapping)
        shapes = self.frame_shapes.items()
        return [self._final_rows(found[part] if by_part else found, ended, part, shape) for part, shape in shapes]

    def _final_rows(
        self, found: Any, ended: npt.NDArray[np.bool_], part: str, shape: tuple[int, ...]
    ) -> npt.NDArray[np.uint8]:
        if isinstance(found, np.ndarray) and found.dtype == np.uint8:
            if found.shape != shape:
                raise ValueError(f"final_obs must be uint8 {shape}, got {found.shape}")
            return np.ascontiguousarray(found)
        result = np.zeros(shape, np.uint8)
        for lane in np.flatnonzero(ended):
            frame = found[lane]
            if self.named and isinstance(frame, Mapping):
                frame = frame[part]
            if frame is None or np.shape(frame) != shape[1:] or np.asarray(frame).dtype != np.uint8:
                raise ValueError(f"final_obs of environment {lane} must be uint8 {shape[1:]}, got {np.shape(frame)}")
            result[lane] = frame
        return result
