import gym

env = gym.make("CartPole-v0")
env.seed(0)
env.action_space.seed(0)
for i_episode in range(20):
    observation = env.reset()
    for t in range(100):
        env.render()
        if t == 0 and i_episode == 0:
            print(observation)
        action = env.action_space.sample()
        observation, reward, done, info = env.step(action)
        if done:
            print("Episode finished after {} timesteps".format(t + 1))
            break
env.close()
