"""`AgentCode`: the class of an agent, one of this package or of a Python file of your own."""

import inspect
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from atari.learning import agents
from atari.learning.agent import Agent
from atari.learning.agents import AGENTS, find_agent
from atari.learning.programs import Program, is_program, kept_program, module_of, program, program_of
from atari.learning.run import RunFolder

_OURS = Path(agents.__file__).parent


@dataclass(frozen=True)
class AgentCode:
    """The class of an agent.

    Attributes:
        name: a name of `atari.learning.agents.AGENTS`, or the name of the file without `.py`.
        kind: the class.
        program: its file and name; None for an agent of this package.
    """

    name: str
    kind: type[Agent]
    program: Program | None = None


def agent_code(agent: str | Path | type[Agent]) -> AgentCode:
    """An agent by the name of one of this package, by the path of a file, or by its class.

    Args:
        agent: a name; `FILE.py`, or `FILE.py:CLASS` if the file has several agents, which is executed; or a class that
            stands in a file.

    Raises:
        FileNotFoundError: the file does not exist.
        TypeError: the class is no agent.
        ValueError: no agent has this name; the file cannot be executed, or has no agent; the class stands in no file.
    """
    if isinstance(agent, type):
        return _of_class(agent)
    text = str(agent)
    if text in AGENTS:
        return AgentCode(text, find_agent(text))
    if not is_program(text):
        raise ValueError(f"agent must be one of {', '.join(AGENTS)}, or a Python file such as my_ppo.py, got {text!r}")
    named = program(text)
    kind = _class_in(module_of(named.file), named)
    return AgentCode(named.file.stem, kind, Program(named.file.absolute(), kind.__name__))


def kept_agent(run: RunFolder) -> AgentCode:
    """The agent of a run folder.

    Raises:
        PermissionError: the run has a program of its own, which the user does not trust.
        ValueError, FileNotFoundError: the program is missing, changed or for another release, or has no agent.
    """
    name, kept = run.config["agent"], kept_program(run, "agent")
    if kept is not None:
        return AgentCode(name, _class_in(*kept), kept[1])
    if name not in AGENTS:
        raise ValueError(
            f"agent must be one of {', '.join(AGENTS)}, got {name!r} in {run.path / 'config.json'}; "
            "a policy of a loop of your own is named MODULE:NAME, such as my_policy:policy, see docs/runs.md"
        )
    return AgentCode(name, find_agent(name))


def _of_class(kind: type) -> AgentCode:
    if not issubclass(kind, Agent) or inspect.isabstract(kind):
        missing = ", ".join(sorted(getattr(kind, "__abstractmethods__", ())))
        raise TypeError(
            f"an agent is a class derived from atari.learning.Agent with all its methods, got {kind.__name__}"
            + (f" without {missing}" if missing else "")
        )
    named = program_of(kind)
    if named.file.parent == _OURS and named.file.stem in AGENTS:  # also if it runs as `python -m`
        return AgentCode(named.file.stem, kind)
    return AgentCode(named.file.stem, kind, named)


def _class_in(module: ModuleType, named: Program) -> type[Agent]:
    """The class that a program names, or the only agent that its file defines."""
    found = {
        key: value
        for key, value in vars(module).items()
        if isinstance(value, type) and issubclass(value, Agent) and value.__module__ == module.__name__
    }
    bases = {base for value in found.values() for base in value.__bases__}
    leaves = {key: value for key, value in found.items() if value not in bases}
    if named.name:
        leaves = {named.name: found[named.name]} if named.name in found else {}
    if not leaves:
        wanted = f"no agent {named.name}" if named.name else "no agent: no class derived from atari.learning.Agent"
        raise ValueError(f"{named.file} has {wanted}")
    if len(leaves) > 1:
        raise ValueError(f"{named.file} has several agents; name one of them, as in {named.file}:{next(iter(leaves))}")
    (kind,) = leaves.values()
    if inspect.isabstract(kind):
        missing = ", ".join(sorted(kind.__abstractmethods__))
        raise ValueError(
            f"{kind.__name__} in {named.file} lacks {missing}; it may be for another release of atari-envs"
        )
    return kind
