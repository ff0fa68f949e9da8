import sys

import gym
import numpy as np


class Agent(object):
    """A linear policy, improved by climbing hills."""

    def __init__(self, env, noise):
        self.env = env
        self.noise = noise
        self.weights = np.zeros(env.observation_space.shape[0], dtype=np.float)

    def act(self, observation, weights=None):
        weights = self.weights if weights is None else weights
        return int(np.dot(weights, observation) > 0)

    def rollout(self, weights=None):
        observation, total, done = self.env.reset(), 0.0, False
        while not done:
            observation, reward, done, info = self.env.step(self.act(observation, weights))
            total += reward
        return total, info

    def train(self, episodes):
        best, _ = self.rollout()
        for _ in range(episodes):
            weights = self.weights + self.noise * np.random.randn(4)
            total, _ = self.rollout(weights)
            if total >= best:
                best, self.weights = total, weights


if __name__ == "__main__":
    np.random.seed(int(sys.argv[1]))
    env = gym.make("CartPole-v0")
    env.seed(int(sys.argv[1]))
    agent = Agent(env, noise=float(sys.argv[2]))
    agent.train(60)
    returns = []
    for _ in range(100):
        total, info = agent.rollout()
        returns.append(total)
    print("mean of 100 episodes:", np.mean(returns), "solved:", np.mean(returns) >= env.spec.reward_threshold)
    print("the last one was cut off:", info.get("TimeLimit.truncated"))
