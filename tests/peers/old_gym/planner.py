"""Plan by saved states, as programs for tree search did: planner.py GAME prints the actions and the reward."""

import random
import sys

import gym

env = gym.envs.atari.AtariEnv(game=sys.argv[1], obs_type="image", frameskip=5)
env.seed(5)
env.reset()
rng = random.Random(5)
chosen, total = [], 0.0
for _ in range(15):
    state = env.clone_full_state()
    best, best_return = 0, None
    for action in range(env.action_space.n):
        value = env.step(action)[1]
        for _ in range(8):
            value += env.step(rng.randrange(env.action_space.n))[1]
        if best_return is None or value > best_return:
            best, best_return = action, value
        env.restore_full_state(state)
    total += env.step(best)[1]
    chosen.append(best)
print(chosen, total, int(env.ale.getRAM().sum()), int(env._get_image().sum()))
