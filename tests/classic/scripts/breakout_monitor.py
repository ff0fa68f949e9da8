import sys

import gym
import gym.wrappers
from gym.wrappers import Monitor

outdir = sys.argv[1]
env = gym.make("Breakout-v0")
env = Monitor(env, directory=outdir, force=True)
env.seed(0)
print(env.unwrapped.get_action_meanings())
for episode in range(2):
    env.reset()
    env.render()
    lives = env.unwrapped.ale.lives()
    total_reward = 0
    step = 0
    while True:
        action = env.action_space.sample()
        next_state, reward, done, info = env.step(action)
        total_reward += reward
        step += 1
        if done or step == 60:
            print(
                "episode {}: {} lives at first, {} after {} steps, reward {}".format(
                    episode, lives, info["ale.lives"], step, total_reward
                )
            )
            break
