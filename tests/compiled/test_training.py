"""The two kinds of compiled training that use EnvPool's `xla`: an unrolled rollout (PPO), and one scan of it all (PQN)."""

import os
from typing import Any, NamedTuple

import numpy as np
import pytest

import atari.integrations.envpool as envpool

os.environ.setdefault("JAX_PLATFORMS", "cpu")
jax = pytest.importorskip("jax", reason="needs JAX, which scripts/test --jax installs")
nn = pytest.importorskip("flax.linen", reason="needs Flax, which scripts/test --jax installs")
optax = pytest.importorskip("optax", reason="needs Optax, which scripts/test --jax installs")


class Log(NamedTuple):
    handle: Any
    returns: Any
    lengths: Any


def make(num_envs: int) -> Any:
    return envpool.make("Pong-v5", "gym", num_envs=num_envs, episodic_life=True, reward_clip=True, seed=1)


def network(actions: int) -> Any:
    return nn.Sequential(
        [
            lambda x: x.transpose(0, 2, 3, 1) / 255.0,
            nn.Conv(8, (8, 8), (8, 8)),
            nn.relu,
            lambda x: x.reshape(len(x), -1),
            nn.Dense(actions),
        ]
    )


def test_a_rollout_unrolled_in_a_compiled_function() -> None:
    envs = make(2)
    handle, _, _, step = envs.xla()
    model = network(envs.action_space.n)
    observation = envs.reset()
    parameters = model.init(jax.random.PRNGKey(0), observation)

    @jax.jit
    def collect(handle: Any, observation: Any, key: Any) -> Any:
        rewards = jax.numpy.zeros((6, 2))
        for row in range(6):
            key, drawn = jax.random.split(key)
            action = jax.random.categorical(drawn, model.apply(parameters, observation))
            handle, (observation, reward, _, info) = step(handle, action)
            rewards = rewards.at[row].set(reward)
        return handle, observation, key, rewards, info

    state = (handle, observation, jax.random.PRNGKey(1))
    for _ in range(5):
        *state, rewards, info = collect(*state)
    assert info["elapsed_step"].tolist() == [30, 30]
    assert rewards.shape == (6, 2)


def test_a_whole_training_in_one_compiled_scan() -> None:
    envs = make(4)
    envs.reset()
    envs.step(np.zeros(4, int))
    handle, _, _, step = envs.xla()
    model, optimizer = network(envs.action_space.n), optax.adam(1e-3)
    first = envs.reset()
    log = Log(jax.numpy.array(handle), jax.numpy.zeros(4), jax.numpy.zeros(4))

    def play(parameters: Any, carry: Any, key: Any) -> Any:
        observation, log = carry
        values = model.apply(parameters, observation)
        action = jax.numpy.where(
            jax.random.uniform(key, (4,)) < 0.5, jax.random.randint(key, (4,), 0, 6), values.argmax(1)
        )
        handle, (following, reward, done, info) = step(log.handle, action)
        goes_on = 1 - info["terminated"]
        log = Log(handle, (log.returns + info["reward"]) * goes_on, (log.lengths + 1) * goes_on)
        return (following, log), (observation, action, reward, done)

    def update(carry: Any, key: Any) -> Any:
        parameters, state, played = carry
        played, (observations, actions, rewards, _) = jax.lax.scan(
            lambda inner, key: play(parameters, inner, key), played, jax.random.split(key, 8)
        )

        def loss(parameters: Any) -> Any:
            values = model.apply(parameters, observations.reshape(-1, 4, 84, 84))
            chosen = jax.numpy.take_along_axis(values, actions.reshape(-1, 1), 1)[:, 0]
            return ((chosen - rewards.reshape(-1)) ** 2).mean()

        value, gradient = jax.value_and_grad(loss)(parameters)
        changes, state = optimizer.update(gradient, state)
        return (optax.apply_updates(parameters, changes), state, played), value

    @jax.jit
    def train(key: Any) -> Any:
        parameters = model.init(key, first)
        return jax.lax.scan(update, (parameters, optimizer.init(parameters), (first, log)), jax.random.split(key, 10))

    (_, _, (_, log)), losses = train(jax.random.PRNGKey(0))
    assert losses.shape == (10,)
    assert np.isfinite(losses).all()
    assert log.lengths.tolist() == [80.0] * 4
