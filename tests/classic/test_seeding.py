"""The generators are Gym's: these numbers are in its documentation and in tutorials."""

import numpy as np
import pytest

import atari.classic as gym
from atari.classic.utils import seeding

CARTPOLE = {  # the first states after env.seed(...), as in the documentation of gym.vector.make (Gym 0.12 to 0.21)
    0: [-0.04456399, 0.04653909, 0.01326909, -0.02099827],
    1: [0.03073904, 0.00145001, -0.03088818, -0.03131252],
    2: [0.03468829, 0.01500225, 0.01230312, 0.01825218],
}


@pytest.mark.parametrize("seed", CARTPOLE)
def test_streams_are_those_of_gym(seed: int) -> None:
    rng, used = seeding.np_random(seed)
    assert used == seed
    np.testing.assert_allclose(rng.uniform(-0.05, 0.05, 4), CARTPOLE[seed], atol=5e-9)


@pytest.mark.parametrize("seed", CARTPOLE)
def test_cartpole_starts_where_it_did(seed: int) -> None:
    env = gym.make("CartPole-v1")
    assert env.seed(seed) == [seed]
    np.testing.assert_allclose(env.reset(), CARTPOLE[seed], atol=5e-9)


def test_generators_have_the_methods_of_old() -> None:
    rng, _ = seeding.np_random(3)
    assert rng.randint(10) in range(10)
    assert 0 <= rng.rand() < 1
    assert rng.choice(["a", "b"]) in ("a", "b")


def test_without_a_seed_it_is_chosen() -> None:
    (first, a), (second, b) = seeding.np_random(), seeding.np_random()
    assert a != b
    assert first.rand() != second.rand()
    assert seeding.np_random(a)[0].rand(3)[1:].tolist() == first.rand(2).tolist()


def test_helpers() -> None:
    assert seeding.create_seed(5) == 5
    assert seeding.create_seed(2**64 + 5) == 5
    assert seeding.create_seed("a") == seeding.create_seed("a") != seeding.create_seed("b")
    assert seeding.hash_seed(1) == seeding.hash_seed(1) != seeding.hash_seed(2)
    assert seeding.hash_seed(1, max_bytes=4) < 2**32


def test_wrong_seeds() -> None:
    with pytest.raises(ValueError, match="a seed is an integer of 0 or more, or None, got -1"):
        seeding.np_random(-1)
    with pytest.raises(TypeError):
        seeding.np_random(1.5)  # type: ignore[arg-type]
