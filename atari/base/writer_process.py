"""HDF5 writes in a process of its own: after a failed write, such as on a full disk, HDF5 ends its process by a signal.

`write_apart` starts the process, which runs this file as a script. It imports nothing else of the package, so that it
starts in a third of a second. It gets the data through a pipe, and reports the first error.
"""

import os
import pickle
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from itertools import chain
from typing import Any, BinaryIO, NoReturn

_ERRNO = re.compile(r"errno = (\d+)")  # in the texts of HDF5's errors, some of which are no OSError


def write_apart(writer: str, arguments: Mapping[str, Any], items: Iterable[Any]) -> None:
    """Let another process write items, while this one makes the next.

    Args:
        writer: a key of `WRITERS`.
        arguments: passed to the writer.
        items: passed to the writer, one after another.

    Raises:
        OSError: the writer cannot write, or its process has ended; what it wrote is incomplete.
        Exception: errors of `items`, and other errors of the writer.
    """
    import cloudpickle  # in the dependencies of Gymnasium; it takes functions that are not in a module

    flags: dict[str, Any] = {"start_new_session": True}  # Ctrl-C is for this process, which ends the other one
    if os.name == "nt":
        flags = {"creationflags": getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)}
    process = subprocess.Popen(
        [sys.executable, "-IB", __file__],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        **flags,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        try:
            pickle.dump([os.path.abspath(entry) for entry in sys.path], process.stdin)
            pickle.dump(cloudpickle.dumps((writer, dict(arguments))), process.stdin)
            for item in chain(items, [None]):
                pickle.dump(item, process.stdin, protocol=5)
            process.stdin.close()
        except BrokenPipeError:  # the other process has an error to report, or has ended
            pass
        data, status = process.stdout.read(), process.wait()
    finally:
        process.kill()  # after an error of `items` or Ctrl-C
        process.wait()
        for pipe in (process.stdin, process.stdout):
            with suppress(OSError):  # what it has not read
                pipe.close()
    error = pickle.loads(data) if data else OSError(f"HDF5 could not write, and its process has ended ({status})")
    if error is not None:
        raise error


def _hdf5(parts: Iterator[Any], path: str, facts: Mapping[str, str], version: str) -> None:
    """Write an HDF5 file.

    Args:
        parts: (name of a group, None), or (name of a dataset, (shape, number of the first row, rows, options)).
        path: the file.
        facts: the attributes of the file.
        version: the oldest version of HDF5 that reads it.
    """
    import h5py

    with h5py.File(path, "w", libver=version) as root:
        root.attrs.update(facts)
        for name, content in parts:
            if content is None:
                root.require_group(name)
                continue
            shape, first, rows, options = content
            data = root.create_dataset(name, shape, rows.dtype, **options) if first == 0 else root[name]
            data[first : first + len(rows)] = rows


def _minari(episodes: Iterator[Any], folder: str, dataset_id: str, options: dict[str, Any], facts: Any) -> None:
    """Write a dataset of Minari.

    Args:
        episodes: the arguments of an `EpisodeBuffer` each.
        folder: used as the folder of all datasets.
        dataset_id: its name.
        options: passed to `create_dataset_from_buffers`.
        facts: added to the metadata.
    """
    os.environ["MINARI_DATASETS_PATH"] = folder
    import minari

    buffers: Any = (minari.data_collector.EpisodeBuffer(**episode) for episode in episodes)
    dataset = minari.create_dataset_from_buffers(dataset_id, buffers, **options)
    dataset.storage.update_metadata(facts)


WRITERS: Mapping[str, Callable[..., None]] = {"hdf5": _hdf5, "minari": _minari}
"""The functions that write, by name."""


def _main(source: BinaryIO, output: int) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.dup2(2, 1)  # a library's text on stdout is no report

    def end(error: BaseException | None) -> NoReturn:
        os.write(output, pickle.dumps(_reported(error)))
        os._exit(0)  # HDF5's own end would try once more to write what it could not, and crash

    try:
        sys.path[:] = pickle.load(source)
        _end_at_first_error(end)
        writer, arguments = pickle.loads(pickle.load(source))
        WRITERS[writer](iter(lambda: pickle.load(source), None), **arguments)
    except BaseException as error:
        end(error)
    end(None)


def _end_at_first_error(end: Callable[[BaseException], NoReturn]) -> None:
    """Let HDF5 end the process at its first error: to close the file after it can crash."""
    import h5py

    def leave(file: Any, _: object, error: BaseException | None, __: object) -> None:
        if error is not None:
            end(error)
        file.flush()
        file.close()

    h5py.File.__exit__ = leave
    sys.unraisablehook = lambda args: end(args.exc_value or OSError(str(args.err_msg)))  # of objects that are freed


def _reported(error: BaseException | None) -> BaseException | None:
    """An error that can be pickled, and names the cause where HDF5 has it among other things."""
    number = getattr(error, "errno", None) or next(map(int, _ERRNO.findall(str(error))), 0)
    if number:
        return OSError(number, os.strerror(number), getattr(error, "filename", None))
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return OSError(f"{type(error).__name__}: {error}")
    return error


if __name__ == "__main__":
    if globals()["__spec__"] is not None:  # by `python -m`; `write_apart` starts the file
        sys.exit("atari: error: this module is no program; `atari collect` and `write_dataset` start it")
    _main(sys.stdin.buffer, os.dup(1))
