"""`AleRandom`: the generator from which ale-py's vector environment draws no-ops and frame skips.

It is the Mersenne Twister MT19937 (Matsumoto and Nishimura 1998), seeded by one word. `MersenneTwister` in
atari/emulator/machine/random.hpp is the same in C++; the vector engine draws from it.
"""

from typing import Any

import numpy as np

from atari.base.validation import check_integer
from atari.cores.options import SEED_LIMIT

_WORDS = 624


class AleRandom:
    """A Mersenne Twister with ale-py's way to draw a number from a range.

    Args:
        seed: 0 or more; its lowest 32 bits count; None draws a seed.
    """

    def __init__(self, seed: int | None = None) -> None:
        self._twister = np.random.MT19937()
        self.seed(seed)

    def seed(self, seed: int | None) -> int:
        """Start over with a seed, and return its lowest 32 bits; None draws a seed.

        Raises:
            TypeError, ValueError: the seed is no integer of 0 or more.
        """
        if seed is None:
            seed = int(np.random.SeedSequence().generate_state(1)[0])
        seed = check_integer("seed", seed, 0, 2**63 - 1) % SEED_LIMIT
        # A RandomState still uses the word itself as its seed. A new MT19937 hashes its seed.
        self._set_words(np.random.RandomState(seed).get_state(legacy=False)["state"])
        return seed

    def below(self, count: int) -> int:
        """A number within 0..count-1, without bias (Lemire 2019); for a count of 1 a word is drawn too."""
        product = self._twister.random_raw() * count
        if product % 2**32 < count:
            while product % 2**32 < (2**32 - count) % count:
                product = self._twister.random_raw() * count
        return int(product >> 32)

    def state(self) -> bytes:
        """The words of the twister and the position in them, little-endian."""
        state = self._twister.state["state"]
        return np.append(state["key"], state["pos"]).astype("<u4").tobytes()

    @classmethod
    def of_state(cls, state: bytes) -> "AleRandom":
        """The generator that continues from a result of `state`.

        Raises:
            ValueError: these are not such bytes.
        """
        words = np.frombuffer(state, "<u4") if len(state) == 4 * (_WORDS + 1) else np.zeros(_WORDS + 1, "<u4")
        key, position = words[:-1].astype(np.uint32), int(words[-1])
        # With a state of zeros (the twister ignores 31 of its bits), `below` would draw zeros for ever.
        if position > _WORDS or not (key[0] >> 31 or key[1:].any()):
            raise ValueError("the snapshot is damaged: ale_random is no state of a Mersenne Twister")
        generator = cls()
        generator._set_words({"key": key, "pos": position})
        return generator

    def _set_words(self, words: Any) -> None:
        self._twister.state = {"bit_generator": "MT19937", "state": words}
