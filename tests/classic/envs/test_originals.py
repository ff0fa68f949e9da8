"""Classic control and toy text play the episodes of OpenAI Gym from the same seed.

`originals.json` has, for each ID, 600 steps of Gym 0.17.3 (with NumPy 1.23) after `env.seed(3)`: the first observations
of ten episodes, every 60th observation, the steps that ended an episode (twenty at most) and the sum of the rewards.
"""

import json
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atari.classic as gym

ORIGINALS = json.loads((Path(__file__).parent / "originals.json").read_text())


def flat(observation: Any) -> Any:
    return np.ravel(np.array(observation, np.float32))


@pytest.mark.parametrize("env_id", ORIGINALS)
def test_episodes_are_gyms(env_id: str) -> None:
    env, rng = gym.make(env_id), random.Random(1)
    env.seed(3)
    space: Any = env.action_space
    starts, seen, rewards, ends = [flat(env.reset())], [], 0.0, []
    for step in range(600):
        action = rng.randrange(space.n) if hasattr(space, "n") else np.array([rng.uniform(-1, 1)], np.float32)
        observation, reward, done, _ = env.step(action)
        rewards += float(reward)
        if step % 60 == 0:
            seen.append(flat(observation))
        if done:
            ends.append(step)
            starts.append(flat(env.reset()))
    expected = ORIGINALS[env_id]
    assert ends[:20] == expected["ends"]
    np.testing.assert_allclose(starts[:10], expected["starts"], atol=2e-4)
    np.testing.assert_allclose(seen, expected["seen"], atol=2e-4)
    assert rewards == pytest.approx(expected["rewards"], abs=2e-3)
