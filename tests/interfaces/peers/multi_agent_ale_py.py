"""Multi-Agent-ALE, whose `ALEInterface` `atari.multiplayer` has: by the imported package alone, never by its source."""

import importlib.metadata

from interfaces import live
from interfaces.compare import Ours
from interfaces.facts import Versions

OURS = Ours({"multi_agent_ale_py": "atari.multiplayer"})


def facts() -> Versions:
    """The facts of the installed version."""
    live.require("multi_agent_ale_py", "multi-agent-ale-py==0.1.12")
    found = live.module_facts("multi_agent_ale_py", "multi_agent_ale_py")
    return live.versions(found, importlib.metadata.version("multi-agent-ale-py"))
