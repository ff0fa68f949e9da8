"""The log of a training: `log.csv`, and TensorBoard's event files."""

import csv
import io
import os
import socket
import time
import warnings
from collections.abc import Mapping
from itertools import count
from pathlib import Path

import numpy as np

from atari.base import durable
from atari.base.validation import check_file

_NUMBERS = count()  # of the files of this process


class RunLog:
    """The log in a run folder. While a disk is full, rows are kept in memory."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._file = folder, folder / "log.csv"
        self._rows: list[Mapping[str, float]] = []
        self._columns: list[str] = []
        self._events = _EventFile(folder)

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
        self._events.add(row)
        try:
            empty = not self._file.exists() or not self._file.stat().st_size
            durable.append(self._file, _text(self._columns, self._rows, header=empty))
            self._rows.clear()
            self._events.write()
        except OSError as error:
            warnings.warn(f"the log is kept in memory until there is room: {error}", RuntimeWarning, stacklevel=3)

    def sync(self) -> None:
        """Wait until all rows are on the disk."""
        if self._file.exists():
            with self._file.open("r+b") as file:
                durable.sync(file.fileno())

    def forget_after(self, step: int) -> None:
        """Remove the rows of steps after `step`, and rows that a loss of power has damaged."""
        rows = [row for row in read_rows(self._file) if row["step"] <= step]
        durable.write_file(self._file, _text(list(rows[0]), rows, header=True) if rows else b"")


class _EventFile:
    """TensorBoard's file of events. TensorBoard's own writer drops all events after a full disk, and cuts the last."""

    def __init__(self, folder: Path) -> None:
        name = f"events.out.tfevents.{time.time():010.0f}.{socket.gethostname()}.{os.getpid()}.{next(_NUMBERS)}"
        self._file = folder / name
        self._waiting = io.BytesIO()
        self._empty = True

    def add(self, row: Mapping[str, float]) -> None:
        """Add the values of a row to the events that wait; without effect if TensorBoard is not installed."""
        try:
            from tensorboard.compat.proto.event_pb2 import Event, SessionLog  # tensorboard takes a second to import
            from tensorboard.compat.proto.summary_pb2 import Summary
            from tensorboard.summary.writer.record_writer import RecordWriter
        except ImportError:
            return
        now, step = time.time(), int(row["step"])
        values = [
            Summary.Value(tag=name, simple_value=value)
            for name, value in row.items()
            if name != "step" and np.isfinite(value)
        ]
        events = [Event(wall_time=now, step=step, summary=Summary(value=values))]
        if self._empty:  # the second event makes TensorBoard drop what an earlier file has from this step on
            start = SessionLog(status=SessionLog.START)
            events[:0] = [
                Event(wall_time=now, step=step, file_version="brain.Event:2"),
                Event(wall_time=now, step=step, session_log=start),
            ]
            self._empty = False
        writer = RecordWriter(self._waiting)
        for event in events:
            writer.write(event.SerializeToString())

    def write(self) -> None:
        """Write the events that wait.

        Raises:
            OSError: the disk is full, for example; the events wait.
        """
        if self._waiting.tell():
            durable.append(self._file, self._waiting.getvalue())
            self._waiting = io.BytesIO()


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
