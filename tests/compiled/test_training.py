"""The two kinds of compiled training that use EnvPool's `xla`: an unrolled rollout (PPO), and one scan of it all (PQN)."""

import os
from typing import Any

import numpy as np
import pytest

import atari.integrations.envpool as envpool

os.environ.setdefault("JAX_PLATFORMS", "cpu")
jax = pytest.importorskip("jax", reason="needs JAX, which scripts/test --jax installs")

WEIGHTS = np.random.default_rng(0).normal(size=(4 * 21 * 21, 6)).astype(np.float32)


def make(num_envs: int) -> Any:
    return envpool.make("Pong-v5", "gym", num_envs=num_envs, episodic_life=True, reward_clip=True, seed=1)


def values(weights: Any, observations: Any) -> Any:
    """The values of the actions, by a linear network of every fourth pixel."""
    return observations[..., ::4, ::4].reshape(-1, len(weights)) / 255.0 @ weights


def test_a_rollout_unrolled_in_a_compiled_function() -> None:
    envs = make(2)
    handle, _, _, step = envs.xla()

    @jax.jit
    def collect(handle: Any, observation: Any, key: Any) -> Any:
        rewards = jax.numpy.zeros((6, 2))
        for row in range(6):
            key, drawn = jax.random.split(key)
            action = jax.random.categorical(drawn, values(WEIGHTS, observation))
            handle, (observation, reward, _, info) = step(handle, action)
            rewards = rewards.at[row].set(reward)
        return handle, observation, key, rewards, info

    state = (handle, envs.reset(), jax.random.PRNGKey(1))
    for _ in range(5):
        *state, rewards, info = collect(*state)
    assert info["elapsed_step"].tolist() == [30, 30]
    assert rewards.shape == (6, 2)


def test_a_whole_training_in_one_compiled_scan() -> None:
    envs = make(4)
    envs.reset()
    envs.step(np.zeros(4, int))
    handle, _, _, step = envs.xla()
    first = envs.reset()

    def play(weights: Any, carry: Any, key: Any) -> Any:
        handle, observation, lengths = carry
        random, chosen = jax.random.randint(key, (4,), 0, 6), values(weights, observation).argmax(1)
        action = jax.numpy.where(jax.random.uniform(key, (4,)) < 0.5, random, chosen)
        handle, (following, reward, _, info) = step(handle, action)
        return (handle, following, (lengths + 1) * (1 - info["terminated"])), (observation, action, reward)

    def update(carry: Any, key: Any) -> Any:
        weights, played = carry
        keys = jax.random.split(key, 8)
        played, (seen, actions, rewards) = jax.lax.scan(lambda inner, key: play(weights, inner, key), played, keys)

        def loss(weights: Any) -> Any:
            chosen = jax.numpy.take_along_axis(values(weights, seen), actions.reshape(-1, 1), 1)[:, 0]
            return ((chosen - rewards.reshape(-1)) ** 2).mean()

        value, gradient = jax.value_and_grad(loss)(weights)
        return (weights - 1e-4 * gradient, played), value

    @jax.jit
    def train(key: Any) -> Any:
        begin = (jax.numpy.array(handle), first, jax.numpy.zeros(4))
        return jax.lax.scan(update, (jax.numpy.array(WEIGHTS), begin), jax.random.split(key, 10))

    (_, (_, _, lengths)), losses = train(jax.random.PRNGKey(0))
    assert losses.shape == (10,)
    assert np.isfinite(losses).all()
    assert lengths.tolist() == [80.0] * 4
