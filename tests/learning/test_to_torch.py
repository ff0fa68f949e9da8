"""`to_torch`: the arrays that it refuses. tests/peers plays with it."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")

import atari  # noqa: E402


@pytest.mark.parametrize(
    ("arrays", "text"),
    [
        (np.zeros(3, ">i4"), "an array of dtype >i4 cannot be converted"),
        (np.zeros(2, object), "an array of dtype object cannot be converted"),
        ({"a": [5]}, "arrays must be NumPy arrays, .* got 5"),
    ],
)
def test_other_arrays_are_refused(arrays: object, text: str) -> None:
    with pytest.raises(TypeError, match=text):
        atari.to_torch(arrays)


def test_numbers_and_nested_arrays() -> None:
    assert atari.to_torch(np.float32(1)).item() == 1
    assert atari.to_torch([{"a": np.ones(2, bool)}])[0]["a"].tolist() == [True, True]
