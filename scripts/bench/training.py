#!/usr/bin/env python
"""Trains the same agent with the same seed on this package and on ale-py, and compares seconds and weights.

Pixels: `atari.AtariVectorEnv` beside ale-py's `AtariVectorEnv`, with equal options. RAM: `AtariVectorEnv` beside
Gymnasium's `SyncVectorEnv` of ale-py's environments, since ale-py has no vector of RAM. If the weights are equal to the
bit, the learning curves are the same.
"""

import argparse
import time
from typing import Any

import ale_py
import ale_py.env
import ale_py.vector_env
import numpy as np
import torch
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import atari
from atari.learning import environments
from atari.learning.agents import find_agent
from atari.learning.options import FAST_RAM
from atari.task import Task

SAME_STEP = AutoresetMode.SAME_STEP


class PlayedScores:
    """A vector environment that reports the sums of its rewards as scores, since ale-py's does not count games."""

    def __init__(self, envs: Any) -> None:
        self._envs = envs
        self.single_observation_space = envs.single_observation_space
        self._totals = np.zeros(envs.num_envs)
        self.seconds = 0.0

    def reset(self, seed: int) -> Any:
        """See `AtariVectorEnv.reset`."""
        return self._envs.reset(seed=seed)

    def step(self, actions: Any, out: Any = None) -> Any:
        """See `AtariVectorEnv.step`; `final_info` has the episode of each environment that has ended."""
        start = time.perf_counter()
        observations, rewards, terminations, truncations, info = self._envs.step(actions)
        self.seconds += time.perf_counter() - start
        self._totals += rewards
        ended = terminations | truncations
        final = {"_episode": ended, "episode": {"r": self._totals.copy(), "l": np.zeros(len(ended), np.int64)}}
        info = {"final_info": final, "final_obs": info.get("final_obs")} if ended.any() else {}
        self._totals[ended] = 0
        return observations, rewards, terminations, truncations, info

    def close(self) -> None:
        """Close the environments."""
        self._envs.close()


def make(side: str, task: Task, num_envs: int, threads: int) -> PlayedScores:
    """The environments of one side."""
    game = task.game
    if not task.kind.image:
        options: dict[str, Any] = {"repeat_action_probability": 0.0, "full_action_space": False}
        if side == "ale-py":

            def one() -> Any:
                return ale_py.env.AtariEnv(game, obs_type="ram", frameskip=4, **options)

            return PlayedScores(SyncVectorEnv([one] * num_envs, autoreset_mode=SAME_STEP))
        options |= {"noop_max": 0, "use_fire_reset": False, "reward_clipping": False, "obs_type": "ram"}
        return PlayedScores(
            atari.AtariVectorEnv(game, num_envs, num_threads=threads, autoreset_mode=SAME_STEP, **options)
        )
    size = {name: getattr(task, name) for name in ("img_height", "img_width", "stack_num")}
    kind = ale_py.vector_env.AtariVectorEnv if side == "ale-py" else atari.AtariVectorEnv
    return PlayedScores(kind(game, num_envs, autoreset_mode=SAME_STEP, num_threads=threads, **size))


def train(side: str, obs: str, game: str, steps: int, workers: int) -> tuple[float, float, list[float], dict[str, Any]]:
    """Train, and return all seconds, those of the environments' steps, the scores of games, and the weights."""
    made: list[PlayedScores] = []

    def vector(task: Task, num_envs: int, num_threads: int, **_: Any) -> PlayedScores:
        made.append(make(side, task, num_envs, num_threads))
        return made[-1]

    environments.AtariVectorEnv = vector  # type: ignore[assignment, misc]
    ppo = find_agent("ppo")
    options = {**ppo.fast, **(FAST_RAM if obs == "ram" else {}), "workers": workers, "total_steps": steps}
    agent = ppo(ppo.options_class.of(game, **options))
    scores: list[float] = []
    start = time.perf_counter()
    while agent.steps < steps:
        agent.update()
        for part in agent.environments:
            scores += [score for _, score, _ in part.take_games()]
    seconds = time.perf_counter() - start
    agent.close()
    return seconds, sum(envs.seconds for envs in made) / workers, scores, agent.network.state_dict()


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("game", nargs="?", default="pong")
    parser.add_argument("--obs", default="pixels", choices=("pixels", "ram"))
    parser.add_argument("--steps", type=int, default=65_536)
    parser.add_argument("--workers", type=int, default=2)
    args = parser.parse_args()
    torch.set_num_threads(1)
    results = {side: train(side, args.obs, args.game, args.steps, args.workers) for side in ("atari-envs", "ale-py")}
    for side, (seconds, in_steps, scores, _) in results.items():
        rate, mean = args.steps / seconds, np.mean(scores) if scores else np.nan
        print(f"{side:10} {seconds:6.1f} s, {rate:,.0f} steps/s, of it {in_steps:5.1f} s in the environments")
        print(f"{'':10} {len(scores)} games, mean score {mean:.2f}")
    ours, theirs = (results[side][3] for side in ("atari-envs", "ale-py"))
    equal = all(torch.equal(value, theirs[name]) for name, value in ours.items())
    training, played = (results["ale-py"][index] / results["atari-envs"][index] for index in (0, 1))
    print(f"weights {'equal to the bit' if equal else 'differ'}; training {training:.2f}x, environments {played:.1f}x")


if __name__ == "__main__":
    main()
