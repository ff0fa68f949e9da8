"""The processes of a sweep: each training and each evaluation is a command in a process of its own."""

import os
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event
from typing import Any

from atari.base import durable
from atari.base.typed_table import in_text
from atari.learning.evaluation.protocols import EvaluationProtocol
from atari.learning.evaluation.results import Result
from atari.learning.run_folder import RunFolder
from atari.learning.run_log import read_last_row
from atari.learning.sweep.plan import Chosen, TrainingRun
from atari.task.fields import ROWS, TYPES
from atari.task.parser import flags_of

_POLL = 0.2
"""Seconds between two looks at the processes."""


@dataclass(frozen=True)
class Settings:
    """The settings of a sweep.

    Attributes:
        agent: the agent as a word of `atari train`.
        words: the options of all trainings, as words of `atari train`.
        games: whole games of the evaluation at the end of a training; 0 is none.
        protocol: the protocol of the evaluations that are compared.
        episodes: whole games of each evaluation.
        jobs: the number of processes at a time.
        command: the words that begin a command line of `atari`. The process must end when its stdin does.
    """

    agent: str
    words: tuple[str, ...]
    games: int
    protocol: EvaluationProtocol
    episodes: int
    jobs: int
    command: tuple[str, ...]


@dataclass
class Progress:
    """The progress of a run: `state` is "waiting", "training", "evaluating", "in use", "done" or "failed"."""

    run: TrainingRun
    state: str = "waiting"
    error: str = ""
    process: "subprocess.Popen[bytes] | None" = field(default=None, repr=False)
    last: tuple[str, ...] = ()

    @property
    def row(self) -> dict[str, float]:
        """The last row of the log."""
        return read_last_row(self.run.path / "log.csv")


def grid_words(chosen: Chosen) -> list[str]:
    """Values of a grid as words of `atari train`, such as "--gamma=0.99"."""
    return [word for name, value in chosen.items() for word in _words(name, in_text(value))]


def _words(name: str, text: str) -> list[str]:
    flag = flags_of(name)[0] if name in ROWS else f"--{name.replace('_', '-')}"
    if TYPES.get(name) is bool and text in ("true", "false"):
        return [flag if text == "true" else flag.replace("--", "--no-", 1)]
    return [f"{flag}={text}"]


def evaluation_file(run: TrainingRun, settings: Settings) -> Path:
    """The file of the evaluation of a run."""
    return run.path / f"evaluation-{settings.protocol.name}.json"


def evaluation_of(run: TrainingRun, settings: Settings) -> Result | None:
    """The evaluation of a run by the protocol of the sweep, if it is there and whole."""
    try:
        result = Result.load(evaluation_file(run, settings))
    except (FileNotFoundError, ValueError):
        return None
    fits = result.protocol == settings.protocol and len(result.games[0].scores) == settings.episodes
    return result if fits else None


def next_step(run: TrainingRun, settings: Settings) -> tuple[str, tuple[str, ...]]:
    """The state of a run, and the words of the command that it needs next; "done" needs none.

    Raises:
        FileNotFoundError, ValueError: the run folder is damaged.
    """
    train = ("train", "--games", str(settings.games))
    if not (run.path / "config.json").exists():
        own = (*grid_words(run.chosen), "--seed", str(run.options.seed), "-o", str(run.path))
        return "training", (*train, settings.agent, run.game, *settings.words, *own)
    complete = "ended" in RunFolder.open(run.path).config
    if not complete or (settings.games and not (run.path / "report.html").exists()):
        return "training", (*train, "--resume", str(run.path))
    if evaluation_of(run, settings) is None:
        how = ("--protocol", settings.protocol.name, "--episodes", str(settings.episodes))
        return "evaluating", ("evaluate", str(run.path), *how, "-o", str(evaluation_file(run, settings)))
    return "done", ()


def do_runs(
    runs: Sequence[TrainingRun], settings: Settings, stop: Event, show: Callable[[Sequence[Progress]], Any]
) -> list[Progress]:
    """Do what is left of all runs, `settings.jobs` at a time, until all are done or failed, or `stop` is set.

    A process that fails does not stop the others. When this process ends, however it ends, its processes save a
    checkpoint and end.

    Args:
        runs: the runs.
        settings: the settings.
        stop: an event that ends the sweep.
        show: called with the progress of all runs a few times a second.
    """
    every = [Progress(run) for run in runs]
    try:
        while not stop.is_set():
            for one in every:
                _look_after(one)
            for one in every:
                if one.process is None and one.state not in ("done", "failed"):
                    _start(one, settings, sum(other.process is not None for other in every) < settings.jobs)
            show(every)
            if all(one.state in ("done", "failed") for one in every):
                break
            stop.wait(_POLL)
    finally:
        for one in every:
            if one.process is not None and one.process.stdin is not None:
                one.process.stdin.close()
        for one in every:
            if one.process is not None:
                one.process.wait()
    return every


def _look_after(one: Progress) -> None:
    if one.process is None or one.process.poll() is None:
        return
    code = one.process.returncode
    if one.process.stdin is not None:
        one.process.stdin.close()
    one.process = None
    if code:
        one.state, one.error = "failed", _reason(_log_file(one.run), code)


def _start(one: Progress, settings: Settings, free: bool) -> None:
    """Start the next process of a run if a job is free, or note that the run is done."""
    try:
        state, words = next_step(one.run, settings)
    except (FileNotFoundError, ValueError) as error:
        one.state, one.error = "failed", str(error)
        return
    if not words:
        one.state = state
    elif _in_use(one.run.path):  # by processes of a sweep that was killed, which end soon, or by a training of its own
        one.state = "in use"
    elif words == one.last:
        one.state, one.error = "failed", f"`atari {' '.join(words)}` ended without a result"
    elif not free:
        one.state = "waiting"
    else:
        one.state, one.last = state, words
        own_group: dict[str, Any] = {"start_new_session": True}  # Ctrl-C ends this process, and this process the others
        if os.name == "nt":
            own_group = {"creationflags": getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)}
        with open(durable.open_to_append(_log_file(one.run)), "ab") as log:
            one.process = subprocess.Popen(
                [*settings.command, *words], stdin=subprocess.PIPE, stdout=log, stderr=log, **own_group
            )


def _in_use(path: Path) -> bool:
    if not (path / "lock").exists():
        return False
    try:
        lock = durable.lock_file(path / "lock", "")
    except BlockingIOError:
        return True
    durable.unlock(lock)
    lock.close()
    return False


def _log_file(run: TrainingRun) -> Path:
    return run.path.with_name(f"{run.name}.log")


def _reason(log: Path, code: int) -> str:
    """The reason why a process has failed: the last line of its output, or its exit code."""
    lines = log.read_bytes()[-10_000:].decode(errors="replace").split("\n")
    errors = [line for line in lines if line.startswith("atari: ") or ": error: " in line]
    if code < 0:
        return f"it was ended by signal {-code}; the same command goes on"
    return errors[-1].partition("error: ")[2] or errors[-1] if errors else f"exit code {code}; see {log}"
