"""Environments and wrappers of a script's own."""

import gymnasium
import numpy as np
from gymnasium.utils.env_checker import check_env
from old_scripts import marks, run

WALK = """\
import gym
import numpy as np
from gym import spaces
from gym.utils import seeding


class Walk(gym.Env):
    metadata = {"render.modes": ["human"], "video.frames_per_second": 30}

    def __init__(self):
        self.action_space = spaces.Discrete(2)
        self.observation_space = spaces.Box(-9, 9, (1,), dtype=np.float32)
        self.seed()

    def seed(self, seed=None):
        self.np_random, seed = seeding.np_random(seed)
        return [seed]

    def reset(self):
        '''The start.'''
        self.place = self.np_random.randint(-3, 4) + 0.0 * self.np_random.rand()
        return np.array([self.place], np.float32)

    def step(self, action):
        self.place += 1 if action else -1
        done = abs(self.place) >= 5
        return np.array([self.place], np.float32), float(done), done, {}
"""


def test_an_environment() -> None:
    names = run(WALK)
    env = names["Walk"]()
    check_env(env, skip_render_check=True)
    assert env.reset(seed=3)[0] == env.reset(seed=3)[0]
    assert env.metadata == {"render_modes": ["human"], "render_fps": 30}


def test_an_environment_that_is_registered() -> None:
    old = (
        WALK
        + """
gym.envs.register(id='Walk-v77', entry_point=Walk, timestep_limit=3)
env = gym.make('Walk-v77')
env.seed(1)
first = env.reset()
n, done = 0, False
while not done:
    obs, reward, done, info = env.step(n % 2)
    n += 1
"""
    )
    names = run(old)
    assert (names["n"], names["truncated"]) == (3, True)
    del gymnasium.registry["Walk-v77"]


def test_names_of_methods_until_2017() -> None:
    names = run("""\
import gym

class Skip(gym.Wrapper):
    def __init__(self, env, repeat):
        super(Skip, self).__init__(env)
        self.repeat = repeat

    def _step(self, action):
        total, done, n = 0, False, 0
        while n < self.repeat and not done:
            obs, reward, done, info = self.env.step(action)
            total += reward
            n += 1
        return obs, total, done, info

    def _reset(self):
        return self.env.reset()

class Half(gym.ObservationWrapper):
    def _observation(self, observation):
        return observation / 2

class Sign(gym.RewardWrapper):
    def _reward(self, reward):
        return -reward

env = Sign(Half(Skip(gym.make("CartPole-v1"), 3)))
env.seed(0)
first = env.reset()
obs, reward, done, info = env.step(0)
""")
    assert names["reward"] == -3
    assert np.abs(names["first"]).max() <= 0.025


def test_wrappers_that_change_done() -> None:
    names = run("""\
import gym

class Once(gym.Wrapper):
    def reset(self):
        self.n = 0
        return self.env.reset() * 2

    def step(self, action):
        obs, reward, done, info = self.env.step(action)
        self.n += 1
        if self.n == self.limit:
            done = True
        return obs, reward, done, info

env = Once(gym.make("CartPole-v1", max_episode_steps=4))
results = []
for env.limit in (3, 9):
    state = env.reset()
    done = False
    while not done:
        state, reward, done, info = env.step(env.n % 2)
    results.append((env.n, done, info.get("TimeLimit.truncated", False)))
""")
    assert names["results"] == [(3, True, False), (4, True, True)]


def test_a_class_without_a_base() -> None:
    names = run("""\
class Corridor:
    def reset(self):
        self.x = 0
        return self.x, 7

    def step(self, action):
        self.x += action
        return self.x, 1.0, self.x == 2, {}

world = Corridor()
state = world.reset()
for _ in range(2):
    s, r, done, info = world.step(1)
""")
    assert names["state"] == (0, 7)
    assert (names["s"], names["done"], names["truncated"]) == (2, True, False)


def test_marks() -> None:
    text = WALK + "    def render(self, mode='human'):\n        pass\n"
    assert marks(text) == ["the constructor gets the render mode now (render_mode=), render() nothing"]
    text = "import gym\nclass A(gym.Env):\n    def step(self, action):\n        return self.result\n"
    assert marks(text) == ["step() must return observation, reward, terminated, truncated, info"]
