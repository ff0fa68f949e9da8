"""Rollouts compiled by JAX, as in PPO scripts and PureJaxQL: the loop is a scan over `step`."""

import envpool
import gym  # noqa: F401 - its spaces and its interface are wanted
import jax
import jax.numpy as jnp
import numpy as np

envs = envpool.make("Breakout-v5", env_type="gym", num_envs=4, episodic_life=True, reward_clip=True, seed=1)
envs.num_envs = 4
handle, recv, send, step_env = envs.xla()


def step_once(carry, _):
    handle, returns, returned, key = carry
    key, subkey = jax.random.split(key)
    action = jax.random.randint(subkey, (4,), 0, envs.action_space.n)
    handle, (observation, reward, done, info) = step_env(handle, action)
    returns = returns + info["reward"]
    over = info["terminated"] + info["TimeLimit.truncated"]
    returned = jnp.where(over, returns, returned)
    returns = returns * (1 - info["terminated"]) * (1 - info["TimeLimit.truncated"])
    return (handle, returns, returned, key), (observation, action, reward, done)


@jax.jit
def rollout(carry):
    return jax.lax.scan(step_once, carry, (), 100)


others = envpool.make("Breakout-v5", env_type="gym", num_envs=4, episodic_life=True, reward_clip=True, seed=1)
others.reset()
envs.reset()
carry = (jnp.array(handle), jnp.zeros(4), jnp.zeros(4), jax.random.PRNGKey(0))
for _ in range(3):
    carry, (observations, actions, rewards, dones) = rollout(carry)
    for row, action in enumerate(np.asarray(actions)):
        observation, reward, done, _ = others.step(action)
        assert np.array_equal(observations[row], observation)
        assert np.array_equal(rewards[row], reward)
        assert np.array_equal(dones[row], done)
handle = send(carry[0], np.zeros(4, int), np.array([3, 2, 1, 0]))
handle, (_, _, _, info) = recv(handle)
print(carry[2], info["env_id"], info["players"]["env_id"].dtype)
