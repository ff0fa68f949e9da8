"""`RunFolder`: the files of a training, in one folder, of which a kill or a loss of power loses nothing."""

import json
import platform
import shutil
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

import torch

from atari.base import durable, json_text
from atari.base.typed_table import check_table
from atari.base.validation import check_file, check_integer
from atari.learning.evaluation.results import versions
from atari.learning.memory import ReplayMemory
from atari.learning.programs import program, sha256, trust
from atari.learning.run_log import RunLog, read_rows
from atari.learning.sealed import load_sealed, sealed
from atari.task import Task

FORMAT = 3
"""Version of the run folder. A newer one is refused; from 3 on, `checkpoint.pt` and `policy.pt` have checksums."""

_KEYS: Mapping[str, Any] = {"format": int, "agent": str, "task": dict, "options": dict, "versions": dict}


class RunFolder:
    """The folder of a training, for the agents of this package and for a loop of your own.

    - `config.json`: agent, task, options, versions, and the reason of the end;
    - `agent.py`, `network.py` and others: copies of the training's own programs, if it has some;
    - `log.csv`: a row for each call of `log`, and TensorBoard's event files;
    - `checkpoint.pt`: the newest state of the training (contains pickles);
    - `policy.pt`: the newest weights (contains none);
    - `memory.replay`: the `ReplayMemory` of the training, if it has one;
    - `lock`: an empty file, locked while a training writes into the folder;
    - `best.a26r`, `best.mp4`, `evaluation.json`, `report.html`: see `atari.learning.report`.

    **A training that is killed at any time, also by a loss of power, goes on from its last checkpoint or the one
    before.** A file is replaced only when its successor is complete and on the disk; a checkpoint and the state of the
    memory that it names become valid together. Files are not written through symbolic links. If a disk is full, rows of
    the log are kept in memory and written when the disk has room again.

    Attributes:
        path: the path of the folder.
        config: the contents of `config.json`.
        state: after `resume`, the state of the last checkpoint; None if there is none yet.
        memory: after `resume`, the memory as it was then; otherwise None.

    Example:
        >>> import atari, torch
        >>> from atari.learning import RunFolder
        >>> network = torch.nn.Linear(128, 6)
        >>> with RunFolder.begin("runs/mine", "mine", atari.Task.of("Pong-ram-v4"), {"rate": 0.1}) as run:
        ...     run.log({"step": 100, "score": -21.0})
        ...     run.checkpoint(100, {"network": network.state_dict()}, network.state_dict())
        >>> with RunFolder.resume("runs/mine") as run:
        ...     list(run.state), run.task.game, run.config["options"], run.rows()
        (['network'], 'pong', {'rate': 0.1}, [{'step': 100.0, 'score': -21.0}])
    """

    def __init__(self, path: Path, config: dict[str, Any], lock: BinaryIO | None = None) -> None:
        self.path = path
        self.config = config
        self.state: dict[str, Any] | None = None
        self.memory: ReplayMemory | None = None
        self._lock, self._log = lock, RunLog(path)

    @classmethod
    def begin(
        cls,
        path: str | Path,
        agent: str,
        task: Task,
        options: Mapping[str, Any],
        *,
        programs: Mapping[str, str] | None = None,
    ) -> "RunFolder":
        """Make a new folder, and lock it.

        Args:
            path: the folder, which must not exist or be empty.
            agent: the name of the agent.
            task: what the agent plays.
            options: further options, of JSON's types.
            programs: by a kind, such as "agent" or "loop", a Python file of your own, FILE.py or FILE.py:NAME with the
                class or function in it. The folder keeps a copy, such as `loop.py`, and the configuration its path,
                name and SHA-256.

        Raises:
            FileNotFoundError: there is no such file.
            FileExistsError: the folder has files.
            BlockingIOError: another training has just begun in it.
            TypeError: `task` is no `Task`, `agent` no text, or `options` no mapping.
            ValueError: the task has a game without a file, or an option is not of JSON's types.
        """
        path = Path(path)
        if not isinstance(task, Task):
            raise TypeError(f"task must be an atari.Task, such as Task.of('pong') or envs.task, got {task!r}")
        if not isinstance(agent, str):
            raise TypeError(f"agent must be a name, got {agent!r}")
        if not isinstance(options, Mapping):
            raise TypeError(f"options must be a mapping, such as {{'rate': 0.1}}, got {options!r:.80}")
        config = {
            "format": FORMAT,
            "agent": agent,
            "task": json.loads(task.to_json()),
            "options": dict(options),
            "versions": {
                **versions(),
                "python": platform.python_version(),
                "machine": f"{platform.system()} {platform.machine()}",
            },
        }
        for kind in programs or {}:
            _check_kind(kind)
        named = {kind: program(text) for kind, text in (programs or {}).items()}
        sources = {f"{kind}.py": check_file(one.file).read_bytes() for kind, one in named.items()}
        if named:
            config["programs"] = {
                kind: {"file": str(one.file.absolute()), "name": one.name, "sha256": sha256(sources[f"{kind}.py"])}
                for kind, one in named.items()
            }
        try:
            json.dumps(config, allow_nan=False)
        except (TypeError, ValueError) as error:
            raise ValueError(f"the options of a run must be of JSON's types: {error}") from None
        _check_empty(path, sources)
        path.mkdir(parents=True, exist_ok=True)
        run = cls(path, config, _locked(path))
        try:
            _check_empty(path, sources)  # another training may have begun and ended meanwhile
            for name, source in sources.items():
                durable.write_file(path / name, source)
            run._write_config(config)
        except BaseException:
            run.close()
            raise
        return run

    @classmethod
    def open(cls, path: str | Path, *, lock: bool = False) -> "RunFolder":
        """Open a folder for reading, also while a training writes into it.

        Args:
            path: the folder.
            lock: lock it, to write files into it.

        Raises:
            FileNotFoundError, ValueError: the folder is no run folder, damaged, or of another version.
            BlockingIOError: with `lock`, a training writes into the folder.
        """
        path = Path(path)
        file = path / "config.json"
        if not file.is_file():
            raise FileNotFoundError(
                f"{path} is no run folder: it has no config.json; `atari train` and RunFolder.begin make one"
            )
        config = json_text.read(file)
        version = config.get("format") if isinstance(config, dict) else None
        if type(version) is not int or version != FORMAT:
            raise ValueError(
                f"{file} has format {version!r:.60}, and this atari-envs reads {FORMAT}; use the one that wrote it"
            )
        try:
            check_table(config, "the configuration", _KEYS, {"ended": str, "keep_memory": bool, "programs": dict})
            for kind, entry in config.get("programs", {}).items():
                check_table(entry, f"program {kind!r}", dict.fromkeys(("file", "name", "sha256"), str))
                _check_kind(kind)
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise ValueError(f"{file} is damaged: {error!r}") from None
        return cls(path, config, _locked(path) if lock else None)

    @classmethod
    def resume(cls, path: str | Path, *, num_threads: int = 1) -> "RunFolder":
        """Open a folder to go on with its training, and lock it. `state` and `memory` are then as they were.

        If the training was stopped before its first checkpoint, `state` is None: it begins again.

        The pickles of the checkpoint are executed: resume only folders that you trust.

        Args:
            path: the folder.
            num_threads: see `ReplayMemory`.

        Raises:
            FileNotFoundError, ValueError: the folder is no run folder, damaged, or of another version.
            BlockingIOError: a training writes into the folder.
        """
        run = cls.open(path, lock=True)
        try:
            run._restore(num_threads)
        except BaseException:
            run.close()
            raise
        return run

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

    def program(self, kind: str) -> Path:
        """The path of the copy of one of the training's own programs."""
        return self.path / f"{kind}.py"

    def read_program(self, kind: str) -> bytes:
        """One of the training's own programs, as it was when the training began.

        Raises:
            FileNotFoundError, ValueError: the training has no such program, or the copy was changed.
        """
        programs = self.config.get("programs", {})
        if kind not in programs:
            raise FileNotFoundError(f"{self.path} keeps no program {kind!r}, but {', '.join(programs) or 'none'}")
        source = check_file(self.program(kind)).read_bytes()
        if sha256(source) != programs[kind]["sha256"]:
            raise ValueError(
                f"{self.program(kind)} is not the program of the training: its SHA-256 differs from config.json's; "
                "put the copy there again"
            )
        return source

    def trust(self) -> None:
        """Remember that you trust the author of this run's programs, which loading the run executes.

        Raises:
            FileNotFoundError, ValueError: see `read_program`.
        """
        for kind in self.config.get("programs", {}):
            trust(sha256(self.read_program(kind)))

    def log(self, row: Mapping[str, float]) -> None:
        """Add a row to `log.csv` and to TensorBoard.

        Args:
            row: numbers by the name of their column, `step` among them. All rows have the columns of the first.

        Raises:
            ValueError: the row has no `step`, or other columns than the first row; or the folder is open for reading.
        """
        self._check_locked()
        if "step" not in row:
            raise ValueError(f"a row of the log needs the column step, got {', '.join(row)}")
        self._log.add(row)

    def rows(self) -> list[dict[str, float]]:
        """The rows of `log.csv`. A damaged row and those after it are left out with a warning."""
        return read_rows(self.path / "log.csv")

    def checkpoint(
        self,
        step: int,
        state: Mapping[str, Any],
        weights: Mapping[str, torch.Tensor],
        memory: ReplayMemory | None = None,
    ) -> None:
        """Replace `checkpoint.pt` and `policy.pt`, and flush the memory, which together are what `resume` reads.

        Args:
            step: the step of the training; `resume` forgets the rows of the log after it.
            state: all that the training needs to go on: numbers, tensors, and what can be pickled.
            weights: the weights of the policy, as `state_dict` returns them.
            memory: the memory in the file `memory.replay` of the folder, made with `autoflush=False`.

        Raises:
            TypeError, ValueError: an argument is of the wrong kind, or the memory is another one; nothing is written.
            OSError: the disk is full, for example. The last checkpoint and the memory's flush that it names stay valid.
        """
        self._check_locked()
        check_integer("step", step, 0, 2**63 - 1)
        if not isinstance(state, Mapping):
            raise TypeError(f"state must be a mapping, such as {{'network': ...}}, got {type(state).__name__}")
        _check_weights(weights)
        if memory is not None:
            self._check_memory(memory)
        flush = None if memory is None else memory.flushes + 1
        content = {"step": step, "state": dict(state), "weights": dict(weights), "flush": flush}
        file = self.path / "checkpoint.pt"
        self._log.sync()
        # The first file: without it, the folder looks as if it was lost. Protocol 2 writes two bytes for many a byte.
        durable.write_part(file, sealed(content, pickle_protocol=4))
        self._write_weights(weights)
        if memory is not None:
            try:
                memory.flush()
            except OSError:
                if memory.flushes != flush:  # the checkpoint before names the memory's last flush
                    durable.remove(durable.part_of(file))
                    raise
        durable.publish(file)

    def end(self, reason: str, *, keep_memory: bool = False) -> None:
        """Enter into `config.json` that the training is complete. The memory's file is removed by `close`.

        Args:
            reason: why it ended, such as "steps".
            keep_memory: keep `memory.replay`, which a training needs that goes on from here.
        """
        self._check_locked()
        config = {**self.config, "ended": reason, "keep_memory": keep_memory}
        self._write_config(config)
        self.config = config  # only now: `close` removes the memory of a training that is complete

    def extend(self, total_steps: int) -> None:
        """Let a training that was stopped or is complete have more steps; `resume` then goes on with it.

        What depends on `total_steps`, such as a learning rate that falls to 0, follows the new number. A training that
        ended at its `stop_score` has none any more.

        Args:
            total_steps: the new number of steps, above the steps that the training has made.

        Raises:
            ValueError: the training has made as many steps, or its replay memory was removed at its end.
        """
        self._check_locked()
        options, file = self.config["options"], self.path / "checkpoint.pt"
        state = load_sealed(file, weights_only=False) if file.exists() else {}
        done = state.get("step", 0)
        if total_steps <= done:
            raise ValueError(f"{self.path} has made {done:,} steps, so total_steps must be above, got {total_steps:,}")
        if state.get("flush") is not None and not (self.path / "memory.replay").exists():
            raise ValueError(
                f"{self.path} is complete, and its replay memory was removed; only a training with --keep-memory can "
                "have more steps"
            )
        changed = {"total_steps": total_steps, **({"stop_score": None} if self.config.get("ended") == "score" else {})}
        config = {name: value for name, value in self.config.items() if name not in ("ended", "keep_memory")}
        config["options"] = {**options, **changed}
        self._write_config(config)
        self.config = config

    def load_weights(self) -> dict[str, torch.Tensor]:
        """The weights in `policy.pt`; nothing in the file is executed.

        Raises:
            FileNotFoundError, ValueError: the file does not exist, or is damaged.
        """
        file = self.path / "policy.pt"
        if not file.is_file():
            raise FileNotFoundError(f"{file} does not exist; the first checkpoint writes it")
        weights = load_sealed(file, weights_only=True)
        if not isinstance(weights, dict) or not all(isinstance(value, torch.Tensor) for value in weights.values()):
            raise ValueError(f"{file} is damaged: it has no weights")
        return weights

    def close(self) -> None:
        """Close the log, and unlock the folder. A memory must be closed before."""
        if self._lock is None:
            return
        if self.memory is not None:
            self.memory.close()
        if self.config.get("ended") and not self.config.get("keep_memory"):
            with suppress(OSError):
                durable.remove(self.path / "memory.replay")
        durable.unlock(self._lock)
        self._lock.close()
        self._lock = None

    def discard(self) -> None:
        """Close a folder whose training did not begin, and remove it with its files."""
        self.close()
        shutil.rmtree(self.path, ignore_errors=True)  # of the working folder only the files

    def __getstate__(self) -> dict[str, Any]:
        """A folder that is open for reading can be copied.

        Raises:
            TypeError: the folder is locked.
        """
        if self._lock is not None:
            raise TypeError(
                f"a RunFolder that is locked for a training cannot be copied or pickled: {self.path}; "
                "pass the path, and use RunFolder.open(path) there"
            )
        return vars(self)

    def __enter__(self) -> "RunFolder":
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _check_locked(self) -> None:
        if self._lock is None:
            raise ValueError(f"{self.path} is open for reading; RunFolder.resume opens it for a training")

    def _check_memory(self, memory: ReplayMemory) -> None:
        file = self.path / "memory.replay"
        if memory.path is None or memory.path.resolve() != file.resolve():
            given = "in no file" if memory.path is None else f"in {memory.path}"
            raise ValueError(
                f"the memory of a run is made with path={str(file)!r}, autoflush=False, and this one is {given}"
            )
        if memory.autoflush:
            raise ValueError(
                f"the memory of a run is made with autoflush=False, and {memory.path} flushes by itself; the last "
                "checkpoint then has no flush to go on from"
            )

    def _write_weights(self, weights: Mapping[str, torch.Tensor]) -> None:
        durable.write_file(self.path / "policy.pt", sealed(dict(weights)))

    def _write_config(self, config: Mapping[str, Any]) -> None:
        durable.write_file(self.path / "config.json", json.dumps(config, indent=2).encode())

    def _restore(self, num_threads: int) -> None:
        """Read the newest checkpoint whose flush the memory has: the one that was being written, or the last one."""
        file = self.path / "checkpoint.pt"
        part = durable.part_of(file)
        errors = []
        for found in (part, file):
            if not found.is_file():
                continue
            try:
                weights = self._adopt(found, num_threads)
            except ValueError as error:  # it was not complete, or the memory was not flushed any more
                errors.append(str(error))
                continue
            if found == part:
                self._write_weights(weights)
                durable.publish(file)
            durable.remove(part)
            return
        if file.exists():
            raise ValueError("; and ".join(reversed(errors)))
        if (self.path / "policy.pt").exists() and not part.exists():
            raise FileNotFoundError(f"{file} is missing; put it there again")
        durable.remove(self.path / "memory.replay")
        self._log.forget_after(-1)

    def _adopt(self, file: Path, num_threads: int) -> Mapping[str, torch.Tensor]:
        """Take the state of a checkpoint, open its memory, and forget the rows of later steps; returns the weights."""
        content = load_sealed(file, weights_only=False)
        if not isinstance(content, dict) or content.keys() != {"step", "state", "weights", "flush"}:
            raise ValueError(f"{file} is damaged: it is no checkpoint of a training")
        memory, flush = self.path / "memory.replay", content["flush"]
        if flush is not None:
            if not memory.exists():
                if self.config.get("ended") is not None:
                    raise ValueError(
                        f"the training in {self.path} is complete, and its memory was removed, so it does not go on; "
                        "end(..., keep_memory=True), or --keep-memory, keeps the memory for `extend`"
                    )
                raise ValueError(
                    f"{memory} is missing, and {file.name} goes on from its flush {flush}; put it there again"
                )
            self.memory = ReplayMemory.open(memory, flush=flush, num_threads=num_threads, autoflush=False)
        self.state = content["state"]
        self._log.forget_after(content["step"])
        return content["weights"]


def _check_kind(kind: str) -> None:
    if not kind.isidentifier():
        raise ValueError(f"a program's kind must be a name such as loop, got {kind!r}")


def _check_empty(path: Path, sources: Mapping[str, bytes]) -> None:
    """Check that a folder is new, or that a training was stopped in it before it had its configuration."""

    def is_left(file: Path) -> bool:
        if file.name in sources:
            return file.is_file() and file.read_bytes() == sources[file.name]
        return file.name in ("lock", "config.json.part") or file.name.removesuffix(".part") in sources

    if path.exists() and not all(map(is_left, path.iterdir())):
        raise FileExistsError(
            f"{path} is not empty; give another folder, or go on with it: --resume {path}, RunFolder.resume"
        )


def _locked(path: Path) -> BinaryIO:
    return durable.lock_file(path / "lock", f"a training writes into {path}; wait for its end, or stop it")


def _check_weights(weights: Any) -> None:
    if not isinstance(weights, Mapping):
        raise TypeError(f"weights must be tensors by name, as network.state_dict(), got {type(weights).__name__}")
    for name, value in weights.items():
        if not isinstance(name, str) or not isinstance(value, torch.Tensor):
            raise TypeError(
                f"weights must be tensors by name, as network.state_dict(), got {type(value).__name__} under {name!r}; "
                "several networks go into one torch.nn.ModuleDict"
            )
