#!/usr/bin/env python
"""Tabular Q-learning on a toy-text environment: by default FrozenLake, in which two of three steps slip.

Q(s, a) is the discounted sum of the rewards after action a in state s. Each step corrects it towards the reward plus
the greatest Q of the next state (Watkins 1989). No action is taken in a state that ends an episode, so its values stay
zero, and `train` needs no argument for the end.
"""

import argparse
import random
import statistics
import sys
from pathlib import Path

import gymnasium

sys.path.insert(0, str(Path(__file__).parent))  # PYTHONSAFEPATH leaves it out
from loop import count, evaluate, play_episode
from random_agent import RandomAgent


class QLearner:
    """A table of Q-values, one row a state.

    Args:
        states: the number of states.
        actions: the number of actions.
        learning_rate: the part of the difference that each step corrects.
        discount: the factor by which a reward counts less for each later step.
        exploration: steps over which the probability of a random action falls from 1 to 0.05.
        seed: the seed of the random actions.
    """

    def __init__(
        self,
        states: int,
        actions: int,
        learning_rate: float = 0.05,
        discount: float = 0.99,
        exploration: int = 100_000,
        seed: int | None = None,
    ) -> None:
        self.q = [[0.0] * actions for _ in range(states)]
        self.learning_rate = learning_rate
        self.discount = discount
        self.epsilon = 1.0
        self._decay = 0.95 / exploration
        self._random = random.Random(seed)

    def select_action(self, observation: int) -> int:
        """The best action, or with probability epsilon a random one."""
        values = self.q[observation]
        if self._random.random() < self.epsilon:
            return self._random.randrange(len(values))
        return values.index(max(values))

    def train(self, observation: int, action: int, reward: float, new_observation: int) -> None:
        """Move Q(observation, action) towards the reward plus the discounted greatest Q of the new observation."""
        target = reward + self.discount * max(self.q[new_observation])
        self.q[observation][action] += self.learning_rate * (target - self.q[observation][action])
        self.epsilon = max(0.05, self.epsilon - self._decay)


def main(arguments: list[str] | None = None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "env",
        nargs="?",
        default="FrozenLake-v1",
        help="ID of an environment with Discrete spaces (default: %(default)s)",
    )
    parser.add_argument("--episodes", type=count, default=8_000, help="episodes to learn from (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="seed of environment and agent (default: %(default)s)")
    options = parser.parse_args(arguments)

    try:
        env = gymnasium.make(options.env)
    except gymnasium.error.Error as error:
        parser.error(str(error))
    states, actions = env.observation_space, env.action_space
    if not isinstance(states, gymnasium.spaces.Discrete) or not isinstance(actions, gymnasium.spaces.Discrete):
        parser.error(f"a table needs Discrete spaces, and {options.env} has {states} and {actions}; try FrozenLake-v1")
    env.reset(seed=options.seed)
    agent = QLearner(int(states.n), int(actions.n), seed=options.seed)
    part = max(1, options.episodes // 10)
    returns = []
    for episode in range(1, options.episodes + 1):
        returns.append(play_episode(env, agent))
        if episode % part == 0:
            print(
                f"{episode} episodes: mean return {statistics.mean(returns[-part:]):.3f}, epsilon {agent.epsilon:.2f}"
            )

    agent.epsilon = 0.0
    learned = evaluate(env, agent, 500)
    by_chance = evaluate(env, RandomAgent(actions, options.seed), 500)
    print(f"mean return over 500 episodes: {statistics.mean(learned):.3f}, random {statistics.mean(by_chance):.3f}")


if __name__ == "__main__":
    main()
