"""`Training`, the loop around an `Agent`: updates, log, checkpoints, and an end that loses nothing.

`AgentCode` is the class of an agent: one of this package, or of a Python file of your own.
"""

import dataclasses
import inspect
import math
import time
import warnings
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from types import ModuleType
from typing import Any, ClassVar

import torch

from atari.learning import agents
from atari.learning.agents import AGENTS, find_agent
from atari.learning.environments import TrainingEnvironments
from atari.learning.memory import ReplayMemory
from atari.learning.options import TrainingOptions
from atari.learning.programs import Program, executed, is_program, module_of, named_in, program, program_of
from atari.learning.run import RunFolder
from atari.learning.trust import check_trusted

WINDOW = 100
"""The number of whole games whose mean is the score in the log."""

_OURS = Path(agents.__file__).parent


class Agent(ABC):
    """An agent: it plays in environments and learns from the steps.

    Attributes:
        options_class: the class of the options.
        fast: options found by measurement, for pixels, as `options_class.of` takes them.
        sample: whether the policy draws its actions; otherwise it takes the action with the highest score.
        steps: agent steps so far, of all environments together.
        network: the network with the weights; its method `scores` rates the actions.
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
    def train(self, training: "Training") -> None:
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


class Training:
    """A training in a run folder.

    A training stops after `total_steps`, at `stop_score`, when `stop` is set, or with an error. A training that is
    resumed ends with the same weights, to the bit (on one machine, without a GPU).

    Attributes:
        folder: the run folder.
        agent: the agent.
        options: the options of the agent.
        scores: by game, the scores of the last 100 whole games.
        games: the number of whole games so far.
        seconds: the seconds of the updates so far.

    Example:
        >>> from pathlib import Path
        >>> from atari.learning import Training
        >>> from atari.learning.agents.ppo import PPOOptions
        >>> options = PPOOptions.of("pong", num_envs=2, horizon=8, minibatch=16, epochs=1, total_steps=32)
        >>> training = Training.begin("ppo", options, Path("runs/short"))
        >>> training.run(), training.agent.steps
        ('steps', 32)
        >>> training.close()
    """

    def __init__(self, folder: RunFolder, agent: Agent, options: TrainingOptions) -> None:
        self.folder = folder
        self.agent = agent
        self.options = options
        self.scores: dict[str, deque[float]] = {task.game: deque(maxlen=WINDOW) for task in options.tasks}
        self.games = 0
        self.seconds = 0.0
        self._saved_at, self._saved_step = time.monotonic(), -1
        self._mark = time.perf_counter(), 0
        self._stop: Event | None = None
        self._progress: Callable[[int, float], None] = lambda steps, score: None

    @classmethod
    def begin(cls, agent: str | Path | type[Agent] | AgentCode, options: TrainingOptions, path: Path) -> "Training":
        """Begin a training in a new folder.

        Args:
            agent: "ppo", "pqn" or "dqn"; the path of a Python file with an agent; or an agent's class. The folder keeps
                a copy of a file of your own, and later loads the agent from it.
            options: the options, of the agent's `options_class`.
            path: the folder.

        Raises:
            FileExistsError: the folder is not empty.
            FileNotFoundError: there is no such file.
            BlockingIOError: another training has just begun in it.
            TypeError: the class is no agent, or the options are of another agent.
            ValueError: an option is wrong, or the file has no agent.
        """
        code = agent if isinstance(agent, AgentCode) else agent_code(agent)
        if not isinstance(options, code.kind.options_class):
            wanted, given = code.kind.options_class.__name__, type(options).__name__
            raise TypeError(
                f"{code.kind.__name__} takes options of {wanted}, got {given}; {wanted}.of(GAME) makes them"
            )
        torch.set_num_threads(1)
        _ = options.torch_device  # its errors are raised before a folder is made
        environments = TrainingEnvironments(options, 1)
        code.kind.make_network(options, environments.shape, len(environments.actions))
        environments.close()
        values = {field.name: getattr(options, field.name) for field in dataclasses.fields(options)}
        del values["task"]
        programs = {} if code.program is None else {"agent": str(code.program)}
        if not isinstance(options.network, str):
            network = program_of(options.network)
            programs["network"], values["network"] = str(network), f"network.py:{network.name}"
        folder = RunFolder.begin(path, code.name, options.task, values, programs=programs)
        try:
            return cls(folder, code.kind(options, folder), options)
        except BaseException:
            folder.close()
            raise

    @classmethod
    def resume(cls, path: Path) -> "Training":
        """Continue from the last checkpoint in a folder.

        Raises:
            FileNotFoundError, ValueError: the folder is no run folder, damaged, or of another version.
            PermissionError: the run has a program of its own that the user does not trust.
            BlockingIOError: a training writes into the folder.
        """
        torch.set_num_threads(1)
        opened = RunFolder.open(path)
        kind, options = kept_agent(opened).kind, read_options(opened)
        folder = RunFolder.resume(path, num_threads=options.workers)
        agent = None
        try:
            agent = kind(options, folder)
            training = cls(folder, agent, options)
            if folder.state is not None:
                training._restore(folder.state)
        except BaseException as error:
            if agent is not None:
                agent.close()
            folder.close()
            if isinstance(error, (KeyError, TypeError, ValueError, RuntimeError)):
                raise ValueError(f"{path / 'checkpoint.pt'} is damaged or of another version: {error!r}") from None
            raise
        return training

    def run(self, stop: Event | None = None, progress: Callable[[int, float], None] = lambda steps, score: None) -> str:
        """Train until the end, and return its reason: "steps", "score" or "stop".

        Args:
            stop: an event that ends the training after the present update.
            progress: called after each update with the steps of the training so far, as in the log, and the mean score
                of the last 100 games, NaN before the first.

        Raises:
            FloatingPointError: the loss is not finite. The last checkpoint is kept.
            RuntimeError: the agent's loop ended before the training.
            OSError: the disk has no room for a checkpoint at the end, or for one that the replay memory needs to go
                on. The last checkpoint is kept.
        """
        self._stop, self._progress, self._mark = stop, progress, (time.perf_counter(), self.agent.steps)
        self.agent.train(self)
        if self._saved_step != self.agent.steps:
            self.save()
        reason = self._reason()
        if not reason:
            raise RuntimeError(
                f"{type(self.agent).__name__}.train ended at step {self.agent.steps:,}, before the training"
            )
        if reason != "stop":
            self.folder.end(reason, keep_memory=getattr(self.options, "keep_memory", False))
        return reason

    def goes_on(self) -> bool:
        """Whether the agent shall make another update. Shows the progress of the last one."""
        _, steps = self._mark
        if self.agent.steps > steps:
            self._progress(self.agent.steps, self._score())
        self._mark = time.perf_counter(), self.agent.steps
        return not self._reason()

    def log(self, metrics: Mapping[str, float]) -> None:
        """Add an update to the log, with the facts of the training: steps, frames, seconds, games and their score.

        Args:
            metrics: the columns of the agent, `loss` among them.

        Raises:
            FloatingPointError: the loss is not finite. The last checkpoint is kept.
        """
        self.seconds += time.perf_counter() - self._mark[0]
        self._count_games()
        self._check_finite(metrics["loss"])
        self.folder.log({**self._facts(), **{name: float(value) for name, value in metrics.items()}})

    def _reason(self) -> str:
        if self.agent.steps >= self.options.total_steps:
            return "steps"
        wanted = self.options.stop_score
        known = all(len(scores) == WINDOW for scores in self.scores.values())
        if wanted is not None and known and self._score() >= wanted:
            return "score"
        return "stop" if self._stop is not None and self._stop.is_set() else ""

    def _count_games(self) -> None:
        for environments in self.agent.environments:
            for game, score, _ in environments.take_games():
                self.scores[game].append(score)
                self.games += 1

    def _check_finite(self, loss: float) -> None:
        if math.isfinite(loss):
            return
        saved = self._saved_step >= 0
        last = f"the last checkpoint in {self.folder.path} is good" if saved else "there is no checkpoint yet"
        raise FloatingPointError(
            f"the loss is {loss} at step {self.agent.steps:,}; {last}; try a smaller learning rate, "
            f"{self.options.learning_rate / 4:g} for example"
        )

    def _means(self) -> dict[str, float]:
        """By game, the mean of the last whole games; NaN before the first."""
        return {game: sum(scores) / len(scores) if scores else math.nan for game, scores in self.scores.items()}

    def _score(self) -> float:
        """The mean of the games' means; NaN before the first whole game."""
        known = [mean for mean in self._means().values() if not math.isnan(mean)]
        return sum(known) / len(known) if known else math.nan

    def _facts(self) -> dict[str, float]:
        low, high = self.options.task.frames
        return {
            "step": self.agent.steps,
            "frames": round(sum(range(low, high)) / (high - low) * self.agent.steps),
            "seconds": round(self.seconds, 3),
            "games": self.games,
            "score": self._score(),
            **({} if len(self.scores) == 1 else {f"score_{game}": mean for game, mean in self._means().items()}),
        }

    def save_when_due(self) -> None:
        """Write a checkpoint if its time has come. If that fails, the last checkpoint is kept, with a warning."""
        if time.monotonic() - self._saved_at < 60 * self.options.checkpoint_minutes:
            return
        try:
            self.save()
        except OSError as error:
            self._saved_at = time.monotonic()
            text = f"no checkpoint at step {self.agent.steps:,}, the one before stays: {error}"
            warnings.warn(text, RuntimeWarning, stacklevel=3)

    def save_for_memory(self) -> None:
        """Write the checkpoint without which the replay memory takes no further step.

        Raises:
            OSError: the disk has no room for it. The last checkpoint is kept.
        """
        start, steps = self._mark
        self.seconds += time.perf_counter() - start
        self._count_games()
        try:
            self.save()
        except OSError as error:
            text = (
                f"{error.strerror}: the replay memory needs a checkpoint at step {self.agent.steps:,}, and the last "
                f"one is kept; make room, and go on with `atari train --resume {self.folder.path}`"
            )
            raise OSError(error.errno, text) from None
        self._mark = time.perf_counter(), steps

    def save(self) -> None:
        """Write a checkpoint.

        Raises:
            OSError: the disk is full, for example; the last checkpoint is kept.
        """
        state = {
            "agent": self.agent.state(),
            "scores": {game: list(scores) for game, scores in self.scores.items()},
            "games": self.games,
            "seconds": self.seconds,
        }
        self.folder.checkpoint(self.agent.steps, state, self.agent.network.state_dict(), self.agent.memory)
        self._saved_at, self._saved_step = time.monotonic(), self.agent.steps

    def _restore(self, state: Mapping[str, Any]) -> None:
        self.agent.restore(state["agent"])
        for game, scores in state["scores"].items():
            self.scores[game].extend(scores)
        self.games, self.seconds = state["games"], state["seconds"]
        self._saved_step = self.agent.steps

    def close(self) -> None:
        """Release environments, threads and files."""
        self.agent.close()
        self.folder.close()


def read_options(folder: RunFolder) -> TrainingOptions:
    """The options of the agent in the configuration of a run folder.

    Raises:
        ValueError: the configuration is damaged.
        FileNotFoundError, PermissionError, ValueError: see `kept_agent`.
    """
    task, given, kind = folder.task, folder.config["options"], kept_agent(folder).kind
    network = kept_program(folder, "network")
    if network is not None:
        given = {**given, "network": named_in(*network)}
    try:
        options: TrainingOptions = kind.options_class(task=task, **given)
    except (TypeError, AttributeError, ValueError) as error:
        raise ValueError(f"{folder.path / 'config.json'} is damaged: {error}") from None
    return options
