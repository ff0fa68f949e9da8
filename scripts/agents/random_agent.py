#!/usr/bin/env python
"""A random agent: the smallest agent, and the baseline for all others.

It plays any ID: ALE/Breakout-v5, CartPole-v1, Copy-v0.
"""

import argparse
import statistics
import sys
from pathlib import Path
from typing import Any

import gymnasium

import atari  # noqa: F401 - registers the IDs

sys.path.insert(0, str(Path(__file__).parent))  # PYTHONSAFEPATH leaves it out
from loop import count, play_episode


class RandomAgent:
    """An agent that draws each action with the same probability."""

    def __init__(self, action_space: gymnasium.Space[Any], seed: int | None = None) -> None:
        self.action_space = action_space
        self.action_space.seed(seed)

    def select_action(self, observation: Any) -> Any:
        """A random action."""
        return self.action_space.sample()

    def train(self, observation: Any, action: Any, reward: float, new_observation: Any) -> None:
        """Learn nothing."""


def main(arguments: list[str] | None = None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "env", nargs="?", default="ALE/Pong-ram-v5", help="ID of the environment (default: %(default)s)"
    )
    parser.add_argument("--episodes", type=count, default=5, help="episodes to play (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="seed of environment and agent (default: %(default)s)")
    options = parser.parse_args(arguments)

    try:
        env = gymnasium.make(options.env)
    except gymnasium.error.Error as error:
        parser.error(str(error))
    env.reset(seed=options.seed)
    agent = RandomAgent(env.action_space, options.seed)
    returns = []
    for episode in range(1, options.episodes + 1):
        returns.append(play_episode(env, agent))
        print(f"episode {episode}: return {returns[-1]:g}")
    print(f"mean return {statistics.mean(returns):.2f}")


if __name__ == "__main__":
    main()
