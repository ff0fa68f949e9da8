"""`StoredMemory`: the bytes of a replay memory, in main memory or in a file, with flushes, copies and a lock."""

import os
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from functools import wraps
from os import PathLike
from pathlib import Path
from typing import Any, Concatenate, ParamSpec, TypeVar

from typing_extensions import Self

import atari._emulator as _emulator
from atari.base.validation import check_integer
from atari.learning.memory import memory_file
from atari.learning.memory.options import MemoryOptions
from atari.task.checks import check_bool

_Self = TypeVar("_Self", bound=Any)
_Arguments = ParamSpec("_Arguments")
_Result = TypeVar("_Result")


def atomic(
    method: Callable[Concatenate[_Self, _Arguments], _Result],
) -> Callable[Concatenate[_Self, _Arguments], _Result]:
    """The method, which holds the lock `_lock` of its object: one such call of an object runs at a time."""

    @wraps(method)
    def locked(self: _Self, /, *arguments: _Arguments.args, **named: _Arguments.kwargs) -> _Result:
        with self._lock:
            return method(self, *arguments, **named)

    return locked


class StoredMemory:
    """The steps of a replay memory in one block of bytes, and their state on the disk."""

    def _begin(
        self,
        options: MemoryOptions,
        threads: int,
        file: memory_file.BlockFile | None,
        block: memory_file.Block,
        autoflush: bool,
    ) -> None:
        self._process, self._lock = os.getpid(), _emulator.CallLock("replay memory")
        self._autoflush = autoflush and file is not None
        self._options, self._threads, self._file = options, threads, file
        self._use(_emulator.ReplayMemory(options.geometry(), block), block)

    def _use(self, core: _emulator.ReplayMemory, block: memory_file.Block) -> None:
        self._closed_core: _emulator.ReplayMemory | None = core
        self._block = block

    def _make_space(self, core: _emulator.ReplayMemory) -> None:
        if self._autoflush and core.must_save:
            self.flush()

    @classmethod
    def open(
        cls,
        path: str | PathLike[str],
        *,
        flush: int | None = None,
        num_threads: int = 1,
        autoflush: bool = True,
        verify: bool = True,
    ) -> Self:
        """Continue the memory in a file from its last `flush`, also after a kill or a loss of power.

        Args:
            path: the file.
            flush: the number of the flush to continue from, see `flushes`: the last, or the one before while no later
                step has overwritten it. The file then forgets a later flush. None is the last.
            num_threads, autoflush: see `ReplayMemory`.
            verify: read the whole file and compare its checksums. With False, damaged frames stay unnoticed.

        Raises:
            FileNotFoundError, IsADirectoryError: the file does not exist, or is a folder.
            BlockingIOError: it is open, in this process or another.
            ValueError: the file holds no replay memory, or is damaged; the message says where. Or it has no such flush;
                the message says which it has. Or it is a symbolic link, a pipe or a device.
        """
        threads = check_integer("num_threads", num_threads, 1, 1024)
        autoflush, verify = check_bool("autoflush", autoflush), check_bool("verify", verify)
        number = None if flush is None else check_integer("flush", flush, 1, 2**62)
        where = Path(os.fspath(path))
        file = memory_file.BlockFile.open(where)
        try:
            memory = cls.__new__(cls)
            memory._begin(file.options, threads, file, file.block, autoflush)
            with memory_file.naming(where):
                memory._core.load(verify, number)
            if number is not None:
                file.sync()  # a later flush is forgotten before its rows are overwritten
            memory._core.resume()
        except BaseException:
            file.close()
            raise
        return memory

    @property
    def _core(self) -> _emulator.ReplayMemory:
        if self._closed_core is None:
            raise ValueError("this replay memory is closed")
        if self._file is not None:
            self._file.check_size()
        return self._closed_core

    @property
    @atomic
    def steps(self) -> int:
        """Steps ever added, of all environments together, ignored steps included."""
        return self._core.numbers[1]

    @property
    @atomic
    def nbytes(self) -> int:
        """Bytes of memory, or of the file, and of the index; with compressed frames the bytes in use up to now."""
        return self._core.numbers[3]

    @property
    def num_envs(self) -> int:
        """Environments that step together."""
        return self._options.num_envs

    @property
    def capacity(self) -> int:
        """The number of latest steps that are kept."""
        return self._options.capacity

    @property
    def path(self) -> Path | None:
        """The file that holds the memory; None if there is none."""
        return None if self._file is None else self._file.path

    @property
    def autoflush(self) -> bool:
        """Whether the memory has a file, and flushes by itself."""
        return self._autoflush

    @property
    @atomic
    def flushes(self) -> int:
        """The number of the last flush, which `open` takes: flushes are counted from the first, of a new file."""
        return self._core.numbers[2]

    @property
    @atomic
    def must_flush(self) -> bool:
        """Whether the next `add` or `reset` might overwrite the state of the last flush.

        This reckons with the end of all episodes, and with frames that cannot be compressed. After a flush there is
        space for at least one step, and for more by `margin`, `final_frames` and `compressed_bytes`. Without a file it
        is always False.
        """
        return self._core.must_save

    @atomic
    def flush(self) -> None:
        """Save the present state, which `open` then finds, and wait until it is on the disk.

        After `margin` more steps, or an eighth of `final_frames` more final observations, the next step might
        overwrite the saved state: then the memory flushes by itself, or with autoflush=False raises BufferError.
        Flushes do not change what is sampled.

        A saved state survives the end of the process and a loss of power; these leave the last complete flush at every
        moment. The call takes as long as the disk needs for the frames since the last flush: milliseconds for a few
        megabytes. Without a file nothing happens.

        Raises:
            OSError: the disk reports an error. The flush before is still complete, and a later flush tries again.
        """
        core = self._core
        if self._file is None:
            return
        for phase in (core.begin_save, core.write_save, core.complete_save):
            phase()
            self._file.sync()
        core.end_save()

    @atomic
    def state(self) -> dict[str, Any]:
        """A copy of the whole memory, for checkpoints without a file. It is as large as the memory.

        This does not change a file: `open` finds its last flush.
        """
        core, block = self._core, self._block.copy()
        core.save_copy(block)
        return memory_file.state_of(self._options, block)

    @atomic
    def restore(self, state: Mapping[str, Any]) -> None:
        """Return to a state of this memory, or of another one with the same options.

        A memory with a file writes a new file, which then replaces it: after a kill or a loss of power there is one of
        them, with the flushes of the state or those before.

        Raises:
            ValueError: the state is of a memory with other options, or damaged; nothing has changed.
            OSError: the disk has no space for the new file; nothing has changed.
        """
        core, old = self._core, self._file
        with memory_file.naming("the state"):
            given = memory_file.block_of(state, self._options)
            file = None if old is None else old.successor()
            try:
                block = memory_file.allocate(self._options) if file is None else file.block
                block[:] = given
                core = _emulator.ReplayMemory(self._options.geometry(), block)
                core.load(True, None)
                core.resume()
                if file is not None and old is not None:
                    file.replace(old)
            except BaseException:
                if file is not None:
                    file.discard()
                raise
        self._file = file
        self._use(core, block)
        if file is not None and old is not None:
            old.close()
            file.sync_name()

    def __getstate__(self) -> dict[str, Any]:
        """Pickling and copying copy all steps, and the generator that samples.

        Raises:
            TypeError: the memory has a file.
        """
        if self._file is not None:
            raise TypeError(
                f"a ReplayMemory with a file cannot be copied or pickled: {self._file.path} is open for one object; "
                "close it and pass the path to ReplayMemory.open, or restore its state() in a memory without a file"
            )
        return {"state": self.state(), "num_threads": self._threads}

    def __setstate__(self, state: dict[str, Any]) -> None:
        options = memory_file.checked_options(state["state"]["options"])
        block = memory_file.allocate(options)
        block[:] = memory_file.block_of(state["state"], options)
        self._begin(options, state["num_threads"], None, block, False)
        self._core.load(True, None)
        self._core.resume()

    def close(self) -> None:
        """Release the memory and the file, without a flush."""
        # In a forked process, a thread that no longer exists may hold the lock.
        with self._lock if self._process == os.getpid() else nullcontext():
            self._closed_core = None
            if self._file is not None:
                self._file.close()

    def _discard(self) -> None:
        """Close the memory, and remove its file."""
        self.close()
        if self._file is not None:
            self._file.discard()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
