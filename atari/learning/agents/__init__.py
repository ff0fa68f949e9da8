"""The agents, one script each, to read from top to bottom, to copy and to change."""

import sys
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from atari.base.extras import install_extra
from atari.base.start import PROGRAM

AGENTS = {"ppo": "PPO", "pqn": "PQN", "dqn": "DQN"}
"""The class of each agent by the name of its module."""

if PROGRAM and sys.argv[:1] == ["-m"] and find_spec("torch") is None:  # `python -m` is about to run a module here
    sys.exit(f"atari: error: the agents need torch: {install_extra('learn')}")


def find_agent(name: str) -> Any:
    """The class of an agent, a subclass of `Agent`.

    Raises:
        ValueError: no agent has this name.
    """
    if name not in AGENTS:
        raise ValueError(f"agent must be one of {', '.join(AGENTS)}, got {name!r}")
    return getattr(import_module(f"{__name__}.{name}"), AGENTS[name])
