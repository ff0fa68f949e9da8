import gym

env = gym.make("CartPole-v0")
env.reset()
for _ in range(100):
    env.render()
    env.step(env.action_space.sample())  # whatever happens
env.close()
print("done")
