"""Spaces with Gym's constructors and texts, which are also Gymnasium's spaces."""

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest

import atari.classic as gym
from atari.classic import spaces
from atari.classic.spaces import from_gymnasium


@pytest.mark.parametrize(
    ("space", "text"),
    [
        (spaces.Discrete(2), "Discrete(2)"),
        (spaces.Box(-1.0, 1.0, (4,)), "Box(4,)"),
        (spaces.Box(low=0, high=255, shape=(210, 160, 3), dtype=np.uint8), "Box(210, 160, 3)"),
        (spaces.MultiBinary(5), "MultiBinary(5)"),
        (spaces.MultiDiscrete([5, 2, 2]), "MultiDiscrete([5 2 2])"),
        (spaces.Tuple((spaces.Discrete(2), spaces.Discrete(3))), "Tuple(Discrete(2), Discrete(3))"),
        (spaces.Dict({"a": spaces.Discrete(2), "b": spaces.Box(0, 1, (3,))}), "Dict(a:Discrete(2), b:Box(3,))"),
        (spaces.Dict(a=spaces.Discrete(2)), "Dict(a:Discrete(2))"),
    ],
)
def test_a_space_is_printed_as_it_was(space: gymnasium.Space[object], text: str) -> None:
    assert repr(space) == text
    space.seed(0)
    first = space.sample()
    assert space.contains(first)
    space.seed(0)
    assert str(space.sample()) == str(first)


def test_spaces_are_gymnasiums() -> None:
    """The spaces are instances of Gymnasium's, so its wrappers and vector environments accept them."""
    for name in ("Box", "Dict", "Discrete", "MultiBinary", "MultiDiscrete", "Tuple"):
        assert issubclass(getattr(spaces, name), getattr(gymnasium.spaces, name))
    batched = gymnasium.vector.utils.batch_space(spaces.Box(0, 1, (2,)), 3)
    assert batched.shape == (3, 2)
    assert spaces.Discrete(3) == gymnasium.spaces.Discrete(3)


def test_box_from_arrays() -> None:
    high = np.array([4.8, np.finfo(np.float32).max, 0.4])
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # scripts pass float64 bounds for a float32 space
        box = spaces.Box(-high, high)
    assert (box.shape, box.dtype) == ((3,), np.float32)
    np.testing.assert_array_equal(box.high, high.astype(np.float32))
    np.testing.assert_array_equal(box.low, -high.astype(np.float32))


def test_box_contains_numbers_of_any_kind() -> None:
    """Gym accepted a list, and float64 for a float32 space."""
    box = spaces.Box(-1, 1, (2,))
    assert box.contains([0, 1])
    assert box.contains(np.array([0.5, -0.5]))
    assert not box.contains([0, 1.5])
    assert not box.contains([0])
    assert not box.contains("no")
    assert not box.contains(None)


def test_spaces_of_gymnasium_become_classic() -> None:
    modern = gymnasium.spaces
    space = from_gymnasium(
        modern.Dict(
            {
                "box": modern.Box(np.array([0, 1], np.uint8), np.array([2, 3], np.uint8), dtype=np.uint8),
                "pair": modern.Tuple((modern.Discrete(2), modern.MultiBinary([2, 2]))),
                "several": modern.MultiDiscrete([2, 3]),
            }
        )
    )
    assert (
        repr(space) == "Dict(box:Box(2,), pair:Tuple(Discrete(2), MultiBinary((2, 2))), several:MultiDiscrete([2 3]))"
    )
    assert isinstance(space, spaces.Dict)
    box = space["box"]
    assert isinstance(box, spaces.Box)
    assert (box.dtype, box.low.tolist(), box.high.tolist()) == (np.uint8, [0, 1], [2, 3])


def test_a_space_that_gym_did_not_have_stays() -> None:
    for space in (gymnasium.spaces.Text(3), gymnasium.spaces.Discrete(3, start=1)):
        assert from_gymnasium(space) is space


def test_one_generator_for_all_samples() -> None:
    """As `spaces.prng` was, before spaces had generators of their own."""

    def samples(*, seed_last: bool = False) -> list[object]:
        made = [spaces.Discrete(1000), spaces.Box(0, 1, (2,)), spaces.MultiBinary(9), spaces.MultiDiscrete([99, 99])]
        if seed_last:
            made[-1].seed(4)
        return [np.asarray(space.sample()).tolist() for space in made]

    try:
        spaces.prng.seed(7)
        first, different = samples(), samples()
        spaces.prng.seed(7)
        assert samples() == first != different
        spaces.prng.seed(7)
        seeded = samples(seed_last=True)
        assert seeded[:3] == first[:3]
        assert seeded[3] != first[3]  # a space that is seeded draws its own
    finally:
        spaces.prng.np_random = None


def test_fields_and_classes_of_spaces() -> None:
    env = gym.make("Pong-v0")
    actions: Any = env.action_space
    images: Any = env.observation_space
    assert (actions.n, np.zeros(actions.n).shape, actions.contains(5), actions.contains(6)) == (6, (6,), True, False)
    assert (images.shape, images.dtype, images.low.min(), images.high.max()) == ((210, 160, 3), np.uint8, 0, 255)
    assert (type(actions), type(images)) == (spaces.Discrete, spaces.Box)
    blackjack: Any = gym.make("Blackjack-v0").observation_space
    assert (type(blackjack), [space.n for space in blackjack.spaces]) == (spaces.Tuple, [32, 11, 2])
    assert spaces.Box(0, 255, [42, 42, 1]).shape == (42, 42, 1)
    assert spaces.Box(low=0, high=255, shape=(84, 84, 1)).dtype == np.float32
    assert (spaces.MultiBinary(4).n, spaces.MultiDiscrete([3, 2]).nvec.tolist()) == (4, [3, 2])
    box = spaces.Box(0, 1, (2,))
    assert spaces.Dict({"a": box, "b": spaces.Discrete(3)}).spaces["a"] is box


def test_a_space_of_a_script() -> None:
    class Bits(gym.Space):  # type: ignore[type-arg]  # as a script of 2018 has it, without super().__init__()
        def __init__(self) -> None:
            self.low, self.dtype = np.zeros(3), np.uint8  # type: ignore[assignment, misc]

        @property
        def shape(self) -> Any:
            return self.low.shape

    assert isinstance(Bits(), spaces.Space)
    assert Bits().shape == (3,)
