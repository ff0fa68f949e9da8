"""`Agent`, which a training calls, and `AgentCode`: a class of this package, or of a user's file, that is an agent."""

import inspect
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar, Protocol

import torch

from atari.learning import agents
from atari.learning.agents import AGENTS, find_agent
from atari.learning.environments import TrainingEnvironments
from atari.learning.memory import ReplayMemory
from atari.learning.options import PROGRAMS, TrainingOptions
from atari.learning.programs import (
    Program,
    check_trusted,
    executed,
    is_program,
    module_of,
    named_in,
    program,
    program_of,
)
from atari.learning.run_folder import RunFolder

_OURS = Path(agents.__file__).parent


class TrainingLoop(Protocol):
    """The methods of `Training` that the loop of an agent calls.

    Example:
        >>> from atari.learning import TrainingLoop
        >>> def train(self, training: TrainingLoop) -> None:  # of an `Agent`
        ...     while training.goes_on():
        ...         training.log(self.update())
        ...         training.save_when_due()
    """

    def goes_on(self) -> bool:
        """Whether the agent shall make another update."""

    def log(self, metrics: Mapping[str, float]) -> None:
        """Add an update to the log."""

    def save_when_due(self) -> None:
        """Write a checkpoint if its time has come."""

    def save_for_memory(self) -> None:
        """Write the checkpoint without which the replay memory takes no further step."""


class Agent(ABC):
    """An agent: it plays in environments and learns from the steps.

    Attributes:
        options_class: the class of the options.
        fast: options found by measurement, for pixels, as `options_class.of` takes them.
        sample: whether the policy draws its actions; otherwise it takes the action with the highest score.
        steps: agent steps so far, of all environments together.
        network: the network with the weights; its method `scores` rates the actions, and `values`, if it has one, the
            states.
        environments: the environments that the agent plays.
        memory: a replay memory; None for an agent without one.

    Args:
        options: the options of the training.
        run: the folder of the training, which can have the file of a memory; None keeps a memory in main memory.

    Example:
        >>> from atari.learning import Agent
        >>> from atari.learning.agents.ppo import PPO, PPOOptions
        >>> issubclass(PPO, Agent), PPO.options_class is PPOOptions
        (True, True)
        >>> agent = PPO(PPOOptions.of("pong", num_envs=2, horizon=8, minibatch=16))  # without a folder
        >>> sorted(agent.update()), agent.steps
        (['entropy', 'kl', 'learning_rate', 'loss', 'value_loss'], 16)
        >>> agent.close()
    """

    options_class: ClassVar[type[TrainingOptions]]
    fast: ClassVar[Mapping[str, Any]]
    sample: ClassVar[bool] = False

    steps: int
    network: torch.nn.Module
    environments: Sequence[TrainingEnvironments]
    memory: ReplayMemory | None = None

    @abstractmethod
    def __init__(self, options: Any, run: RunFolder | None = None) -> None: ...

    @staticmethod
    @abstractmethod
    def make_network(options: Any, shape: tuple[int, ...], actions: int) -> torch.nn.Module:
        """The network for observations of a shape."""

    @abstractmethod
    def train(self, training: TrainingLoop) -> None:
        """Play and learn while `training.goes_on()`, and log and save by it."""

    @abstractmethod
    def state(self) -> dict[str, Any]:
        """Everything that the next update depends on, except a memory in the folder of the training."""

    @abstractmethod
    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from a state of `state`."""

    @abstractmethod
    def close(self) -> None:
        """Release environments, threads and memory."""


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


def kept_program(run: RunFolder, kind: str) -> tuple[ModuleType, Program] | None:
    """The module of a program that a run folder keeps, and the program; None if the run has none of this kind.

    Raises:
        PermissionError: the user does not trust the program.
        ValueError, FileNotFoundError: the copy is missing or changed, or cannot be executed.
    """
    entry = run.config.get("programs", {}).get(kind)
    if entry is None:
        return None
    file, source = run.program(kind), run.read_program(kind)
    check_trusted(file, entry["sha256"], str(Program(Path(entry["file"]), entry["name"])))
    return executed(file, source), Program(file, entry["name"])


def read_options(folder: RunFolder, *, to_train: bool = True) -> TrainingOptions:
    """The options of the agent in the configuration of a run folder.

    Args:
        folder: the run folder.
        to_train: execute the programs that a policy does without, an intrinsic reward and a logger; otherwise these
            options are None.

    Raises:
        ValueError: the configuration is damaged.
        FileNotFoundError, PermissionError, ValueError: see `kept_agent`.
    """
    task, given, kind = folder.task, folder.config["options"], kept_agent(folder).kind
    for name in PROGRAMS:
        if name != "network" and not to_train:
            given = {**given, name: None}
        elif (kept := kept_program(folder, name)) is not None:
            given = {**given, name: named_in(*kept)}
    try:
        options: TrainingOptions = kind.options_class(task=task, **given)
    except (TypeError, AttributeError, ValueError) as error:
        raise ValueError(f"{folder.path / 'config.json'} is damaged: {error}") from None
    return options


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
