"""IDs in processes that have not imported the package: `atari:` before an ID makes Gymnasium import it there."""

import subprocess
import sys
from pathlib import Path

import pytest

SPAWN = """
import sys
import gymnasium
from gymnasium.vector import AsyncVectorEnv
{imports}

def make():
    env = gymnasium.make({env_id!r})
    assert type(env.unwrapped).__module__ == "atari.env.env"
    return env

if __name__ == "__main__":
    envs = AsyncVectorEnv([make], context="spawn")
    observations, _ = envs.reset(seed=0)
    print(observations.shape, "atari" in sys.modules)
    envs.close()
"""

KIND = """
import gymnasium

def kind():
    return type(gymnasium.make("atari:ALE/Pong-ram-v5").unwrapped).__module__
"""

POOL = """
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

if __name__ == "__main__":
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        print(pool.submit(kind).result())
"""

JOBLIB = """
import joblib

if __name__ == "__main__":
    print(*joblib.Parallel(2)([joblib.delayed(kind)()]))
"""


def run(program: str, tmp_path: Path) -> str:
    script = tmp_path / "script.py"
    script.write_text(program)
    result = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=300, check=False)
    assert result.returncode == 0, result.stderr
    return result.stdout


@pytest.mark.parametrize(("imports", "env_id"), [("", "atari:ALE/Pong-v5"), ("import atari", "ALE/Pong-v5")])
def test_a_spawned_worker_has_the_ids(imports: str, env_id: str, tmp_path: Path) -> None:
    """It repeats the imports of the script, or imports the package by the ID. The main process learns the spaces."""
    assert run(SPAWN.format(imports=imports, env_id=env_id), tmp_path) == "(1, 210, 160, 3) True\n"


def test_a_pool_of_processes(tmp_path: Path) -> None:
    assert run(KIND + POOL, tmp_path) == "atari.env.env\n"


def test_joblib(tmp_path: Path) -> None:
    assert run(KIND + JOBLIB, tmp_path) == "atari.env.env\n"
