"""The IDs of the algorithmic tasks, with the step limits and thresholds that OpenAI Gym published."""

from typing import Any

import gymnasium
from gymnasium.envs.registration import EnvSpec

TASKS: dict[str, tuple[str, dict[str, Any], float]] = {
    "Copy-v0": ("CopyEnv", {}, 25.0),
    "DuplicatedInput-v0": ("DuplicatedInputEnv", {}, 9.0),
    "RepeatCopy-v0": ("RepeatCopyEnv", {}, 75.0),
    "Reverse-v0": ("ReverseEnv", {}, 25.0),
    "ReversedAddition-v0": ("ReversedAdditionEnv", {"rows": 2}, 25.0),
    "ReversedAddition3-v0": ("ReversedAdditionEnv", {"rows": 3}, 25.0),
}
"""For each ID the class, its options, and the mean return over 100 episodes in a row that solves the task."""


def register_all() -> None:
    """Put the IDs into Gymnasium's registry.

    Example:
        >>> import gymnasium
        >>> import atari  # which calls it
        >>> gymnasium.make("Copy-v0").observation_space
        Discrete(6)
    """
    for env_id, (name, options, threshold) in TASKS.items():
        # Not gymnasium.register(), which warns when it replaces an ID.
        gymnasium.registry[env_id] = EnvSpec(
            id=env_id,
            entry_point=f"atari.classic.algorithmic:{name}",
            kwargs=options,
            reward_threshold=threshold,
            max_episode_steps=200,
        )
