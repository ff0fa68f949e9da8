"""The agents, one script each, to read from top to bottom, to copy and to change."""

from importlib import import_module
from typing import Any

AGENTS = {"ppo": "PPO", "pqn": "PQN", "dqn": "DQN"}
"""The class of each agent by the name of its module."""


def find_agent(name: str) -> Any:
    """The class of an agent, a subclass of `Agent`.

    Raises:
        ValueError: no agent has this name.
    """
    if name not in AGENTS:
        raise ValueError(f"agent must be one of {', '.join(AGENTS)}, got {name!r}")
    return getattr(import_module(f"{__name__}.{name}"), AGENTS[name])
