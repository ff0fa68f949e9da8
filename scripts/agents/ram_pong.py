#!/usr/bin/env python
"""Q-learning of Pong from its RAM, with a linear function of a few bytes.

`atari.games["pong"].ram_labels` has the bytes of ball and paddle. There are three features: the distance of the paddle
from the row in which the ball will arrive, the column of the ball, and its direction. Four shifted grids divide them
into tiles (tile coding: Sutton and Barto, "Reinforcement Learning", 2nd edition, section 9.5.4). Q is the sum of the
weights of the tiles that hold the features.

A random agent loses a game to 21 by about 20 points. This agent learns to be where the ball arrives, and so returns
most balls. It does not learn to aim: after the default 60 games it loses by 6 to 14 points with four seeds.
"""

import argparse
import random
import statistics
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

import gymnasium

import atari
from atari.wrappers import FrameStack

sys.path.insert(0, str(Path(__file__).parent))  # PYTHONSAFEPATH leaves it out
from loop import count, evaluate, play_episode
from random_agent import RandomAgent

ENV = "ALE/Pong-ram-v5"
MOVES = (0, 2, 3)
"""The actions that keep the paddle, and move it up and down; the three others also press fire."""

BALL_X, BALL_Y, PADDLE_Y = (atari.games["pong"].ram_labels[name].index for name in ("ball_x", "ball_y", "player_y"))

PADDLE_X, TOP, BOTTOM = 188, 44, 207
"""The column of the paddle and the rows of the walls, which turn the ball back, in the units of its bytes."""

GRIDS = 4
Tile = tuple[int, ...]


def make_pong() -> gymnasium.Env[Any, Any]:
    """Pong, whose observations are the RAM of the last step and of this one, (2, 128) uint8."""
    return FrameStack(gymnasium.make(ENV), 2)


def landing(x: int, y: int, right: int, down: int) -> float:
    """The row in which a ball reaches the paddle, reflected by the walls on its way; its own row if it flies away."""
    if right <= 0:
        return y
    height = BOTTOM - TOP
    flown = (y - TOP + down * (PADDLE_X - x) / right) % (2 * height)
    return TOP + min(flown, 2 * height - flown)


def tiles(observation: Any) -> list[Tile]:
    """The tile of each grid into which an observation falls."""
    (x_before, y_before, _), (x, y, paddle) = observation[:, [BALL_X, BALL_Y, PADDLE_Y]].tolist()
    right, down = x - x_before, y - y_before
    if abs(down) > 12:
        right = down = 0  # a new ball after a point
    below = max(-60, min(int(paddle - landing(x, y, right, down)), 60))
    towards = (right > 0) - (right < 0)
    return [(grid, (below + 2 * grid) // 8, (x + 10 * grid) // 40, towards) for grid in range(GRIDS)]


class LinearQLearner:
    """Q-learning whose Q(observation, action) is the sum of the action's weights in the tiles of the observation.

    Args:
        learning_rate: the part of the difference that each step corrects.
        discount: the factor by which a reward counts less for each later step.
        exploration: steps over which the probability of a random action falls from 0.3 to 0.01.
        seed: the seed of the random actions.
    """

    def __init__(
        self,
        learning_rate: float = 0.1,
        discount: float = 0.98,
        exploration: int = 25_000,
        seed: int | None = None,
    ) -> None:
        self.weights: defaultdict[Tile, list[float]] = defaultdict(lambda: [0.0] * len(MOVES))
        self.learning_rate = learning_rate
        self.discount = discount
        self.epsilon = 0.3
        self._decay = 0.29 / exploration
        self._random = random.Random(seed)

    def q(self, observation: Any) -> list[float]:
        """The values of the moves."""
        return [sum(weights) for weights in zip(*(self.weights[tile] for tile in tiles(observation)), strict=True)]

    def select_action(self, observation: Any) -> int:
        """The best move, or with probability epsilon a random one."""
        if self._random.random() < self.epsilon:
            return self._random.choice(MOVES)
        values = self.q(observation)
        return MOVES[values.index(max(values))]

    def train(self, observation: Any, action: int, reward: float, new_observation: Any) -> None:
        """Move Q(observation, action) towards the reward; if it is 0, towards the next discounted Q."""
        move = MOVES.index(action)
        target = reward if reward else self.discount * max(self.q(new_observation))
        difference = target - self.q(observation)[move]
        for tile in tiles(observation):
            self.weights[tile][move] += self.learning_rate / GRIDS * difference
        self.epsilon = max(0.01, self.epsilon - self._decay)


def main(arguments: list[str] | None = None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=count, default=60, help="games to learn from (default: %(default)s)")
    parser.add_argument("--games", type=count, default=20, help="games to play after it (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="seed of environment and agent (default: %(default)s)")
    options = parser.parse_args(arguments)

    env = make_pong()
    env.reset(seed=options.seed)
    agent = LinearQLearner(seed=options.seed)
    returns = []
    for episode in range(1, options.episodes + 1):
        returns.append(play_episode(env, agent))
        if episode % 10 == 0:
            print(f"{episode} games: {statistics.mean(returns[-10:]):.1f} points ahead, epsilon {agent.epsilon:.2f}")

    learned = evaluate(env, agent, options.games)
    by_chance = evaluate(env, RandomAgent(env.action_space, options.seed), options.games)
    means = f"{statistics.mean(learned):.1f}, random {statistics.mean(by_chance):.1f}"
    print(f"points ahead in {options.games} games: {means}")


if __name__ == "__main__":
    main()
