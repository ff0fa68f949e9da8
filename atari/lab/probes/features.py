"""`features_of`: the features that an encoder makes of the observations of a split."""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.cores import ByteArray
from atari.lab.probes.data import Split

Encoder = Callable[[ByteArray], Any]

_BATCH = 256


def features_of(encoder: Encoder, split: Split) -> npt.NDArray[np.float32]:
    """The features of a split, (n, width) float32.

    Args:
        encoder: a function of observations (n, ...) uint8 that returns n rows: an array, or a tensor of PyTorch.

    Raises:
        ValueError: the encoder returns another number of rows, or features that are not finite.
    """
    parts = []
    for start in range(0, len(split), _BATCH):
        observations = split.observations[start : start + _BATCH]
        part = _array(encoder(observations))
        if part.ndim < 1 or len(part) != len(observations):
            raise ValueError(
                f"the encoder must return {len(observations)} rows for {len(observations)} observations, got "
                f"{part.shape}"
            )
        parts.append(part.reshape(len(part), -1))
    features: npt.NDArray[np.float32] = np.concatenate(parts)
    if not np.isfinite(features).all():
        raise ValueError("the encoder returned features that are not finite")
    return features


def _array(features: Any) -> npt.NDArray[np.float32]:
    if hasattr(features, "detach"):  # a tensor, perhaps with a gradient and on a GPU
        features = features.detach().float().cpu().numpy()
    return np.asarray(features, np.float32)
