"""Value iteration on a lake that is not slippery, and on the slippery one."""

import numpy as np

import gym
from gym.envs.registration import register

register(
    id="FrozenLakeNotSlippery-v0",
    entry_point="gym.envs.toy_text:FrozenLakeEnv",
    kwargs={"map_name": "4x4", "is_slippery": False},
    max_episode_steps=100,
    reward_threshold=0.78,
)


def values(env, gamma):
    value = np.zeros(env.env.nS, dtype=float)
    while True:
        table = np.array(
            [
                [sum(p * (r + gamma * value[n]) for p, n, r, _ in env.env.P[s][a]) for a in range(env.env.nA)]
                for s in range(env.env.nS)
            ]
        )
        if np.abs(table.max(axis=1) - value).max() < 1e-9:
            return table
        value = table.max(axis=1)


for env_id, gamma in (("FrozenLakeNotSlippery-v0", 0.9), ("FrozenLake8x8-v0", 0.99)):
    env = gym.make(env_id)
    env.seed(1)
    table = values(env, gamma)
    rewards = []
    for _ in range(50):
        state, done, total = env.reset(), False, 0.0
        while not done:
            state, reward, done, _ = env.step(np.argmax(table[state]))
            total += reward
        rewards.append(total)
    print(env_id, np.round(table.max(), 4), np.mean(rewards))
