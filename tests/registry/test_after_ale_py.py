"""IDs stay those of this package, and a user's own, when ale-py is imported later. Each test runs a new interpreter."""

import subprocess
import sys
from pathlib import Path

import ale_py
import pytest

from atari.cores.ale import OLDEST_ALE_PY, _numbers
from atari.registry import after_ale_py

old = pytest.mark.skipif(
    _numbers(ale_py.__version__) < _numbers(OLDEST_ALE_PY),
    reason="this ale-py has other IDs, and no core for this package",
)


def printed(program: str, folder: Path | str = ".") -> list[str]:
    start = f"import sys, warnings; sys.path.insert(0, {str(folder)!r}); warnings.simplefilter('error')\n"
    done = subprocess.run([sys.executable, "-c", start + program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.splitlines()


@old
def test_the_core_of_ale_py_imports_it_and_no_id_changes() -> None:
    program = """
import gymnasium, atari
before = dict(gymnasium.registry)
print("ale_py" in sys.modules)
atari.make("pong", core="ale").reset(seed=0)
print("ale_py" in sys.modules, {name: spec for name, spec in before.items() if gymnasium.registry[name] is not spec})
print(len(set(gymnasium.registry) - set(before)))
"""
    assert printed(program) == ["False", "True {}", "0"]


@old
def test_an_environment_that_a_user_registered_in_the_place_of_ours_stays() -> None:
    program = """
import gymnasium, atari
gymnasium.registry["ALE/Pong-v5"] = mine = gymnasium.envs.registration.EnvSpec("ALE/Pong-v5", entry_point="my:Env")
del gymnasium.registry["Pong-v4"]
import ale_py
print(gymnasium.registry["ALE/Pong-v5"] is mine, gymnasium.registry["Pong-v0"].entry_point)
print(gymnasium.registry["Pong-v4"].entry_point)
"""
    assert printed(program) == ["True atari.registry.making:make_AtariEnv", "ale_py.env:AtariEnv"]


def test_a_module_that_cannot_be_imported_leaves_the_ids(tmp_path: Path) -> None:
    (tmp_path / "ale_py.py").write_text(
        "import gymnasium\ngymnasium.register('ALE/Pong-v5', entry_point='x:y')\nraise ImportError('no library')\n"
    )
    program = """
import gymnasium, atari
before = dict(gymnasium.registry)
for _ in range(2):
    try:
        import ale_py
    except ImportError as error:
        print(error, gymnasium.registry == before)
"""
    assert printed(program, tmp_path) == ["no library True"] * 2


def test_only_ale_py_is_watched() -> None:
    finder = after_ale_py._Finder(())
    assert finder.find_spec("json") is None
    assert finder.find_spec("ale_py", []) is None  # no such module in no folder
