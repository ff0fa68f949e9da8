"""`python -m atari.classic` runs a script as `python` would, except that `gym` is this package."""

import multiprocessing
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from atari.base import script
from atari.classic.__main__ import main


def run(folder: Path, text: str, *arguments: str) -> "subprocess.CompletedProcess[str]":
    (folder / "script.py").write_text(text)
    command = [sys.executable, "-m", "atari.classic", "script.py", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, timeout=60)


@pytest.fixture
def run_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[[str], tuple[int, str]]:
    """Runs a script as the runner does, but without a change of modules: its exit code and standard error."""

    def run_script_here(text: str) -> tuple[int, str]:
        (tmp_path / "script.py").write_text(text)
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "path", [*sys.path])
        monkeypatch.setattr(sys, "argv", [*sys.argv])
        monkeypatch.setattr(sys, "excepthook", sys.__excepthook__)
        monkeypatch.setitem(sys.modules, "__main__", sys.modules["__main__"])
        code = script.run_script("atari.classic", "", ["script.py"], lambda: None)
        return code, capsys.readouterr().err

    return run_script_here


def test_python_2_gets_a_hint(tmp_path: Path) -> None:
    ran = run(tmp_path, "import gym\nprint 3\n")
    assert ran.returncode == 1
    assert "SyntaxError" in ran.stderr
    assert "this is Python 2; `2to3 -w FILE`" in ran.stderr
    assert "Python 2" not in run(tmp_path, "import gym\nx = (\n").stderr


IMPORTS = """\
from gym import Env, GoalEnv, spaces, wrappers, error, logger, utils, envs
from gym.wrappers.monitor import Monitor
from gym.wrappers.monitoring.video_recorder import VideoRecorder
from gym.utils.play import play
from gym.spaces import prng
from gym.envs.classic_control.rendering import SimpleImageViewer
import gym.envs.toy_text.frozen_lake, gym.vector, gym.version, gym.configuration, gym.core
import gym; gym.undo_logger_setup(); gym.configuration.undo_logger_setup(); gym.logger.info("%d", 3)
import gym; gym.logger.set_level(40); gym.logger.setLevel(gym.logger.INFO)
import gym; gym.envs.registry.all(); gym.envs.registry.env_specs["CartPole-v0"]; gym.envs.registration.registry
import gym, atari.classic; assert gym is atari.classic and gym.wrappers.Monitor is atari.classic.wrappers.Monitor
import gym.wrappers.clip_action, gym.vector.utils.spaces as spaces; assert spaces.batch_space and gym.error.Unregistered
from gym.utils import closer, colorize; import gym.utils.colorize as again; assert closer.Closer and colorize is again
assert gym.wrappers.clip_action.ClipAction is gym.wrappers.ClipAction
try: import gym.wrappers.nothing
except ImportError as error: assert str(error) == "No module named 'gym.wrappers.nothing'"
else: raise AssertionError
"""
"""Modules by their names of Gym; `tests/interfaces/test_gym.py` has all names."""


def test_a_script_is_the_program_and_gym_means_this_package(tmp_path: Path) -> None:
    (tmp_path / "beside.py").write_text("here = True")
    program = IMPORTS + "import sys, beside\nprint(sys.argv, __name__, beside.here)\nsys.exit(3)"
    result = run(tmp_path, program, "a", "--b")
    assert result.stdout == "['script.py', 'a', '--b'] __main__ True\n", result.stderr
    assert result.returncode == 3


@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
def test_processes_of_a_script_have_gym_too(tmp_path: Path, method: str) -> None:
    if method not in multiprocessing.get_all_start_methods():
        return
    program = f"""\
import multiprocessing as mp
import numpy as np
import gym
from gym.wrappers import Monitor

def work(queue):
    env = gym.make("CartPole-v0")
    env.seed(0)
    queue.put((env.reset().astype(np.float).round(4).tolist(), gym.__name__))

if __name__ == "__main__":
    mp.set_start_method({method!r})
    queue = mp.Queue()
    process = mp.Process(target=work, args=(queue,))
    process.start()
    print(queue.get())
    process.join()
    envs = gym.vector.AsyncVectorEnv([lambda: gym.make("CartPole-v0")], context={method!r})
    print(envs.reset().shape)
    envs.close()
"""
    result = run(tmp_path, program)
    assert result.stdout == "([-0.0446, 0.0465, 0.0133, -0.021], 'atari.classic')\n(1, 4)\n", result.stderr


def test_names_that_numpy_dropped(tmp_path: Path) -> None:
    program = """\
import numpy as np
print(np.array([1.7]).astype(np.int), np.zeros(1, np.float).dtype, np.Inf, np.product([2, 3]), np.bool8(1), np.float_)
assert issubclass(np.integer, np.generic) and np.object is object and bool(np.bool(1))
"""
    result = run(tmp_path, program)
    assert result.stdout == "[1] float64 inf 6 True <class 'numpy.float64'>\n", result.stderr


def test_a_traceback_is_the_scripts(run_here: Callable[[str], tuple[int, str]]) -> None:
    code, printed = run_here("def f():\n    raise ValueError('mine')\n\nf()")
    lines = [line for line in printed.splitlines() if set(line.strip()) - set("^~")]
    assert (code, lines[0], lines[-1]) == (1, "Traceback (most recent call last):", "ValueError: mine")
    places = [line.split(", ", 1)[1] for line in lines if line.startswith("  File")]
    assert places == ["line 4, in <module>", "line 2, in f"]


def test_errors_of_a_script(run_here: Callable[[str], tuple[int, str]]) -> None:
    code, printed = run_here("print('a'")
    assert (code, "atari" in printed, printed.lstrip().startswith('File "script.py", line 1\n')) == (1, False, True)
    code, printed = run_here("raise KeyboardInterrupt")
    assert (code, "runpy" in printed, printed.endswith("KeyboardInterrupt\n")) == (130, False, True)
    _, printed = run_here("import atari.classic as gym\ngym.make('CartPoel-v0')")
    assert printed.splitlines()[-1] == (
        "gymnasium.error.UnregisteredEnv: there is no environment 'CartPoel-v0'; did you mean 'CartPole-v0'?"
    )


@pytest.mark.parametrize(
    ("arguments", "code", "printed", "error"),
    [
        (["nothing.py"], 2, "", "atari.classic: there is no script 'nothing.py'; usage: "),
        ([], 2, "usage: python -m atari.classic script.py", ""),
        (["--help"], 0, "usage: python -m atari.classic script.py", ""),
    ],
)
def test_command_lines_without_a_script(
    arguments: list[str], code: int, printed: str, error: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == code
    out, err = capsys.readouterr()
    assert out.startswith(printed)
    assert err.startswith(error)
