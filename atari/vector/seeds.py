"""Seeds of the environments of a vector, in the engine's form."""

from typing import Any

import numpy as np
import numpy.typing as npt

from atari.cores.options import SEED_LIMIT


def seed_words(
    seed: Any, mask: npt.NDArray[np.bool_], *, ale: bool
) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.uint32]]:
    """Whether each environment is seeded, (environments,), and its seed words, (environments, 9) uint32.

    The first word seeds the emulator, which gets 2**32-2 in place of 2**32-1. The other eight are the state of
    the episode's generator; with `ale`, which draws no-ops as ale-py does, all words are the seed.

    Args:
        seed: see `AtariVectorEnv.reset`.
        mask: the environments that are reset.
        ale: whether the environments are seeded like ale-py's vector environment, not like `AtariEnv.reset`.

    Raises:
        TypeError, ValueError: the seeds are of the wrong kind, number or range.
    """
    values = _seed_values(seed, mask)
    seeds = np.zeros((len(mask), 9), np.uint32)
    for environment, value in values.items():
        seeds[environment] = words_of(value, ale=ale)
    seeded = np.zeros(len(mask), np.bool_)
    seeded[list(values)] = True
    return seeded, seeds


def _seed_values(seed: Any, mask: npt.NDArray[np.bool_]) -> dict[int, int]:
    """The seed of each environment that is seeded. Raises as `seed_words` does."""
    chosen = np.flatnonzero(mask).tolist()
    if seed is None:
        return {}
    if isinstance(seed, (int, np.integer)) and not isinstance(seed, bool):
        if not 0 <= seed < SEED_LIMIT:
            raise ValueError(f"seed must be within 0..2**32-1, got {seed}")
        return {environment: int(seed) + number for number, environment in enumerate(chosen)}
    try:
        values = np.array([-1 if value is None else value for value in seed])
    except (TypeError, ValueError):
        values = np.array("")
    if values.dtype.kind not in "iu" and values.shape != (0,):
        raise TypeError(f"seed must be an integer, integers for each environment, or None, got {seed!r}")
    if values.shape != (len(chosen),):
        raise ValueError(
            f"seed must have one entry per sub-environment that is reset, {len(chosen)}, got {len(values)}"
        )
    if (values >= SEED_LIMIT).any():
        raise ValueError(f"seeds must be within 0..2**32-1, got {seed!r}")
    return {environment: value for environment, value in zip(chosen, values.tolist(), strict=True) if value >= 0}


def words_of(seed: int, *, ale: bool) -> list[int]:
    """The words of one seed, see `seed_words`. With `ale`, a seed above 2**32-1 wraps to 0."""
    if ale:
        word = seed % SEED_LIMIT
        return [min(word, SEED_LIMIT - 2), *[word] * 8]
    first, second = (int(word) for word in np.random.SeedSequence(seed).generate_state(2))
    state: Any = np.random.PCG64(np.random.SeedSequence(first)).state["state"]
    words = [state[name] >> shift & 0xFFFFFFFF for name in ("state", "inc") for shift in (0, 32, 64, 96)]
    return [min(second, SEED_LIMIT - 2), *words]
