"""NumPy in a script that the runner runs: removed names, and the habits of `np.array`."""

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import atari.classic as gym
from atari.classic import old_numpy
from atari.classic.wrappers import FrameStack


@pytest.fixture
def old() -> Iterator[Any]:
    """NumPy with the removed names, until the test ends."""
    before = dict(vars(np))
    with warnings.catch_warnings():
        old_numpy.restore()
        yield np
    for name in set(vars(np)) - set(before):
        delattr(np, name)
    vars(np).update(before)


def test_every_name_is_there(old: Any) -> None:
    assert [name for name in old_numpy._NAMES if not hasattr(old, name)] == []


MEANINGS = {
    "np.cast['uint8']([1.7, 3])": "[1 3]",
    "np.asfarray([1, 2]).dtype": "float64",
    "np.asscalar(np.array([7]))": "7",
    "np.mat([[1, 2]]).T.shape": "(2, 1)",
    "np.trapz([1, 3])": "2.0",
    "np.in1d([[1, 2], [3, 4]], [2, 3])": "[False  True  True False]",
    "np.round_(2.567, 1)": "2.6",
    "[kind().itemsize for kind in np.sctypes['int']]": "[1, 2, 4, 8]",
    "np.msort(np.array([[2, 1], [1, 2]])).tolist()": "[[1, 1], [2, 2]]",
    "(np.issubclass_(int, object), np.string_, np.NINF)": "(True, <class 'numpy.bytes_'>, -inf)",
    "np.array([1, 2], copy=False)": "[1 2]",
    "np.array((0.5, 1), np.float32, copy=False).dtype": "float32",
    "np.array(np.zeros(2), copy=False, ndmin=2).shape": "(1, 2)",
}


@pytest.mark.parametrize("expression", MEANINGS)
@pytest.mark.filterwarnings("ignore")  # of NumPy 1
def test_meanings(expression: str, old: Any) -> None:
    assert str(eval(expression, {"np": old})) == MEANINGS[expression]


def test_copy_false_does_not_copy_an_array(old: Any) -> None:
    a = old.zeros(3)
    assert (old.array(a, copy=False) is a, old.array(a) is a, old.array(a, copy=True) is a) == (True, False, False)


def test_rows_of_unequal_length_are_objects(old: Any) -> None:
    with pytest.warns(UserWarning, match=r"np.array of rows of unequal length: the result is an array of objects"):
        assert old.array([[1], [2, 3]]).dtype == object
    with pytest.raises(ValueError, match="inhomogeneous"):
        old.array([[1], [2, 3]], dtype=float)


class Lazy:
    def __array__(self, dtype: Any = None) -> Any:
        return np.zeros((2, 3)) if dtype is None else np.zeros((2, 3), dtype)


@pytest.mark.filterwarnings("error")
def test_a_stack_of_lazy_frames(old: Any) -> None:
    """Lazy stacks of this package and of scripts, whose `__array__` has no `copy`, convert without a warning."""
    stacked = FrameStack(gym.make("Pong-ram-v0"), 4).reset()
    assert old.array(stacked, copy=False).shape == (4, 128)
    assert old.array(Lazy()).shape == old.array(Lazy(), copy=False).shape == (2, 3)


def test_other_programs_keep_their_numpy() -> None:
    assert np.array.__module__ == "numpy"
    if np.lib.NumpyVersion(np.__version__) >= "2.0.0":
        assert not hasattr(np, "cast")
