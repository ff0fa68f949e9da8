"""Training loops in the shape of CleanRL's `ppo_atari` and `dqn_atari`, over the vector environment."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import vector as wrappers

import atari

pytestmark = pytest.mark.peers


def make(num_envs: int) -> Any:
    """Returns are sums of unclipped rewards; the agent gets their signs."""
    options = {"reward_clipping": False, "autoreset_mode": "SameStep", "max_num_frames_per_episode": 400}
    envs = gymnasium.make_vec("ALE/Breakout-v5", num_envs=num_envs, **options)
    return wrappers.TransformReward(wrappers.RecordEpisodeStatistics(envs), np.sign)


def network(outputs: int) -> Any:
    from torch import nn

    return nn.Sequential(
        nn.Conv2d(4, 8, 8, stride=4), nn.ReLU(), nn.Conv2d(8, 16, 4, stride=2), nn.ReLU(), nn.Flatten(),
        nn.Linear(16 * 9 * 9, 64), nn.ReLU(), nn.Linear(64, outputs),
    )  # fmt: skip


def advantages(rewards: Any, values: Any, dones: Any, last_value: Any) -> Any:
    """Generalized advantage estimation (Schulman et al. 2016)."""
    result, following = np.zeros_like(rewards), last_value
    running = np.zeros_like(last_value)
    for step in reversed(range(len(rewards))):
        going_on = 1.0 - dones[step]
        running = rewards[step] + 0.99 * following * going_on - values[step] + 0.99 * 0.95 * going_on * running
        result[step], following = running, values[step]
    return result


def test_ppo() -> None:
    import torch

    torch.manual_seed(0)
    games, steps = 8, 64
    envs = make(games)
    count = int(envs.single_action_space.n)
    agent = network(count + 1)  # logits and a value
    optimizer = torch.optim.Adam(agent.parameters(), lr=1e-3)
    memory = torch.zeros((steps, games, 4, 84, 84), dtype=torch.uint8)
    returns: list[float] = []
    losses: list[float] = []
    observation, _ = envs.reset(seed=1)
    for _ in range(2):
        actions, logs, values, rewards, dones = (np.zeros((steps, games), np.float32) for _ in range(5))
        for step in range(steps):
            memory[step] = atari.to_torch(observation)
            with torch.no_grad():
                output = agent(memory[step] / 255.0)
                policy = torch.distributions.Categorical(logits=output[:, :count])
                action = policy.sample()
            values[step], actions[step], logs[step] = output[:, count], action, policy.log_prob(action)
            observation, reward, terminated, truncated, info = envs.step(action.numpy())
            rewards[step], dones[step] = reward, terminated | truncated
            if "episode" in info:
                returns += info["episode"]["r"][info["_episode"]].tolist()
        with torch.no_grad():
            last = agent(atari.to_torch(observation) / 255.0)[:, count].numpy()
        gain = advantages(rewards, values, dones, last)
        flat = memory.flatten(0, 1)
        target, old, chosen, gains = (torch.as_tensor(x.reshape(-1)) for x in (gain + values, logs, actions, gain))
        for rows in torch.randperm(steps * games).split(128):
            output = agent(flat[rows] / 255.0)
            policy = torch.distributions.Categorical(logits=output[:, :count])
            ratio = (policy.log_prob(chosen[rows]) - old[rows]).exp()
            gained = torch.minimum(ratio * gains[rows], ratio.clamp(0.9, 1.1) * gains[rows]).mean()
            loss = (output[:, count] - target[rows]).square().mean() - gained - 0.01 * policy.entropy().mean()
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            losses.append(loss.item())
    assert np.isfinite(losses).all()
    assert len(returns) >= games
    assert all(score == int(score) for score in returns)


def test_dqn() -> None:
    import torch

    rng = np.random.default_rng(0)
    torch.manual_seed(0)
    games, size = 4, 200
    envs = make(games)
    count = int(envs.single_action_space.n)
    learned, target = network(count), network(count)
    target.load_state_dict(learned.state_dict())
    optimizer = torch.optim.Adam(learned.parameters(), lr=1e-3)
    observations = np.zeros((2, size, games, 4, 84, 84), np.uint8)  # before and after each step
    actions = np.zeros((size, games), np.int64)
    rewards, ends = np.zeros((size, games), np.float32), np.zeros((size, games), np.float32)
    begun = np.zeros((size, games), bool)  # a new episode begins after the step
    returns: list[float] = []
    losses: list[float] = []
    observation, _ = envs.reset(seed=2)
    for step in range(size):
        observations[0, step] = observation
        with torch.no_grad():
            greedy = learned(atari.to_torch(observation) / 255.0).argmax(1).numpy()
        actions[step] = np.where(rng.random(games) < 0.5, rng.integers(count, size=games), greedy)
        observation, rewards[step], ends[step], truncated, info = envs.step(actions[step])
        observations[1, step] = observation
        if "final_obs" in info:
            ended = info["_final_obs"]
            assert np.array_equal(ended, (ends[step] > 0) | truncated)
            begun[step] = ended
            observations[1, step, ended] = info["final_obs"][ended]
            returns += info["episode"]["r"][info["_episode"]].tolist()
        if step >= 50 and step % 4 == 0:
            rows, columns = rng.integers(step, size=32), rng.integers(games, size=32)
            before, after = (torch.as_tensor(observations[part, rows, columns]) / 255.0 for part in (0, 1))
            reward, end, action = (torch.as_tensor(x[rows, columns]) for x in (rewards, ends, actions))
            with torch.no_grad():
                wanted = reward + 0.99 * target(after).max(1).values * (1 - end)
            loss = torch.nn.functional.mse_loss(wanted, learned(before).gather(1, action[:, None])[:, 0])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            losses.append(loss.item())
        if step % 100 == 99:
            target.load_state_dict(learned.state_dict())
    assert np.isfinite(losses).all()
    assert np.mean(losses[-10:]) < 1
    assert returns
    # The observation after a step is the one before the next step, except at the start of an episode.
    same = (observations[1, :-1] == observations[0, 1:]).all((2, 3, 4))
    assert same[~begun[:-1]].all()
    assert not same[begun[:-1]].any()
