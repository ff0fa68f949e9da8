"""The chain of wrappers that Baselines made popular, in our words: sample.py SEED STEPS prints digests."""

import hashlib
import random
import sys
from collections import deque

import cv2
import numpy as np

import gym
from gym import spaces


class Noops(gym.Wrapper):
    def reset(self, **kwargs):
        self.env.reset(**kwargs)
        self.count = self.unwrapped.np_random.randint(1, 31)
        for _ in range(self.count):
            observation, _, done, _ = self.env.step(0)
            assert not done
        return observation


class SkipAndPool(gym.Wrapper):
    def __init__(self, env, skip=4):
        gym.Wrapper.__init__(self, env)
        self._last = deque(maxlen=2)
        self._skip = skip

    def _step(self, action):
        total = 0.0
        for _ in range(self._skip):
            observation, reward, done, info = self.env.step(action)
            self._last.append(observation)
            total += reward
            if done:
                break
        return np.max(np.stack(self._last), axis=0), total, done, info


class OneLife(gym.Wrapper):
    over = True
    lives = 0

    def step(self, action):
        observation, reward, done, info = self.env.step(action)
        self.over = done
        lives = self.env.unwrapped.ale.lives()
        done = done or 0 < lives < self.lives
        self.lives = lives
        return observation, reward, done, info

    def reset(self, **kwargs):
        observation = self.env.reset(**kwargs) if self.over else self.env.step(0)[0]
        self.lives = self.env.unwrapped.ale.lives()
        return observation


class Fire(gym.Wrapper):
    def reset(self, **kwargs):
        assert self.env.unwrapped.get_action_meanings()[1] == "FIRE"
        self.env.reset(**kwargs)
        return self.env.step(1)[0]


class Small(gym.ObservationWrapper):
    def __init__(self, env):
        super(Small, self).__init__(env)
        self.observation_space = spaces.Box(low=0, high=255, shape=(84, 84, 1))

    def _observation(self, observation):
        gray = cv2.cvtColor(observation, cv2.COLOR_RGB2GRAY)
        return cv2.resize(gray, (84, 84), interpolation=cv2.INTER_AREA)[:, :, None]


class Signs(gym.RewardWrapper):
    def reward(self, reward):
        return np.sign(reward)


class Frames(object):
    def __init__(self, frames):
        self._frames = frames

    def __array__(self, dtype=None):
        stack = np.concatenate(self._frames, axis=2)
        return stack if dtype is None else stack.astype(dtype)


class Stack(gym.Wrapper):
    def __init__(self, env, k):
        gym.Wrapper.__init__(self, env)
        self.frames = deque([], maxlen=k)
        rows, columns, channels = env.observation_space.shape
        self.observation_space = spaces.Box(0, 255, (rows, columns, channels * k), dtype=np.uint8)

    def reset(self):
        first = self.env.reset()
        for _ in range(self.frames.maxlen):
            self.frames.append(first)
        return Frames(list(self.frames))

    def step(self, action):
        observation, reward, done, info = self.env.step(action)
        self.frames.append(observation)
        return Frames(list(self.frames)), reward, done, info


def make(env_id):
    env = gym.make(env_id)
    assert "NoFrameskip" in env.spec.id
    assert hasattr(gym.envs, "atari") and isinstance(env.unwrapped, gym.envs.atari.atari_env.AtariEnv)
    noops = env = Noops(env)
    env = OneLife(SkipAndPool(env))
    if "FIRE" in env.unwrapped.get_action_meanings():
        env = Fire(env)
    return Stack(Signs(Small(env)), 4), noops


def main(env_id, seed, steps):
    env, noops = make(env_id)
    env.seed(seed)
    rng = random.Random(seed)
    digest = hashlib.sha256()
    counts, lives, total = [], 0, 0.0
    observation = env.reset()
    counts.append(noops.count)
    for _ in range(steps):
        digest.update(np.array(observation, copy=False).tobytes())
        observation, reward, done, info = env.step(rng.randrange(env.action_space.n))
        total += reward
        if done:
            lives += 1
            over = info["ale.lives"] == 0
            observation = env.reset()
            if over:
                counts.append(noops.count)
    print(counts, lives, total, digest.hexdigest())


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
