"""The loop of a PPO script for EnvPool, with a wrapper for the statistics of whole games."""

import argparse

import envpool
import gym
import numpy as np


class RecordEpisodeStatistics(gym.Wrapper):
    def __init__(self, env):
        super().__init__(env)
        self.num_envs = getattr(env, "num_envs", 1)
        self.episode_returns = None
        self.episode_lengths = None

    def reset(self, **kwargs):
        observations = super().reset(**kwargs)
        self.episode_returns = np.zeros(self.num_envs, dtype=np.float32)
        self.episode_lengths = np.zeros(self.num_envs, dtype=np.int32)
        self.returned_episode_returns = np.zeros(self.num_envs, dtype=np.float32)
        self.returned_episode_lengths = np.zeros(self.num_envs, dtype=np.int32)
        return observations

    def step(self, action):
        observations, rewards, dones, infos = super().step(action)
        self.episode_returns += infos["reward"]
        self.episode_lengths += 1
        self.returned_episode_returns[:] = self.episode_returns
        self.returned_episode_lengths[:] = self.episode_lengths
        self.episode_returns *= 1 - infos["terminated"]
        self.episode_lengths *= 1 - infos["terminated"]
        infos["r"] = self.returned_episode_returns
        infos["l"] = self.returned_episode_lengths
        return (observations, rewards, dones, infos)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--num-envs", type=int, default=8)
    parser.add_argument("--num-steps", type=int, default=400)
    args = parser.parse_args()
    np.random.seed(1)
    envs = envpool.make(
        "Breakout-v5",
        env_type="gym",
        num_envs=args.num_envs,
        episodic_life=True,
        reward_clip=True,
        repeat_action_probability=0.25,
        seed=1,
    )
    envs.num_envs = args.num_envs
    envs.single_action_space = envs.action_space
    envs.single_observation_space = envs.observation_space
    envs.is_vector_env = True
    envs = RecordEpisodeStatistics(envs)
    assert isinstance(envs.action_space, gym.spaces.Discrete), "only discrete action space is supported"

    obs = np.zeros((args.num_steps, args.num_envs, *envs.single_observation_space.shape), dtype=np.uint8)
    actions = np.zeros((args.num_steps, args.num_envs, *envs.single_action_space.shape), dtype=np.int64)
    rewards = np.zeros((args.num_steps, args.num_envs), dtype=np.float32)
    dones = np.zeros((args.num_steps, args.num_envs), dtype=np.float32)
    next_obs = np.asarray(envs.reset())
    next_done = np.zeros(args.num_envs)
    lives_lost = 0
    for step in range(args.num_steps):
        obs[step] = next_obs
        dones[step] = next_done
        actions[step] = np.random.randint(envs.single_action_space.n, size=args.num_envs)
        next_obs, rewards[step], next_done, info = envs.step(actions[step])
        lives_lost += sum(next_done)
        for idx, d in enumerate(next_done):
            if d and info["lives"][idx] == 0:
                print(f"return {info['r'][idx]:.0f} length {info['l'][idx]} steps {info['elapsed_step'][idx]}")
    assert rewards.max() == 1
    print("ended", lives_lost)
    envs.close()
