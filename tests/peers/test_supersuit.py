"""SuperSuit's vectors of several players' games, and the chain of CleanRL's `ppo_pettingzoo_ma_atari`, beside PettingZoo's.

SuperSuit copies an environment by cloudpickle, even for a vector of one process.
"""

import hashlib
import importlib
import pickle
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import ale_py.roms
import gymnasium
import numpy as np
import pytest

pytest.importorskip("multi_agent_ale_py")

from atari.multiplayer import parallel_env

pytestmark = pytest.mark.peers

ROMS = str(Path(str(ale_py.roms.get_rom_path("pong"))).parent)
GAMES = ("pong_v3", "joust_v3", "surround_v2", "space_invaders_v2", "warlords_v3", "entombed_cooperative_v3")


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def theirs(name: str, **arguments: Any) -> Any:
    return importlib.import_module(f"pettingzoo.atari.{name}").parallel_env(auto_rom_install_path=ROMS, **arguments)


def preprocessed(env: Any) -> Any:
    """The wrappers of the script, in its order."""
    import supersuit

    env = supersuit.frame_skip_v0(supersuit.max_observation_v0(env, 2), 4)
    env = supersuit.clip_reward_v0(env, lower_bound=-1, upper_bound=1)
    env = supersuit.resize_v1(supersuit.color_reduction_v0(env, mode="B"), x_size=84, y_size=84)
    return supersuit.agent_indicator_v0(supersuit.frame_stack_v1(env, 4), type_only=False)


def vector(env: Any, count: int = 3, **options: Any) -> Any:
    import supersuit

    options = {"num_cpus": 0, "base_class": "gymnasium", **options}
    return supersuit.concat_vec_envs_v1(supersuit.pettingzoo_env_to_vec_env_v1(env), count, **options)


def digest(envs: Any, steps: int, seed: int = 5) -> str:
    """A hash of all observations, rewards and ends of random actions."""
    rng, seen = np.random.default_rng(seed), hashlib.sha256()
    observations = envs.reset(seed=seed)[0]
    for _ in range(steps):
        seen.update(np.ascontiguousarray(observations).tobytes())
        observations, *rest, _ = envs.step(rng.integers(envs.action_space.n, size=envs.num_envs))
        for part in rest:
            seen.update(np.asarray(part, np.float64).tobytes())
    return seen.hexdigest()


@pytest.mark.parametrize("name", GAMES)
def test_the_chain_of_ppo_equals_pettingzoos(name: str) -> None:
    both = [vector(preprocessed(env)) for env in (parallel_env(name), theirs(name))]
    assert both[0].observation_space == both[1].observation_space
    assert both[0].num_envs == both[1].num_envs
    assert digest(both[0], 50) == digest(both[1], 50)


def test_random_frame_skips_equal_pettingzoos() -> None:
    import supersuit

    makes = (parallel_env, theirs)
    both = [vector(supersuit.frame_skip_v0(make("boxing_v2", obs_type="ram"), (2, 5)), 2) for make in makes]
    assert digest(both[0], 100) == digest(both[1], 100)


def test_vectors_of_ram() -> None:
    both = [vector(make("pong_v3", obs_type="ram"), 8) for make in (parallel_env, theirs)]
    assert digest(both[0], 150) == digest(both[1], 150)


@pytest.mark.parametrize("base_class", ["gymnasium", "stable_baselines3"])
def test_a_preset_in_a_vector(base_class: str) -> None:
    """This package's own preprocessing, without SuperSuit's wrappers."""
    envs = vector(parallel_env("pong_v3", preset="multiplayer_dqn", agent_indicator=True), 2, base_class=base_class)
    observations = envs.reset()
    observations = observations[0] if base_class == "gymnasium" else observations
    assert observations.shape == (4, 84, 84, 6)
    assert envs.step(np.zeros(4, np.int64))[0].shape == (4, 84, 84, 6)


def test_the_copies_go_on_from_where_the_environment_was() -> None:
    env = parallel_env("pong_v3", obs_type="ram")
    env.reset(seed=3)
    for _ in range(50):
        env.step(dict.fromkeys(env.agents, 1))
    other = pickle.loads(pickle.dumps(env))
    for _ in range(50):
        one, two = (each.step(dict.fromkeys(each.agents, 2)) for each in (env, other))
        np.testing.assert_equal(one, two)


def test_the_script_learns() -> None:
    """A short PPO on the chain, as the script makes it: statistics around the vector, and agents that share a network."""
    import torch
    from torch import nn
    from torch.distributions import Categorical

    torch.manual_seed(0)
    envs = vector(preprocessed(parallel_env("pong_v3")), 2)
    envs.single_observation_space, envs.single_action_space = envs.observation_space, envs.action_space
    envs.is_vector_env = True
    shared = nn.Sequential(nn.Conv2d(6, 8, 8, stride=4), nn.ReLU(), nn.Flatten(), nn.Linear(8 * 20 * 20, 32), nn.ReLU())
    actor, critic = nn.Linear(32, int(envs.action_space.n)), nn.Linear(32, 1)
    parameters = [*shared.parameters(), *actor.parameters(), *critic.parameters()]
    optimizer = torch.optim.Adam(parameters, 2.5e-4, eps=1e-5)

    def hidden(observations: Any) -> Any:
        images = torch.as_tensor(observations).float()
        images[..., :4] /= 255.0  # the planes of the agents are 0 and 1 in the script
        return shared(images.permute(0, 3, 1, 2))

    observations = envs.reset(seed=1)[0]
    assert observations.shape == (4, 84, 84, 6)
    losses = []
    for _ in range(2):
        rows: list[tuple[Any, ...]] = []
        for _ in range(8):
            with torch.no_grad():
                seen = hidden(observations)
                policy = Categorical(logits=actor(seen))
                actions = policy.sample()
            following, rewards, terminations, truncations, _ = envs.step(actions.numpy())
            done = np.asarray(terminations) | np.asarray(truncations)
            rows.append(
                (observations, actions, policy.log_prob(actions), rewards, done, critic(seen).flatten().detach())
            )
            observations = following
        gains, running = [], torch.zeros(4)
        for _, _, _, rewards, done, values in reversed(rows):
            running = torch.as_tensor(rewards, dtype=torch.float32) + 0.99 * running * (
                1 - torch.as_tensor(done).float()
            )
            gains.insert(0, running - values)
        batch, chosen = np.concatenate([row[0] for row in rows]), torch.cat([row[1] for row in rows])
        old, advantages = torch.cat([row[2] for row in rows]), torch.cat(gains)
        seen = hidden(batch)
        policy = Categorical(logits=actor(seen))
        ratio = (policy.log_prob(chosen) - old).exp()
        clipped = torch.minimum(ratio * advantages, ratio.clamp(0.9, 1.1) * advantages).mean()
        loss = critic(seen).square().mean() * 0.5 - clipped - 0.01 * policy.entropy().mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        losses.append(loss.item())
    assert np.isfinite(losses).all()
    envs.close()


def test_gymnasiums_spaces() -> None:
    """The script reads these attributes of the vector."""
    envs = vector(parallel_env("pong_v3", obs_type="ram"), 2)
    assert isinstance(envs.action_space, gymnasium.spaces.Discrete)
    assert envs.observation_space.shape == (128,)
