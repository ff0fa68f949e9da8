"""`RunFolder`: the files of a training, in one folder."""

import csv
import dataclasses
import io
import json
import os
import platform
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import torch

from atari.learning.evaluation.results import versions
from atari.learning.old_runs import migrated, with_stacks_in_task
from atari.learning.options import TrainingOptions
from atari.task import Task

FORMAT = 2
"""Version of the run folder. A newer one is refused; `migrated` turns the configuration of an older one into this."""


class RunFolder:
    """The folder of a training.

    - `config.json`: agent, task, options, versions;
    - `log.csv`: a row for each update, and TensorBoard's event files;
    - `checkpoint.pt`: the newest state of the training, with environments and generators (contains pickles);
    - `policy.pt`: the newest weights (contains none);
    - `best.a26`, `best.mp4`, `evaluation.json`, `report.html`: see `atari.learning.report`.

    A file is replaced only when its successor is complete. If a disk is full, rows of the log are kept in memory and
    written when the disk has room again.

    Attributes:
        path: the path of the folder.
        config: the contents of `config.json`, converted from older formats.
    """

    def __init__(self, path: Path, config: dict[str, Any]) -> None:
        self.path = path
        self.config = config
        self._rows: list[dict[str, Any]] = []
        self._columns: list[str] = []
        self._board: Any = None

    @classmethod
    def create(cls, path: Path) -> "RunFolder":
        """Make a new folder.

        Raises:
            FileExistsError: the folder has files.
        """
        if path.exists() and any(path.iterdir()):
            raise FileExistsError(f"{path} is not empty; give another folder, or continue with --resume {path}")
        path.mkdir(parents=True, exist_ok=True)
        return cls(path, {})

    def configure(self, agent: str, options: TrainingOptions) -> None:
        """Write `config.json`.

        Raises:
            ValueError: the task has a game without a file.
        """
        names = (field.name for field in dataclasses.fields(options) if field.name != "task")
        self.config = {
            "format": FORMAT,
            "agent": agent,
            "task": json.loads(options.task.to_json()),
            "options": {name: getattr(options, name) for name in names},
            "versions": {
                **versions(),
                "python": platform.python_version(),
                "machine": f"{platform.system()} {platform.machine()}",
            },
        }
        with replacing(self.path / "config.json") as file:
            file.write(json.dumps(self.config, indent=2).encode())

    @classmethod
    def open(cls, path: Path) -> "RunFolder":
        """Open the folder of a training.

        Raises:
            FileNotFoundError, ValueError: the folder is no run folder, damaged, or of another version.
        """
        file = path / "config.json"
        if not file.is_file():
            raise FileNotFoundError(f"{path} is no run folder: it has no config.json; `atari train` makes one")
        try:
            config = json.loads(file.read_text(encoding="utf-8"))
            version = config.get("format", 1)
        except (ValueError, AttributeError) as error:
            raise ValueError(f"{file} is damaged: {error!r}") from None
        if isinstance(version, bool) or version not in range(1, FORMAT + 1):
            raise ValueError(
                f"{file} has format {version!r}, and this atari-envs reads 1 to {FORMAT}; install a newer release"
            )
        try:
            config = migrated(config) if version == 1 else with_stacks_in_task(config)
            config["agent"], config["task"], config["options"].items(), config["versions"]
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise ValueError(f"{file} is damaged: {error!r}") from None
        return cls(path, config)

    @property
    def task(self) -> Task:
        """The task of the training.

        Raises:
            ValueError: the configuration is damaged, or its game file is gone.
        """
        try:
            return Task.from_json(json.dumps(self.config["task"]))
        except (TypeError, ValueError) as error:
            raise ValueError(f"{self.path / 'config.json'}: {error}") from None

    def log(self, row: Mapping[str, float]) -> None:
        """Add a row to `log.csv` and TensorBoard. The first row names the columns."""
        self._rows.append(dict(row))
        file = self.path / "log.csv"
        try:
            if not self._columns:
                self._columns = _header(file) or list(row)
            text = io.StringIO()
            writer = csv.DictWriter(text, self._columns, extrasaction="ignore", lineterminator="\n")
            if not file.exists() or not file.stat().st_size:
                writer.writeheader()
            writer.writerows(self._rows)
            append(file, text.getvalue().encode())
            self._rows.clear()
            self._log_to_board(row)
        except OSError as error:
            warnings.warn(f"the log is kept in memory until there is room: {error}", RuntimeWarning, stacklevel=2)

    def _log_to_board(self, row: Mapping[str, float]) -> None:
        if self._board is None:
            try:
                from torch.utils.tensorboard import SummaryWriter  # tensorboard takes a second to import
            except ImportError:
                self._board = False
            else:
                self._board = SummaryWriter(str(self.path), purge_step=int(row["step"]))
        if self._board:
            for name, value in row.items():
                if name != "step" and np.isfinite(value):
                    self._board.add_scalar(name, value, int(row["step"]))

    def rows(self) -> list[dict[str, float]]:
        """The rows of `log.csv`."""
        file = self.path / "log.csv"
        if not file.is_file():
            return []
        with file.open(newline="", encoding="utf-8") as text:
            try:
                return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(text)]
            except (TypeError, ValueError) as error:
                raise ValueError(f"{file} is damaged: {error}") from None

    def forget_rows_after(self, step: int) -> None:
        """Remove the rows of steps after `step`, which a resumed training plays again."""
        rows = [row for row in self.rows() if row["step"] <= step]
        with replacing(self.path / "log.csv") as file:
            if rows:
                text = io.StringIO()
                writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
                writer.writeheader()
                writer.writerows(rows)
                file.write(text.getvalue().encode())

    def save_checkpoint(self, state: dict[str, Any], network: torch.nn.Module, commit: Callable[[], None]) -> None:
        """Replace `checkpoint.pt` and `policy.pt`.

        `commit` is called when the new checkpoint is complete, and before it takes the place of the old one.

        Raises:
            OSError: the disk is full, for example; the files are unchanged.
        """
        with replacing(self.path / "checkpoint.pt", commit) as file:
            torch.save(state, file)
        with replacing(self.path / "policy.pt") as file:
            torch.save(network.state_dict(), file)

    def load_checkpoints(self) -> list[dict[str, Any]]:
        """The state in `checkpoint.pt`, and the state that was about to replace it if the training was killed.

        Their pickles are executed: open only folders that you trust.

        Raises:
            FileNotFoundError, ValueError: the file does not exist, or is damaged.
        """
        states = [dict(_load(self.path / "checkpoint.pt", weights_only=False))]
        with suppress(ValueError, FileNotFoundError):
            states.append(dict(_load(self.path / "checkpoint.pt.part", weights_only=False)))
        return states

    def load_weights(self) -> dict[str, torch.Tensor]:
        """The weights in `policy.pt`; nothing in the file is executed.

        Raises:
            FileNotFoundError, ValueError: the file does not exist, or is damaged.
        """
        return dict(_load(self.path / "policy.pt", weights_only=True))

    def close(self) -> None:
        """Write the rest of TensorBoard's events."""
        if self._board:
            self._board.close()


@contextmanager
def replacing(path: Path, commit: Callable[[], None] = lambda: None) -> Iterator[Any]:
    """A binary file that takes the place of `path` when the block ends without an error, after `commit`."""
    part = path.with_name(path.name + ".part")
    try:
        with part.open("wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        commit()
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def append(path: Path, data: bytes) -> None:
    """Add all of `data` to a file, or nothing.

    Raises:
        OSError: the disk is full, for example; the file is unchanged.
    """
    with path.open("ab", buffering=0) as file:
        size = file.seek(0, os.SEEK_END)
        try:
            if file.write(data) != len(data):
                raise OSError(f"no room for {len(data)} bytes in {path}")
        except OSError:
            file.truncate(size)
            raise


def _load(path: Path, weights_only: bool) -> Any:
    if not path.is_file():
        raise FileNotFoundError(f"{path} does not exist: the training was stopped before its first checkpoint")
    try:
        return torch.load(path, map_location="cpu", weights_only=weights_only)
    except OSError:
        raise
    except Exception as error:  # torch.load raises whatever a damaged file makes of its parsers
        raise ValueError(f"{path} is damaged: {error}") from None


def _header(file: Path) -> list[str]:
    if not file.is_file():
        return []
    with file.open(encoding="utf-8") as text:
        return [name for name in text.readline().strip().split(",") if name]
