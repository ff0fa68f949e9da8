"""The interface of an agent, and the loop that plays its episodes. The agents are the other scripts in this folder."""

import argparse
from typing import Any, Protocol

import gymnasium


class Agent(Protocol):
    """An agent, which chooses actions and learns from their results."""

    def select_action(self, observation: Any) -> Any:
        """The action to take."""

    def train(self, observation: Any, action: Any, reward: float, new_observation: Any) -> None:
        """Learn from one step."""


def play_episode(env: gymnasium.Env[Any, Any], agent: Agent, *, train: bool = True) -> float:
    """Play one episode and return the sum of its rewards."""
    observation, _ = env.reset()
    total, over = 0.0, False
    while not over:
        action = agent.select_action(observation)
        new_observation, reward, terminated, truncated, _ = env.step(action)
        if train:
            agent.train(observation, action, float(reward), new_observation)
        observation = new_observation
        total, over = total + float(reward), terminated or truncated
    return total


def evaluate(env: gymnasium.Env[Any, Any], agent: Agent, episodes: int) -> list[float]:
    """The returns of some episodes in which the agent does not learn."""
    return [play_episode(env, agent, train=False) for _ in range(episodes)]


def count(text: str) -> int:
    """A number on the command line: 1 or more."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"give a number, 1 or more, got {text!r}")
    return int(text)
