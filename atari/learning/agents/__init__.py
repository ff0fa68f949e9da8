"""The agents, one script each: read it from top to bottom, copy it, change it."""

from importlib import import_module
from typing import Any

AGENTS = {"ppo": "PPO", "pqn": "PQN", "dqn": "DQN"}
"""By name of the module, the class of the agent."""


def find_agent(name: str) -> Any:
    """The class of an agent: `options` is the class of its options, `fast` a dict of options found by measurement.

    Raises:
        ValueError: there is no such agent.
    """
    if name not in AGENTS:
        raise ValueError(f"agent must be one of {', '.join(AGENTS)}, got {name!r}")
    return getattr(import_module(f"{__name__}.{name}"), AGENTS[name])
