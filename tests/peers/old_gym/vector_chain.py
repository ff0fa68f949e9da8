"""The environments of single-file trainings of Gym's last years: vector_chain.py STEPS prints digests."""

import hashlib
import random
import sys

import numpy as np

import gym


def make_env(seed):
    def thunk():
        env = gym.make("BreakoutNoFrameskip-v4")
        env = gym.wrappers.RecordEpisodeStatistics(env)
        env = gym.wrappers.ResizeObservation(env, (84, 84))
        env = gym.wrappers.GrayScaleObservation(env)
        env = gym.wrappers.FrameStack(env, 4)
        env.seed(seed)
        env.action_space.seed(seed)
        env.observation_space.seed(seed)
        return env

    return thunk


envs = gym.vector.SyncVectorEnv([make_env(seed) for seed in range(3)])
assert isinstance(envs.single_action_space, gym.spaces.Discrete)
rng = random.Random(0)
digest = hashlib.sha256()
returns = []
observations = envs.reset()
for _ in range(int(sys.argv[1])):
    digest.update(observations.tobytes())
    actions = np.array([rng.randrange(envs.single_action_space.n) for _ in range(envs.num_envs)])
    observations, rewards, dones, infos = envs.step(actions)
    for done, info in zip(dones, infos):
        if done:
            digest.update(np.array(info["terminal_observation"]).tobytes())
            returns.append((float(info["episode"]["r"]), int(info["episode"]["l"])))
envs.close()
print(returns, digest.hexdigest())
