"""`python -m atari.classic` runs a script as `python` would, except that `gym` is this package."""

import multiprocessing
import subprocess
import sys
from pathlib import Path

import pytest


def run(*arguments: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "atari.classic", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, timeout=60)


def script(folder: Path, text: str) -> str:
    (folder / "script.py").write_text(text)
    return "script.py"


def test_a_script_is_the_program(tmp_path: Path) -> None:
    (tmp_path / "beside.py").write_text("here = True")
    name = script(tmp_path, "import sys, beside\nprint(sys.argv, __name__, beside.here)\nsys.exit(3)")
    result = run(name, "a", "--b", folder=tmp_path)
    assert result.stdout == "['script.py', 'a', '--b'] __main__ True\n"
    assert result.returncode == 3


IMPORTS = """\
from gym import spaces, wrappers, error, logger, utils, envs
import gym.wrappers, gym.spaces, gym.envs
from gym.wrappers import Monitor, TimeLimit, AtariPreprocessing, FrameStack
from gym.wrappers.monitor import Monitor
from gym.wrappers.time_limit import TimeLimit
from gym.envs.registration import register, registry, make, spec, EnvSpec
from gym.utils import seeding, EzPickle, colorize
from gym.utils.play import play
from gym.spaces import Box, Dict, Discrete, MultiBinary, MultiDiscrete, Space, Tuple
from gym.spaces.box import Box
from gym.spaces import prng
from gym.envs.toy_text import discrete
from gym.envs.toy_text.discrete import DiscreteEnv, categorical_sample
from gym.core import Env, Wrapper
from gym import Env, GoalEnv, Wrapper, ObservationWrapper, RewardWrapper, ActionWrapper
from gym.wrappers import RecordVideo, LazyFrames, FlattenDictWrapper
from gym.wrappers.frame_stack import LazyFrames
from gym.wrappers.normalize import RunningMeanStd
from gym.wrappers.monitoring.video_recorder import VideoRecorder
from gym.envs.atari import AtariEnv
from gym.envs.atari.atari_env import AtariEnv
from gym.envs.classic_control import CartPoleEnv, rendering
from gym.envs.classic_control.cartpole import CartPoleEnv
from gym.envs.classic_control.rendering import SimpleImageViewer
from gym.envs.toy_text import FrozenLakeEnv, discrete
from gym.envs.toy_text.frozen_lake import FrozenLakeEnv, generate_random_map
import gym.envs.toy_text.frozen_lake, gym.envs.toy_text.taxi, gym.envs.toy_text.cliffwalking
from gym.envs.registration import load
from gym.vector import SyncVectorEnv, AsyncVectorEnv, VectorEnv, make
import gym.vector, gym.version, gym.configuration, gym.core
import gym; gym.undo_logger_setup(); gym.configuration.undo_logger_setup(); gym.logger.info("%d", 3)
from gym.spaces.discrete import Discrete
from gym.error import Error, UnregisteredEnv, DependencyNotInstalled
import gym; gym.logger.set_level(40); gym.logger.setLevel(gym.logger.INFO)
import gym; gym.envs.registry.all(); gym.envs.registry.env_specs["CartPole-v0"]; gym.envs.registration.registry
import gym; assert gym.__version__ < "0.22"
import gym, atari.classic; assert gym is atari.classic and gym.wrappers.Monitor is atari.classic.wrappers.Monitor
"""


def test_gym_means_this_package(tmp_path: Path) -> None:
    result = run(script(tmp_path, IMPORTS + "print('all')"), folder=tmp_path)
    assert (result.returncode, result.stdout) == (0, "all\n"), result.stderr


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
    envs = gym.vector.AsyncVectorEnv([lambda: gym.make("CartPole-v0")] * 2, context={method!r})
    print(envs.reset().shape)
    envs.close()
"""
    result = run(script(tmp_path, program), folder=tmp_path)
    assert result.stdout == "([-0.0446, 0.0465, 0.0133, -0.021], 'atari.classic')\n(2, 4)\n", result.stderr


def test_names_that_numpy_dropped(tmp_path: Path) -> None:
    """NumPy gets the removed names only in scripts that the runner runs."""
    program = """\
import numpy as np
print(np.array([1.7]).astype(np.int), np.zeros(1, np.float).dtype, np.Inf, np.product([2, 3]), np.bool8(1), np.float_)
assert issubclass(np.integer, np.generic) and np.object is object and bool(np.bool(1))
"""
    result = run(script(tmp_path, program), folder=tmp_path)
    assert result.stdout == "[1] float64 inf 6 True <class 'numpy.float64'>\n", result.stderr
    check = "import numpy as np, atari.classic\nassert 'int' not in vars(np) and 'float' not in vars(np)"
    assert subprocess.run([sys.executable, "-c", check], timeout=60).returncode == 0


def test_a_traceback_is_the_scripts(tmp_path: Path) -> None:
    name = script(tmp_path, "def f():\n    raise ValueError('mine')\n\nf()")
    result = run(name, folder=tmp_path)
    assert result.returncode == 1
    lines = [line for line in result.stderr.splitlines() if set(line.strip()) - set("^~")]
    assert lines[0] == "Traceback (most recent call last):"
    assert [line.split(", ", 1)[1] for line in lines if line.startswith("  File")] == [
        "line 4, in <module>",
        "line 2, in f",
    ]
    assert lines[-1] == "ValueError: mine"


def test_a_syntax_error_is_the_scripts(tmp_path: Path) -> None:
    result = run(script(tmp_path, "print('a'"), folder=tmp_path)
    assert result.returncode == 1
    assert result.stderr.lstrip().startswith('File "script.py", line 1\n')
    assert "atari" not in result.stderr


def test_a_mistake_reads_as_a_sentence(tmp_path: Path) -> None:
    result = run(script(tmp_path, "import gym\ngym.make('CartPoel-v0')"), folder=tmp_path)
    assert result.stderr.splitlines()[-1] == (
        "gymnasium.error.UnregisteredEnv: there is no environment 'CartPoel-v0'; did you mean 'CartPole-v0'?"
    )


def test_interrupting_is_not_failing(tmp_path: Path) -> None:
    result = run(script(tmp_path, "raise KeyboardInterrupt"), folder=tmp_path)
    assert result.returncode == 130
    assert result.stderr.endswith("KeyboardInterrupt\n")
    assert "runpy" not in result.stderr


def test_wrong_command_lines(tmp_path: Path) -> None:
    missing = run("nothing.py", folder=tmp_path)
    assert (missing.returncode, missing.stdout) == (2, "")
    assert missing.stderr.startswith("atari.classic: there is no script 'nothing.py'; usage: ")
    assert run(folder=tmp_path).returncode == 2
    helped = run("--help", folder=tmp_path)
    assert helped.returncode == 0
    assert helped.stdout.startswith("usage: python -m atari.classic script.py")


def test_importing_the_package_does_not_take_the_name() -> None:
    """Only the runner replaces `gym`. Otherwise an installed Gym is imported as before."""
    program = "import sys, atari.classic; sys.exit('gym' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], timeout=60).returncode == 0
