import gym
import numpy as np
from gym import spaces
from gym.envs.registration import register
from gym.utils import seeding


class CorridorEnv(gym.Env):
    metadata = {"render.modes": ["human", "ansi"]}

    def __init__(self, length=5):
        self.length = length
        self.action_space = spaces.Discrete(2)
        self.observation_space = spaces.Box(low=0, high=length, shape=(1,), dtype=np.float32)
        self.seed()

    def seed(self, seed=None):
        self.np_random, seed = seeding.np_random(seed)
        return [seed]

    def reset(self):
        self.position = self.np_random.randint(self.length)
        return np.array([self.position])

    def step(self, action):
        assert self.action_space.contains(action)
        self.position = max(0, self.position + (1 if action else -1))
        done = self.position >= self.length
        return np.array([self.position]), float(done), done, {}

    def render(self, mode="human", close=False):
        if close:
            return
        picture = "." * self.position + "A" + "." * (self.length - self.position) + "G"
        if mode == "human":
            print(picture)
        else:
            return picture


class Doubled(gym.RewardWrapper):
    def reward(self, reward):
        return 2 * reward


register(id="Corridor-v0", entry_point="__main__:CorridorEnv", max_episode_steps=30, kwargs={"length": 7})

env = Doubled(gym.make("Corridor-v0"))
env.seed(3)
observation = env.reset()
done = False
while not done:
    observation, reward, done, info = env.step(1)
    env.render()
print(observation, reward, done, info)
print(env, env.unwrapped.length)
