"""The workers that do the tasks of an evaluation: processes of a pool, or a cluster of Ray."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any, Protocol, TypeVar

from atari.base.extras import import_extra, install_extra
from atari.base.validation import check_name

Task = TypeVar("Task")
Done = TypeVar("Done")


class Workers(Protocol):
    """An object with `map`, such as `concurrent.futures.Executor` and the pools of `multiprocessing` and of Ray."""

    def map(self, function: Callable[[Any], Any], tasks: Iterable[Any], /) -> Iterable[Any]:
        """The results of the function for the tasks, in their order."""


class RayWorkers:
    """The cluster of Ray that this process is connected to. Without a connection, Ray starts on this machine.

    Each task has one CPU. A task whose worker or node is lost is done again elsewhere.

    Raises:
        gymnasium.error.DependencyNotInstalled: Ray is not installed.
    """

    def __init__(self) -> None:
        self._ray = import_extra("ray", f"workers='ray' needs Ray: {install_extra('ray')}")

    def map(self, function: Callable[[Task], Done], tasks: Iterable[Task], /) -> Iterator[Done]:
        """The results of the function for the tasks, in their order. An error cancels the other tasks."""
        remote = self._ray.remote(function)
        pending = [remote.remote(task) for task in tasks]
        try:
            for result in pending:
                yield self._ray.get(result)
        except BaseException:
            _, running = self._ray.wait(pending, num_returns=len(pending), timeout=0)
            for result in running:
                self._ray.cancel(result)
            raise


def find_workers(workers: Any) -> Workers:
    """The workers of an argument: a name, or an object with `map`.

    Raises:
        TypeError: the object has no `map`.
        ValueError: no workers have this name.
        gymnasium.error.DependencyNotInstalled: the package that they need is not installed.
    """
    if isinstance(workers, str):
        check_name("workers", workers, ["ray"])
        return RayWorkers()
    if not callable(getattr(workers, "map", None)):
        raise TypeError(f"workers is 'ray' or has a method map(function, tasks), got {workers!r}")
    found: Workers = workers
    return found
