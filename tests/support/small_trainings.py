"""Trainings of about a second."""

import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from atari.cli import main
from atari.learning import RunFolder
from atari.learning.agents import find_agent
from atari.learning.options import FAST_RAM
from atari.learning.run_log import read_last_row

SUPPORT = str(Path(__file__).parent)
"""The folder of this module, for programs that import it."""

STEPS = 2048
"""The steps of a training that says no others: without them a training would take an hour."""

SMALL: dict[str, dict[str, Any]] = {
    "ppo": {"num_envs": 4, "horizon": 16, "minibatch": 32},
    "pqn": {"num_envs": 4, "horizon": 16, "minibatch": 32},
    "dqn": {"num_envs": 4, "memory": 8000, "learning_starts": 500, "train_every": 50, "batch": 16},
}
"""Small trainings, of about a second."""


def make_options(agent: str, game: Any = "pong", **given: Any) -> Any:
    found = find_agent(agent)
    ram = given.get("obs_type") == "ram"
    kind = FAST_RAM if ram else {"stack_num": 2}
    options = {**found.fast, **kind, "total_steps": STEPS, **SMALL[agent], **given}
    if agent == "dqn":  # it must learn before it ends
        options["learning_starts"] = min(options["learning_starts"], options["total_steps"] // 2)
    return found.options_class.of(game, **options)


def train(agent: str, options: Any, path: str | Path = "run") -> RunFolder:
    """The run of a whole training."""
    from atari.learning.training import Training  # here, because it imports PyTorch

    with closing(Training.begin(agent, options, Path(path))) as training:
        training.run()
    return RunFolder.open(path)


def user_without_trust(tmp_path: Path, patch: pytest.MonkeyPatch) -> None:
    """A user who has not yet trusted any program, and works in an empty folder."""
    patch.setattr("atari.learning.programs.user_data_path", lambda *_, **__: tmp_path / "data")
    patch.chdir(tmp_path)


class _Here:
    """In the place of a process of a sweep: its command runs in this one, which has imported PyTorch already."""

    def __init__(self, words: list[str], **_: object) -> None:
        self.stdin, self.returncode = None, main(words[3:])  # after `python -m atari.cli.sweep`

    def poll(self) -> int:
        return self.returncode


def sweep_in_this_process(patch: pytest.MonkeyPatch) -> None:
    """Let sweeps start no processes."""
    patch.setattr("atari.learning.sweep.processes.subprocess", SimpleNamespace(Popen=_Here, PIPE=None))


def kill_after_a_row(words: list[str], log: Path, seconds: float = 120) -> None:
    """Run `atari` with some words, and kill it when a log has a row."""
    process = subprocess.Popen([sys.executable, "-m", "atari", *words], stdout=subprocess.DEVNULL)
    end = time.monotonic() + seconds
    while not read_last_row(log):
        assert time.monotonic() < end
        time.sleep(0.02)
    process.kill()
    process.wait()
