"""Random generators with Gym's seeding: `self.np_random, seed = seeding.np_random(seed)`.

They are NumPy's `RandomState`s, with `randint` and `rand`, in streams that have not changed since 2016: an environment
seeded with 0 draws the same numbers as then. A seed is hashed first, so that neighbouring seeds have unrelated streams.
"""

import hashlib
import operator
import os

import numpy as np

_BYTES = 8

RNG = RandomNumberGenerator = np.random.Generator
"""The names of a generator in Gym 0.26; `np_random` returns a `RandomState` here, as before."""


def np_random(seed: int | None = None) -> tuple[np.random.RandomState, int]:
    """A generator and its seed; None chooses a random seed.

    Raises:
        ValueError: the seed is negative.
        TypeError: the seed is not an integer.
    """
    if seed is not None and operator.index(seed) < 0:
        raise ValueError(f"a seed is an integer of 0 or more, or None, got {seed}")
    seed = create_seed(seed)
    hashed = hash_seed(seed)
    words = [hashed & 0xFFFFFFFF, hashed >> 32]
    return np.random.RandomState(words if words[1] else words[:1]), seed


def create_seed(a: int | str | None = None, max_bytes: int = _BYTES) -> int:
    """A seed of at most `max_bytes` from a number or a text, or a random one."""
    if a is None:
        return int.from_bytes(os.urandom(max_bytes), "little")
    if isinstance(a, str):
        text = a.encode()
        return int.from_bytes((text + hashlib.sha512(text).digest())[:max_bytes], "little")
    return operator.index(a) % (1 << 8 * max_bytes)


def hash_seed(seed: int | None = None, max_bytes: int = _BYTES) -> int:
    """A number of at most `max_bytes`, a function of the seed alone."""
    digest = hashlib.sha512(str(create_seed() if seed is None else seed).encode()).digest()
    return int.from_bytes(digest[:max_bytes], "little")
