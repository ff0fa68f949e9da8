"""Q-learning on the taxi, and a policy search on the pole, with statistics of Monitor."""

import json
import glob
import random
import sys

import numpy as np

import gym
from gym import wrappers

folder = sys.argv[1]
env = gym.make("Taxi-v3")
env.seed(2)
rng = random.Random(2)
q = np.zeros([env.observation_space.n, env.action_space.n])
totals = []
for episode in range(300):
    state, done, total = env.reset(), False, 0
    while not done:
        action = rng.randrange(6) if rng.random() < 0.1 else int(np.argmax(q[state]))
        new, reward, done, _ = env.step(action)
        q[state, action] += 0.6 * (reward + 0.95 * np.max(q[new]) - q[state, action])
        state, total = new, total + reward
    totals.append(total)
print(sum(totals[:50]), sum(totals[-50:]), list(env.env.decode(state)))

env = wrappers.Monitor(gym.make("CartPole-v0"), folder, video_callable=False, force=True)
env.seed(7)
best = None
for trial in range(30):
    weights = np.array([rng.gauss(0, 1) for _ in range(4)])
    observation, done, length = env.reset(), False, 0
    while not done:
        observation, reward, done, info = env.step(int(np.dot(weights, observation) > 0))
        length += 1
    best = max(best or 0, length)
env.close()
with open(glob.glob(folder + "/*.stats.json")[0]) as file:
    stats = json.load(file)
print(best, stats["episode_lengths"], sum(stats["episode_rewards"]) == sum(stats["episode_lengths"]))
