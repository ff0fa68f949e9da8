"""Imports, names of Gym's modules, and removed names of NumPy."""

import numpy as np
import pytest
from old_scripts import marks, rewritten, run


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("import gym", "import gymnasium as gym"),
        ("import gym, sys", "import gymnasium as gym, sys"),
        ("import gym as g", "import gymnasium as g"),
        ("import atari.classic as gym", "import gymnasium as gym"),
        ("import gym.spaces", "import gymnasium as gym, gymnasium.spaces"),
        ("import gym.wrappers as w", "import gymnasium.wrappers as w"),
        ("from gym import spaces, wrappers", "from gymnasium import spaces, wrappers"),
        ("from gym.utils import seeding", "from gymnasium.utils import seeding"),
        ("from gym.spaces.box import Box", "from gymnasium.spaces.box import Box"),
        ("from gym.envs.registration import register", "from gymnasium.envs.registration import register"),
        (
            "from gym.wrappers.monitor import Monitor",
            "from gymnasium.wrappers import RecordEpisodeStatistics, RecordVideo",
        ),
        (
            "from gym.wrappers.frame_stack import FrameStack as F",
            "from gymnasium.wrappers import FrameStackObservation as F",
        ),
        ("from gym import spaces as s  # all of them", "from gymnasium import spaces as s  # all of them"),
    ],
)
def test_imports(old: str, new: str) -> None:
    assert rewritten(old + "\n") == new + "\n"
    run(old + "\n")


def test_a_script_for_gymnasium_stays() -> None:
    text = "import gymnasium as gym\nenv = gym.make('CartPole-v1')\nobs = env.reset()\nresult = env.step(0)\n"
    assert rewritten(text) == text


def test_names_of_modules() -> None:
    names = run("""\
import gym
from gym import logger
gym.logger.set_level(40)
logger.setLevel(logger.INFO)
level = logger.min_level
gym.logger.set_level(gym.logger.WARN)
gym.undo_logger_setup()
ids = [spec.id for spec in gym.envs.registry.all()]
one = gym.envs.registry.env_specs["CartPole-v1"].id
two = gym.envs.registration.registry.spec("CartPole-v1").id
box = isinstance(gym.make(two).observation_space, gym.spaces.Box)
""")
    assert names["level"] == 20
    assert "CartPole-v1" in names["ids"]
    assert (names["one"], names["two"], names["box"]) == ("CartPole-v1", "CartPole-v1", True)


@pytest.mark.parametrize(
    ("line", "mark"),
    [
        ("from gym.envs.classic_control import rendering", "its windows are gone"),
        ("gym.spaces.prng.seed(0)", "Gymnasium has no spaces.prng.seed: env.action_space.seed(0) seeds a space"),
        ("gym.benchmark_spec('Atari40M')", "Gymnasium has no benchmark_spec"),
        ("import gym.scoreboard.scoring", "the site for results is closed"),
        ("from baselines.common.vec_env import SubprocVecEnv", "Baselines never supported Gymnasium"),
        ("from gym.wrappers.monitoring.video_recorder import VideoRecorder", "VideoRecorder"),
    ],
)
def test_marks(line: str, mark: str) -> None:
    assert mark in marks(f"import gym\n{line}\n")[0]


def test_modules_that_need_other_packages_are_no_error() -> None:
    text = "import gym\nfrom gym.envs.box2d import LunarLander\nfrom gym.wrappers import NumpyToTorch\n"
    assert "from gymnasium.envs.box2d import LunarLander" in rewritten(text)


def test_numpy() -> None:
    names = run("""\
import numpy as np
import numpy
a = np.zeros(2, dtype=np.float), np.array([1.7]).astype(np.int), numpy.bool(1), np.object
b = np.Inf, np.NINF, np.NaN, np.product([2, 3]), np.alltrue([True]), np.float_(2), np.bool8(1)
c = np.array(a[0], copy=False)
d = np.array([1, 2], dtype=np.uint8, copy=False).dtype
e = np.array([1, 2]).sum()
""")
    zeros, cast, flag, kind = names["a"]
    assert (zeros.dtype, cast.tolist(), flag, kind) == (float, [1], True, object)
    assert names["b"][:2] == (np.inf, -np.inf)
    assert names["b"][3:] == (6, True, 2.0, True)
    assert names["c"] is zeros
    assert names["d"] == np.uint8


def test_numpy_alone_is_rewritten_in_any_script() -> None:
    assert rewritten("import numpy as n\nx = n.float(1)\n") == "import numpy as n\nx = float(1)\n"
    assert rewritten("class np: float = 3\nx = np.float\n") == "class np: float = 3\nx = np.float\n"
    text = "import numpy as np\nnp.float = float\n"
    assert rewritten(text) == text
    assert marks("import numpy as np\nx = np.nothing_known\n") == [f"NumPy {np.__version__} has no nothing_known"]


def test_lazy_frames() -> None:
    names = run(
        "import gym\nimport numpy as np\nclass LazyFrames(object):\n    def __array__(self, dtype=None):\n"
        "        return np.zeros(3, dtype)\nx = np.array(LazyFrames())\n"
    )
    assert names["x"].shape == (3,)


def test_pickle() -> None:
    names = run(
        "import gym\nimport cPickle as pickle\nimport cPickle\nfrom cPickle import dumps, loads\nx = pickle, cPickle\n"
    )
    assert names["x"][0] is names["x"][1]
    assert names["loads"](names["dumps"](3)) == 3
    text = "try:\n    import cPickle as pickle\nexcept ImportError:\n    import pickle\n"
    assert rewritten(text) == text


def test_names_of_python_2_in_a_script_for_python_3() -> None:
    assert list(run("import gym\nr = xrange(3)\n")["r"]) == [0, 1, 2]
    assert marks("import gym\n{}.iteritems()\n") == ["Python 3 has no iteritems()"]
    text = "import gym\nfrom six.moves import xrange\nx = xrange(3)\n"
    assert "x = xrange(3)" in rewritten(text)
