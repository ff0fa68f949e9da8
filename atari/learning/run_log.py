"""The log of a training: `log.csv`, and TensorBoard's event files."""

import csv
import io
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from atari.files import durable
from atari.validation import check_file


class RunLog:
    """The log in a run folder. While a disk is full, rows are kept in memory."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._file = folder, folder / "log.csv"
        self._rows: list[Mapping[str, float]] = []
        self._columns: list[str] = []
        self._board: Any = None

    def add(self, row: Mapping[str, float]) -> None:
        """Add a row. The first row names the columns.

        Raises:
            ValueError: the row has other columns.
            TypeError: a value is no number.
        """
        if not self._columns:
            self._columns = list((read_rows(self._file) or [dict(row)])[0])
        if set(row) != set(self._columns):
            raise ValueError(f"a row of the log must have the columns {', '.join(self._columns)}, got {', '.join(row)}")
        for name, value in row.items():
            if not isinstance(value, (int, float, np.number, np.bool_)):
                raise TypeError(f"column {name!r} of the log takes a number, or math.nan for none, got {value!r}")
        self._rows.append(dict(row))
        try:
            empty = not self._file.exists() or not self._file.stat().st_size
            durable.append(self._file, _text(self._columns, self._rows, header=empty))
            self._rows.clear()
            self._add_to_board(row)
        except OSError as error:
            warnings.warn(f"the log is kept in memory until there is room: {error}", RuntimeWarning, stacklevel=3)

    def _add_to_board(self, row: Mapping[str, float]) -> None:
        if self._board is None:
            try:
                from torch.utils.tensorboard import SummaryWriter  # tensorboard takes a second to import
            except ImportError:
                self._board = False
            else:
                self._board = SummaryWriter(str(self._folder), purge_step=int(row["step"]))
        if self._board:
            for name, value in row.items():
                if name != "step" and np.isfinite(value):
                    self._board.add_scalar(name, value, int(row["step"]))

    def sync(self) -> None:
        """Wait until all rows are on the disk."""
        if self._file.exists():
            with self._file.open("r+b") as file:
                durable.sync(file.fileno())

    def forget_after(self, step: int) -> None:
        """Remove the rows of steps after `step`, and rows that a loss of power has damaged."""
        rows = [row for row in read_rows(self._file) if row["step"] <= step]
        durable.write_file(self._file, _text(list(rows[0]), rows, header=True) if rows else b"")

    def close(self) -> None:
        """Close TensorBoard's file."""
        if self._board:
            self._board.close()


def read_rows(file: Path) -> list[dict[str, float]]:
    """The rows of a log before the first damaged one. A warning names the damaged line.

    A loss of power can damage the rows that were added last.

    Raises:
        OSError: the file cannot be read.
    """
    if not file.exists():
        return []
    text = check_file(file).read_bytes().decode(errors="replace")
    lines = text.splitlines(keepends=True)
    columns = next(csv.reader(lines[:1]), [])
    rows: list[dict[str, float]] = []
    for number, line in enumerate(lines[1:], 2):
        try:
            if not line.endswith("\n"):
                raise ValueError("it has no end")
            values = [float(value) for value in line.split(",")]
            rows.append(dict(zip(columns, values, strict=True)))
        except ValueError:
            warnings.warn(f"{file} is damaged: line {number} and those after it are left out", RuntimeWarning, 2)
            break
    return rows if "step" in columns else []


def read_last_row(file: Path) -> dict[str, float]:
    """The last whole row of a log, also while a training writes into it; {} if there is none."""
    if not file.is_file():
        return {}
    with file.open("rb") as log:
        header = log.readline()
        log.seek(max(len(header), log.seek(0, io.SEEK_END) - 4096))
        lines = log.read().decode(errors="replace").split("\n")[:-1]
    columns = header.decode(errors="replace").strip().split(",")
    try:
        return dict(zip(columns, map(float, lines[-1].split(",")), strict=True)) if lines else {}
    except ValueError:
        return {}


def _text(columns: list[str], rows: list[Mapping[str, float]] | list[dict[str, float]], header: bool) -> bytes:
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    if header:
        writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().encode()
