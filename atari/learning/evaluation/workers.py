"""Where the tasks of an evaluation are done: in this process, in those of a pool, or on a cluster of Ray."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any, Protocol, TypeVar

from atari.validation import check_name, import_extra

Task = TypeVar("Task")
Done = TypeVar("Done")


class Workers(Protocol):
    """What has `map`, as `concurrent.futures.Executor` and the pools of `multiprocessing` and of Ray have."""

    def map(self, function: Callable[[Any], Any], tasks: Iterable[Any], /) -> Iterable[Any]:
        """What the function returns for each task, in the order of the tasks."""


class RayWorkers:
    """The cluster of Ray that this process is connected to; one of this machine is started if it is to none.

    Each task has one CPU. A task whose worker or node is lost is done again elsewhere.

    Raises:
        gymnasium.error.DependencyNotInstalled: there is no Ray.
    """

    def __init__(self) -> None:
        self._ray = import_extra("ray", "workers='ray' needs Ray: pip install 'atari-envs[ray]'")

    def map(self, function: Callable[[Task], Done], tasks: Iterable[Task], /) -> Iterator[Done]:
        """What the function returns for each task, in the order of the tasks. An error cancels the others."""
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
    """`workers`, or those of a name.

    Raises:
        TypeError: it has no `map`.
        ValueError: there are none of this name.
        gymnasium.error.DependencyNotInstalled: the package that they need is not installed.
    """
    if isinstance(workers, str):
        check_name("workers", workers, ["ray"])
        return RayWorkers()
    if not callable(getattr(workers, "map", None)):
        raise TypeError(f"workers is 'ray' or has a method map(function, tasks), got {workers!r}")
    found: Workers = workers
    return found
