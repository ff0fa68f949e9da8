"""The last observations of episodes, read from the `info` of a vector environment in SAME_STEP."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.learning.memory.options import Part

_KEYS = ("final_obs", "final_observation")


def final_observations(
    info: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None,
    ended: npt.NDArray[np.bool_],
    parts: tuple[Part, ...],
    named: bool,
) -> list[npt.NDArray[np.uint8]]:
    """By part, an array (num_envs, *shape) with the last observations of the environments that ended.

    `info` has one array or a dict of arrays from `AtariVectorEnv`, and an object array of observations from Gymnasium's
    vector environments. From Gymnasium's `DictInfoToList` it is a list with a dict for each environment.

    Raises:
        ValueError: `info` has no last observations, or one has another shape.
    """
    if isinstance(info, Sequence):
        info = {key: [one.get(key) for one in info] for key in _KEYS if any(key in one for one in info)}
    key = next((key for key in _KEYS if key in (info or {})), None)
    if info is None or key is None:
        raise ValueError("an episode has ended, and info has no final_obs; autoreset_mode is SAME_STEP here")
    found = info[key]
    return [_rows(found[part.name] if _is_dict(found, named) else found, ended, part, named) for part in parts]


def _is_dict(found: Any, named: bool) -> bool:
    return named and isinstance(found, Mapping)


def _rows(found: Any, ended: npt.NDArray[np.bool_], part: Part, named: bool) -> npt.NDArray[np.uint8]:
    shape = (len(ended), *part.shape)
    if isinstance(found, np.ndarray) and found.dtype == np.uint8:
        if found.shape != shape:
            raise ValueError(f"final_obs must be uint8 {shape}, got {found.shape}")
        return np.ascontiguousarray(found)
    result = np.zeros(shape, np.uint8)
    for lane in np.flatnonzero(ended):
        frame = found[lane]
        if named and isinstance(frame, Mapping):
            frame = frame[part.name]
        if frame is None or np.shape(frame) != part.shape or np.asarray(frame).dtype != np.uint8:
            raise ValueError(f"final_obs of environment {lane} must be uint8 {part.shape}, got {np.shape(frame)}")
        result[lane] = frame
    return result
