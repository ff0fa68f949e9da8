"""The loop around an agent: updates, log, checkpoints, and an end that loses nothing."""

import math
import time
import warnings
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path
from threading import Event
from typing import Any

import torch

from atari.learning.agent import Agent
from atari.learning.agents import find_agent
from atari.learning.environments import TrainingEnvironments
from atari.learning.options import TrainingOptions
from atari.learning.run import RunFolder

WINDOW = 100
"""The number of whole games whose mean is the score in the log."""


class Training:
    """A training in a run folder.

    A training stops after `total_steps`, at `stop_score`, when `stop` is set, or with an error. A training that is
    resumed ends with the same weights, to the bit (on one machine, without a GPU).
    """

    def __init__(self, folder: RunFolder, agent: Agent, options: TrainingOptions) -> None:
        self.folder = folder
        self.agent = agent
        self.options = options
        self.scores: deque[float] = deque(maxlen=WINDOW)
        self.frames: int = 0
        self.games = 0
        self.seconds = 0.0
        self._saved_at, self._saved_step = time.monotonic(), 0

    @classmethod
    def begin(cls, name: str, options: TrainingOptions, path: Path) -> "Training":
        """Begin a training in a new folder.

        Raises:
            FileExistsError: the folder is not empty.
            ValueError: an option is wrong.
        """
        torch.set_num_threads(1)
        TrainingEnvironments(options, 1).close()  # errors are raised before a folder is made
        folder = RunFolder.create(path)
        agent = find_agent(name)(options, path)
        folder.configure(name, options)
        return cls(folder, agent, options)

    @classmethod
    def resume(cls, path: Path) -> "Training":
        """Continue from the last checkpoint in a folder.

        Raises:
            FileNotFoundError, ValueError: the folder is no run folder, damaged, or of another version.
        """
        torch.set_num_threads(1)
        folder = RunFolder.open(path)
        options = read_options(folder)
        states = folder.load_checkpoints()
        agent = find_agent(folder.config["agent"])(options, path)
        training = cls(folder, agent, options)
        try:
            state = next(state for state in states if agent.fits(state["agent"]))
            agent.restore(state["agent"])
            training._restore(state)
        except (KeyError, TypeError, ValueError, RuntimeError, StopIteration) as error:
            agent.close()
            raise ValueError(f"{path / 'checkpoint.pt'} is damaged or of another version: {error}") from None
        folder.forget_rows_after(agent.steps)
        return training

    def run(self, stop: Event | None = None, progress: Callable[[int, float], None] = lambda steps, score: None) -> str:
        """Train until the end, and return its reason: "steps", "score" or "stop".

        Args:
            stop: an event that ends the training after the present update.
            progress: called after each update with the steps of the update and the mean score.

        Raises:
            FloatingPointError: the loss is not finite. The last checkpoint is kept.
        """
        options, agent = self.options, self.agent
        reason = self._reason(stop)
        while not reason:
            before, start = agent.steps, time.perf_counter()
            metrics = agent.update()
            self.seconds += time.perf_counter() - start
            if not math.isfinite(metrics["loss"]):
                raise FloatingPointError(
                    f"the loss is {metrics['loss']} at step {agent.steps:,}; the last checkpoint in {self.folder.path} "
                    "is good; try a smaller learning rate"
                )
            self._count_games()
            score = sum(self.scores) / len(self.scores) if self.scores else math.nan
            self.folder.log({**self._facts(score), **metrics})
            if agent.must_save or time.monotonic() - self._saved_at >= 60 * options.checkpoint_minutes:
                self.save()
            progress(agent.steps - before, score)
            reason = self._reason(stop)
        if self._saved_step != agent.steps:
            self.save()
        return reason

    def _reason(self, stop: Event | None) -> str:
        if self.agent.steps >= self.options.total_steps:
            return "steps"
        wanted = self.options.stop_score
        if wanted is not None and len(self.scores) == WINDOW and sum(self.scores) / WINDOW >= wanted:
            return "score"
        return "stop" if stop is not None and stop.is_set() else ""

    def _count_games(self) -> None:
        for environments in self.agent.environments:
            for score, _ in environments.take_games():
                self.scores.append(score)
                self.games += 1

    def _facts(self, score: float) -> dict[str, float]:
        low, high = self.options.task.frames
        return {
            "step": self.agent.steps,
            "frames": round(sum(range(low, high)) / (high - low) * self.agent.steps),
            "seconds": round(self.seconds, 3),
            "games": self.games,
            "score": score,
        }

    def save(self) -> None:
        """Write a checkpoint. If that fails, the last checkpoint is kept, and a warning is given."""
        self._saved_at, self._saved_step = time.monotonic(), self.agent.steps
        state = {
            "agent": self.agent.state(),
            "scores": list(self.scores),
            "games": self.games,
            "seconds": self.seconds,
        }
        try:
            self.folder.save_checkpoint(state, self.agent.network, self.agent.commit)
        except (OSError, RuntimeError) as error:  # torch raises RuntimeError for a full disk
            text = f"no checkpoint at step {self.agent.steps:,}, the one before stays: {error}"
            warnings.warn(text, RuntimeWarning, stacklevel=2)

    def _restore(self, state: Mapping[str, Any]) -> None:
        self.scores.extend(state["scores"])
        self.games, self.seconds = state["games"], state["seconds"]

    def close(self) -> None:
        """Release environments, threads and files."""
        self.agent.close()
        self.folder.close()


def read_options(folder: RunFolder) -> TrainingOptions:
    """The options in the configuration of a run folder.

    Raises:
        ValueError: the configuration is damaged.
    """
    task, given = folder.task, folder.config["options"]
    try:
        options: TrainingOptions = find_agent(folder.config["agent"]).options_class(task=task, **given)
    except (TypeError, AttributeError, ValueError) as error:
        raise ValueError(f"{folder.path / 'config.json'} is damaged: {error}") from None
    return options
