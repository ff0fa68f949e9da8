"""The generator of ale-py's vector environment, against the published twister and the rule of the paper."""

import copy
import pickle
from collections.abc import Iterator

import numpy as np
import pytest

from atari.cores.ale_random import AleRandom


def words(seed: int) -> Iterator[int]:
    """The tempered words of MT19937 with the initialisation of Matsumoto and Nishimura's `init_genrand`."""
    state = [seed]
    for i in range(1, 624):
        state.append((1812433253 * (state[-1] ^ state[-1] >> 30) + i) % 2**32)
    while True:
        for i in range(624):
            y = (state[i] & 0x80000000) | (state[(i + 1) % 624] & 0x7FFFFFFF)
            state[i] = state[(i + 397) % 624] ^ y >> 1 ^ (0x9908B0DF if y & 1 else 0)
        for y in state:
            y ^= y >> 11
            y ^= (y << 7) & 0x9D2C5680
            y ^= (y << 15) & 0xEFC60000
            yield y ^ y >> 18


def below(drawn: Iterator[int], count: int) -> int:
    """Lemire 2019, algorithm 5, for words of 32 bits."""
    product = next(drawn) * count
    while product % 2**32 < 2**32 % count:
        product = next(drawn) * count
    return product // 2**32


def test_the_published_first_word() -> None:
    assert next(words(5489)) == 3499211612
    assert AleRandom(5489).below(2**32) == 3499211612


@pytest.mark.parametrize("seed", [0, 1, 42, 2**31 - 1])
@pytest.mark.parametrize("count", [1, 2, 30, 31, 3 * 2**30, 2**31 + 1])  # of the last, half of the words are refused
def test_draws_without_bias(seed: int, count: int) -> None:
    generator, drawn = AleRandom(seed), words(seed)
    assert [generator.below(count) for _ in range(1000)] == [below(drawn, count) for _ in range(1000)]


def test_a_count_of_one_draws_a_word() -> None:
    generator, drawn = AleRandom(7), words(7)
    assert generator.below(1) == 0
    next(drawn)
    assert generator.below(30) == below(drawn, 30)


def test_seeding_starts_over() -> None:
    generator = AleRandom(3)
    first = [generator.below(30) for _ in range(700)]
    assert generator.seed(3) == 3
    assert [generator.below(30) for _ in range(700)] == first
    assert generator.seed(np.int64(4)) == 4  # type: ignore[arg-type]
    assert [generator.below(30) for _ in range(700)] != first


def test_without_a_seed_each_is_another() -> None:
    assert len({AleRandom().state() for _ in range(5)}) == 5
    generator = AleRandom(3)
    seed = generator.seed(None)
    assert generator.state() == AleRandom(seed).state()


@pytest.mark.parametrize("drawn", [0, 1, 623, 624, 1000])
def test_a_state_continues(drawn: int) -> None:
    generator = AleRandom(5)
    for _ in range(drawn):
        generator.below(2**32)
    copies = [AleRandom.of_state(generator.state()), copy.deepcopy(generator), pickle.loads(pickle.dumps(generator))]
    expected = [generator.below(30) for _ in range(700)]
    for other in copies:
        assert [other.below(30) for _ in range(700)] == expected


@pytest.mark.parametrize("seed", [-1, 2**63])
def test_refuses_seeds_that_are_none(seed: int) -> None:
    generator = AleRandom(5)
    before = generator.state()
    with pytest.raises(ValueError, match=r"seed must be within 0\.\."):
        generator.seed(seed)
    assert generator.state() == before


GOOD = AleRandom(5).state()
ZEROS = b"\xff\xff\xff\x7f" + bytes(4 * 623) + (624).to_bytes(4, "little")


@pytest.mark.parametrize("state", [b"", GOOD[:-1], GOOD + b"\0", GOOD[:-4] + b"\x71\x02\0\0", ZEROS])
def test_refuses_what_is_no_state(state: bytes) -> None:
    with pytest.raises(ValueError, match="the snapshot is damaged: ale_random is no state of a Mersenne Twister"):
        AleRandom.of_state(state)
