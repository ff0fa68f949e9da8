"""`Training`, the loop around an `Agent`: updates, log, checkpoints, and an end that loses nothing."""

import dataclasses
import math
import time
import warnings
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path
from threading import Event
from typing import Any

import torch

from atari.learning.agent import Agent, AgentCode, agent_code, kept_agent, read_options
from atari.learning.environments import TrainingEnvironments
from atari.learning.logger import Logger
from atari.learning.options import PROGRAMS, WINDOW, TrainingOptions
from atari.learning.programs import program_of
from atari.learning.run_folder import RunFolder


class Training:
    """A training in a run folder.

    A training stops after `total_steps`, at `stop_score`, when `stop` is set, or with an error. A training that is
    resumed ends with the same weights, to the bit (on one machine, without a GPU).

    Attributes:
        folder: the run folder.
        agent: the agent.
        options: the options of the agent.
        scores: by game, the scores of the last 100 whole games; of fewer if not all environments are scored, so that
            the time that they span is the same.
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
        scored = [bool(one) for environments in agent.environments for one in environments.scored]
        window = max(1, round(WINDOW * sum(scored) / len(scored)))
        self.scores: dict[str, deque[float]] = {task.game: deque(maxlen=window) for task in options.tasks}
        self.games = 0
        self.seconds = 0.0
        self._saved_at, self._saved_step = time.monotonic(), -1
        self._mark = time.perf_counter(), 0
        self._stop: Event | None = None
        self._logger: Logger | None = None
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
        for name in PROGRAMS:
            if callable(values[name]):
                named = program_of(values[name])
                programs[name], values[name] = str(named), f"{name}.py:{named.name}"
        folder = RunFolder.begin(path, code.name, options.task, values, programs=programs)
        try:
            return cls(folder, code.kind(options, folder), options)
        except BaseException:
            folder.discard()
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
            RuntimeError: the agent's loop ended before the training, or a logger or intrinsic reward raised an error.
            TypeError: the option `logger` makes no object that can be called.
            OSError: the disk has no room for a checkpoint at the end, or for one that the replay memory needs to go
                on. The last checkpoint is kept.
        """
        if self.options.logger is not None and self._logger is None:
            self._logger = Logger(self.options.logger, self.folder)
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
            ValueError: a column of the intrinsic rewards has the name of another one.
        """
        self.seconds += time.perf_counter() - self._mark[0]
        self._count_games()
        self._check_finite(metrics["loss"])
        row = {**self._facts(), **{name: float(value) for name, value in metrics.items()}}
        row.update(self._intrinsic(row))
        self.folder.log(row)
        if self._logger is not None:
            self._logger.log(row)

    def _reason(self) -> str:
        if self.agent.steps >= self.options.total_steps:
            return "steps"
        wanted = self.options.stop_score
        known = all(len(scores) == scores.maxlen for scores in self.scores.values())
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
            **self._restarts(),
            **({} if len(self.scores) == 1 else {f"score_{game}": mean for game, mean in self._means().items()}),
        }

    def _restarts(self) -> dict[str, float]:
        """The number of restarts, and the median score of the snapshots from which environments restart."""
        found = [one.restarts for one in self.agent.environments if one.restarts is not None]
        if not found:
            return {}
        frontiers = [one.frontier for one in found if not math.isnan(one.frontier)]
        return {"restarts": sum(one.count for one in found), "frontier": max(frontiers, default=math.nan)}

    def _intrinsic(self, row: Mapping[str, float]) -> dict[str, float]:
        """The columns that the intrinsic rewards add to `row`, as means over the workers."""
        found = [one.intrinsic.take_columns() for one in self.agent.environments if one.intrinsic is not None]
        columns = {name: float(sum(one[name] for one in found) / len(found)) for name in (found or [{}])[0]}
        if twice := sorted(columns.keys() & row.keys()):
            raise ValueError(f"columns() of the intrinsic reward has {twice[0]!r}, a column of the log; rename it")
        return columns

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
        """Release environments, threads, logger and files."""
        self.agent.close()
        if self._logger is not None:
            self._logger.close()
        self.folder.close()
