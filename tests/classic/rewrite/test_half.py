"""Scripts that import Gymnasium, but have lines of Gym's time; and scripts for Gymnasium, which stay."""

import pytest
from old_scripts import marks, rewritten, run

LAKE = """\
import gymnasium as gym
import numpy as np
env = gym.make('FrozenLake-v0')
env.seed(0)
Q = np.zeros([env.observation_space.n, env.action_space.n], np.float)
for i in range(3):
    s = env.reset()
    d = False
    while not d:
        a = np.argmax(Q[s, :])
        s1, r, d, _ = env.step(a)
        Q[s, a] += r + np.max(Q[s1, :])
        s = s1
"""


def test_an_import_alone_was_changed() -> None:
    names = run(LAKE)
    assert names["env"].spec.id == "FrozenLake-v1"
    assert names["s"] in range(16)
    assert rewritten(LAKE) == rewritten(LAKE.replace("gymnasium as gym", "gym"))


def test_a_class_and_its_callers() -> None:
    names = run("""\
import gymnasium
from gymnasium.wrappers import FrameStack
class Noops(gymnasium.Wrapper):
    def reset(self):
        self.env.reset()
        obs, _, done, _ = self.env.step(0)
        if done:
            obs = self.env.reset()
        return obs
class Line(gymnasium.Env):
    metadata = {"render.modes": []}
    action_space = observation_space = gymnasium.spaces.Discrete(3)
    def reset(self):
        return 0
    def step(self, action):
        return action, 1.0, True, {}
env = FrameStack(Noops(gymnasium.make("Breakout-v4")), 4)
obs = env.reset()
lives = env.step(0)[4]["ale.lives"]
def play(env):
    state = env.reset()
    state, reward, done, info = env.step(2)
    return reward, done
first = env.reset(seed=3)[0]
result = play(Line())
image = gymnasium.make("CartPole-v1")
image.reset()
frame = image.render(mode="rgb_array")
one = image.spec.timestep_limit
shape = obs.shape
""")
    assert (names["shape"], names["first"].shape, names["lives"]) == ((4, 210, 160, 3), (4, 210, 160, 3), 5)
    assert (names["result"], names["frame"].shape, names["one"]) == ((1.0, True), (400, 600, 3), 500)


def test_a_wrapper_whose_method_has_its_name_of_2016() -> None:
    names = run("""\
import gymnasium as gym
class Half(gym.ObservationWrapper):
    def _observation(self, observation):
        return observation / 2
class Twice(gym.RewardWrapper):
    def _reward(self, reward):
        return 2 * reward
env = Twice(Half(gym.make("CartPole-v1")))
state, info = env.reset(seed=0)
reward = env.step(0)[1]
""")
    assert abs(names["state"]).max() < 0.025
    assert names["reward"] == 2


def test_uses_that_show_an_observation() -> None:
    names = run("""\
import gymnasium as gym
import numpy as np
env = gym.make("CartPole-v1")
first = np.reshape(env.reset(), [1, 4])
class Agent:
    def __init__(self, env):
        self.env = env
        self.state = env.reset()
    def play(self):
        self.state, reward, done, _ = self.env.step(0)
        return self.state[0]
place = Agent(env).play()
lake = gym.make("FrozenLake-v0")
n = lake.nS, len(lake.P), gym.make("Taxi-v2").env.nA
""")
    assert names["first"].shape == (1, 4)
    assert abs(names["place"]) < 0.1
    assert names["n"] == (16, 16, 6)


MODERN = [
    "obs, info = env.reset(seed=0)\nobs, reward, terminated, truncated, info = env.step(0)\ndone = terminated or truncated",
    "state = env.reset()[0]\nresult = env.step(0)\nended = result[2] or result[3]\nstate, *rest = env.step(1)",
    "state = env.reset()\nstate = state[0]\nstate, reward, over, cut, info = env.step(0)\nprint(state[0])",
    "pair = env.reset()\nobs, info = pair\nprint(env.reset(), env.step(0))",
    "state = env.reset()\nif isinstance(state, tuple):\n    state = state[0]\nstate, r, d, t, i = env.step(0)\nprint(state.shape)",
    "def start(env):\n    return env.reset()\nobs, info = start(env)\ndef f(pair):\n    return pair[0]\nf(env.reset())",
    "view = gym.make('CartPole-v1', render_mode='rgb_array')\nview.reset()\nif True:\n    frame = view.render()\n    view.render()",
    "def make(**options):\n    env = gym.make('FrozenLake-v1', **options)\n    env.reset()\n    env.render()\nmake(render_mode='ansi')",
    "class W(gym.Wrapper):\n    def reset(self, **kwargs):\n        obs = self.env.reset(**kwargs)\n        return obs\n"
    "    def step(self, action):\n        return self.env.step(action)\n    def _reward(self):\n        return 1\nW(env).reset()",
    "class E(gym.Env):\n    def __init__(self):\n        self.np_random = np.random.RandomState(0)\n"
    "    def reset(self, seed=None, options=None):\n        self.n = self.np_random.randint(3)\n        return self.n, {}",
    "class Plain:\n    def reset(self):\n        return 0\n    def step(self, a):\n        return 0, 0.0, True, {}\n"
    "env = Plain()\ns = env.reset()\ns, r, d, _ = env.step(0)\nprint(s + 1)",
    "envs = gym.vector.SyncVectorEnv([lambda: gym.make('CartPole-v1')])\nobs, infos = envs.reset()\n"
    "obs, rewards, ended, cut, infos = envs.step([0])\nenvs.close()",
    "limit = env._max_episode_steps\nids = list(gym.envs.registry.keys())\ngym.logger.warn('x')\nenv.unwrapped.state",
    "from gymnasium.wrappers.vector import RecordEpisodeStatistics\nname = 'other'\n",
]


@pytest.mark.parametrize("lines", MODERN)
def test_right_code_stays(lines: str) -> None:
    text = f"import gymnasium as gym\nimport numpy as np\nenv = gym.make('CartPole-v1')\n{lines}\n"
    assert rewritten(text) == text
    run(text)


@pytest.mark.parametrize(
    "lines",
    [
        "import gymnasium as gym\nfrom stable_baselines3 import PPO\nenv = PPO('MlpPolicy', 'CartPole-v1').get_env()",
        "import gymnasium as gym\nfrom mine import make_env\nenv = make_env()",
        "try:\n    import gymnasium as gym\nexcept ImportError:\n    import gym\nenv = gym.make('CartPole-v1')",
        "import gymnasium\nimport atari.classic as gym\nenv = gym.make('CartPole-v1')",
    ],
)
def test_what_is_uncertain_stays(lines: str) -> None:
    text = f"{lines}\nobs = env.reset()\nobs, reward, done, info = env.step([0])\nprint(obs.shape)\n"
    assert rewritten(text) == text


def test_games_are_imported_unless_ale_py_is() -> None:
    text = "import gymnasium as gym\nenv = gym.make('Pong-v3')\n"
    assert rewritten(text).startswith("import gymnasium as gym\nimport atari  # registers the Atari games\n")
    assert "import atari" not in rewritten("import ale_py\n" + text)
    assert marks("import gymnasium as gym\nx = gym.wrappers.Monitor(gym.make('CartPole-v1'), 'a')\n") == [
        "RecordVideo needs MoviePy: pip install moviepy"
    ]


VECTOR = """\
import gymnasium as gym
envs = gym.vector.SyncVectorEnv([lambda: gym.make("CartPole-v1")])
envs.reset(seed=0)
ends = 0
for _ in range(100):
    obs, reward, done, info = envs.step([1])
    assert obs.shape == (1, 4)
    assert not done or abs(obs[0, 2]) < 0.1
    ends += int(done[0])
"""


def test_vectors_of_four_values_reset_in_the_step_that_ends_an_episode() -> None:
    assert run(VECTOR)["ends"] > 5
    assert "autoreset_mode=gym.vector.AutoresetMode.SAME_STEP" in rewritten(VECTOR)
    current = VECTOR.replace("done, info", "done, truncated, info")
    assert rewritten(current) == current
