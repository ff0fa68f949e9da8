"""`import atari` imports nothing of `atari.learning`, which imports neither PyTorch nor Matplotlib; names of 0.2."""

import pytest
from own_process import run_program

from atari._renamed import RENAMED

OLD = [name.rpartition(".")[2] for name in RENAMED if name.startswith("atari.learning.")]


def test_what_is_imported():
    heavy = "{'torch', 'matplotlib', 'stable_baselines3', 'onnxruntime', 'av', 'pygame'}"
    printed = run_program(
        f"""
        import sys
        import atari
        print(sum(name.startswith("atari.learning") for name in sys.modules))
        import atari.learning
        print({heavy} & set(sys.modules))
        """
    )
    assert printed == "0\nset()\n"


@pytest.mark.parametrize("name", OLD)
def test_an_old_name_says_where_it_is_now(name):
    with pytest.raises(ImportError, match=rf"atari\.learning\.{name} is now "):
        exec(f"from atari.learning import {name}", {})
