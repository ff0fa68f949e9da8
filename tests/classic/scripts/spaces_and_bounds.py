import gym
from gym import envs, spaces

env = gym.make("CartPole-v0")
print(env.action_space)
print(env.observation_space)
print(env.observation_space.high)
print(env.observation_space.low)

print(gym.make("MountainCar-v0").observation_space.low)
print(gym.make("FrozenLake-v0").observation_space)
print(gym.make("Pendulum-v0").action_space.high)

space = spaces.Discrete(8)
x = space.sample()
assert space.contains(x)
assert space.n == 8

ids = [spec.id for spec in envs.registry.all()]
print("Breakout-v0" in ids, "CartPole-v0" in ids)
print(sorted(envs.registry.all(), key=lambda spec: spec.id)[0])
