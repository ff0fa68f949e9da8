"""NumPy in a script that the runner runs: removed names, and the habits of `np.array`."""

import subprocess
import sys
from pathlib import Path

import numpy as np

from atari.classic import old_numpy


def lines(folder: Path, program: str) -> list[str]:
    (folder / "script.py").write_text(f"import numpy as np\n{program}")
    command = [sys.executable, "-m", "atari.classic", str(folder / "script.py")]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert result.returncode == 0, result.stderr
    return [*result.stdout.splitlines(), *result.stderr.splitlines()]


def test_every_name_is_there(tmp_path: Path) -> None:
    names = sorted(old_numpy._NAMES)
    assert lines(tmp_path, f"print([name for name in {names!r} if not hasattr(np, name)])") == ["[]"]


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


def test_meanings(tmp_path: Path) -> None:
    program = "\n".join(f"print({expression})" for expression in MEANINGS)
    printed = lines(tmp_path, f"import warnings\nwarnings.simplefilter('ignore')\n{program}")  # of NumPy 1
    assert printed == list(MEANINGS.values())


def test_copy_false_does_not_copy_an_array(tmp_path: Path) -> None:
    program = "a = np.zeros(3)\nprint(np.array(a, copy=False) is a, np.array(a) is a, np.array(a, copy=True) is a)"
    assert lines(tmp_path, program) == ["True False False"]


def test_rows_of_unequal_length_are_objects(tmp_path: Path) -> None:
    first, *rest = lines(tmp_path, "print(np.array([[1], [2, 3]]).dtype)")
    assert first == "object"
    assert "np.array of rows of unequal length: the result is an array of objects" in rest[0]
    other = lines(tmp_path, "try: np.array([[1], [2, 3]], dtype=float)\nexcept ValueError: print('refused')")
    assert other == ["refused"]


def test_a_stack_of_lazy_frames(tmp_path: Path) -> None:
    """Lazy stacks of this package and of scripts, whose `__array__` has no `copy`, convert without a warning."""
    program = """\
import gym
from gym.wrappers import FrameStack

class Lazy(object):
    def __array__(self, dtype=None):
        return np.zeros((2, 3)) if dtype is None else np.zeros((2, 3), dtype)

env = FrameStack(gym.make("Pong-ram-v0"), 4)
print(np.array(env.reset(), copy=False).shape, np.array(Lazy()).shape, np.array(Lazy(), copy=False).shape)
"""
    assert lines(tmp_path, program) == ["(4, 128) (2, 3) (2, 3)"]


def test_other_programs_keep_their_numpy() -> None:
    assert np.array.__module__ == "numpy"
    if np.lib.NumpyVersion(np.__version__) >= "2.0.0":
        assert not hasattr(np, "cast")
