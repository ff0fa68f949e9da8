"""`prng.seed(0)`: one generator for the samples of all spaces, as before 2018.

After `prng.seed`, every space that was not seeded or sampled before draws from this generator.
"""

from typing import Any

import numpy as np

np_random: np.random.Generator | None = None


def seed(seed: int | None = None) -> None:
    """Begin the stream of a seed; None chooses one."""
    global np_random
    np_random = np.random.default_rng(seed)


class Shared:
    """A space that draws from the common generator unless it has its own."""

    @property
    def np_random(self) -> np.random.Generator:
        """The generator of `sample`."""
        if np_random is not None and vars(self)["_np_random"] is None:
            return np_random
        own: Any = super()
        return own.np_random
