"""Scripts of OpenAI Gym's time (`old_gym/`), by `python -m atari.classic`, against ale-py and against Gym itself.

Scripts of Atari games print digests, which plain loops over ale-py's environment have too. Scripts of toy text and classic
control print what they printed under Gym 0.17.3.
"""

import hashlib
import os
import random
import subprocess
import sys
from collections import deque
from pathlib import Path
from typing import Any

import ale_py
import cv2
import numpy as np
import pytest

from atari.classic.utils import seeding

pytestmark = pytest.mark.peers
SCRIPTS = Path(__file__).parent / "old_gym"


def printed(name: str, *arguments: str) -> list[str]:
    result = subprocess.run(
        [sys.executable, "-m", "atari.classic", str(SCRIPTS / f"{name}.py"), *arguments],
        capture_output=True,
        text=True,
        env={**os.environ, "SDL_VIDEODRIVER": "dummy"},
        timeout=600,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout.splitlines()


def ale_env(game: str, frameskip: int = 1) -> Any:
    return ale_py.AtariEnv(game, frameskip=frameskip, repeat_action_probability=0.0)


class Chain:
    """The chain of `baselines_chain.py` as one class over ale-py's environment."""

    def __init__(self, game: str, seed: int) -> None:
        self.env = ale_env(game)
        self.seed: int | None = seed
        self.draws = seeding.np_random(seed)[0]
        self.counts: list[int] = []
        self.over, self.lives = True, 0
        self.last: deque[Any] = deque(maxlen=2)
        self.frames: deque[Any] = deque(maxlen=4)

    def reset(self) -> None:
        if self.over:
            self.env.reset(seed=self.seed)
            self.seed = None
            self.counts.append(self.draws.randint(1, 31))
            for _ in range(self.counts[-1]):
                self.env.step(0)
        else:
            self._skip(0)
        self.lives = self.env.ale.lives()
        self._step(1)
        self.frames.extend([self._small()] * 4)

    def step(self, action: int) -> tuple[float, bool]:
        reward, done = self._step(action)
        self.frames.append(self._small())
        return float(np.sign(reward)), done

    def observation(self) -> bytes:
        return np.stack(self.frames, axis=2).tobytes()

    def _step(self, action: int) -> tuple[float, bool]:
        reward, self.over = self._skip(action)
        lives = self.env.ale.lives()
        done = self.over or 0 < lives < self.lives
        self.lives = lives
        return reward, done

    def _skip(self, action: int) -> tuple[float, bool]:
        total, over = 0.0, False
        for _ in range(4):
            observation, reward, over, _, _ = self.env.step(action)
            self.last.append(observation)
            total += reward
            if over:
                break
        return total, over

    def _small(self) -> Any:
        gray = cv2.cvtColor(np.max(np.stack(self.last), axis=0), cv2.COLOR_RGB2GRAY)
        return cv2.resize(gray, (84, 84), interpolation=cv2.INTER_AREA)


@pytest.mark.parametrize("game", ["breakout", "assault", "seaquest"])
def test_the_chain_of_baselines(game: str) -> None:
    env_id = f"{game.title()}NoFrameskip-v4"
    chain, rng, digest = Chain(game, 3), random.Random(3), hashlib.sha256()
    chain.reset()
    ends, total = 0, 0.0
    actions = chain.env.action_space.n
    for _ in range(700):
        digest.update(chain.observation())
        reward, done = chain.step(rng.randrange(actions))
        total += reward
        if done:
            ends += 1
            chain.reset()
    assert printed("baselines_chain", env_id, "3", "700") == [f"{chain.counts} {ends} {total} {digest.hexdigest()}"]


@pytest.mark.parametrize("game", ["ms_pacman", "freeway"])
def test_planning_by_saved_states(game: str) -> None:
    env, rng = ale_env(game, 5), random.Random(5)
    env.reset(seed=5)
    actions = env.action_space.n
    chosen, total = [], 0.0
    for _ in range(15):
        state = env.clone_state(include_rng=True)
        returns = []
        for action in range(actions):
            path = [action, *(None for _ in range(8))]
            returns.append(sum(env.step(rng.randrange(actions) if a is None else a)[1] for a in path))
            env.restore_state(state)
        chosen.append(int(np.argmax(returns)))
        total += env.step(chosen[-1])[1]
    ram, image = int(env.ale.getRAM().sum()), int(env.ale.getScreenRGB().sum())
    assert printed("planner", game) == [f"{chosen} {total} {ram} {image}"]


def test_a_vector_of_wrapped_games() -> None:
    envs = [ale_env("breakout") for _ in range(3)]
    rng, digest = random.Random(0), hashlib.sha256()

    def small(observation: Any) -> Any:
        return cv2.cvtColor(cv2.resize(observation, (84, 84), interpolation=cv2.INTER_AREA), cv2.COLOR_RGB2GRAY)

    stacks = [deque([small(env.reset(seed=seed)[0])] * 4, maxlen=4) for seed, env in enumerate(envs)]
    scores, returns = [[0.0, 0] for _ in envs], []
    for _ in range(1500):
        digest.update(np.array(stacks).tobytes())
        for env, stack, score, action in zip(envs, stacks, scores, [rng.randrange(4) for _ in envs], strict=True):
            observation, reward, over, _, _ = env.step(action)
            stack.append(small(observation))
            score[0] += reward
            score[1] += 1
            if over:
                digest.update(np.array(stack).tobytes())
                returns.append(tuple(score))
                score[:] = [0.0, 0]
                stack.extend([small(env.reset()[0])] * 4)
    assert len(returns) > 3
    assert printed("vector_chain", "1500") == [f"{returns} {digest.hexdigest()}"]


def test_value_iteration_prints_as_under_gym() -> None:
    assert printed("lake") == ["FrozenLakeNotSlippery-v0 1.0 1.0", "FrozenLake8x8-v0 0.8778 0.86"]


def test_q_learning_and_a_monitor_print_as_under_gym(tmp_path: Path) -> None:
    assert printed("taxi", str(tmp_path)) == [
        "-16622 -442 [0, 0, 0, 0]",
        "200 [155, 200, 40, 61, 10, 10, 8, 200, 36, 9, 135, 58, 9, 9, 10, 24, 9, 99, 60, 33, 9, 9, 9, 9, 74, 65, 9, 10, "
        "24, 27] True",
    ]
