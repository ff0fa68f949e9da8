"""`AsyncVectorEnv`: several environments, each in a process of its own."""

import contextlib
import multiprocessing
import pickle
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from multiprocessing.connection import Connection
from typing import Any

import cloudpickle  # type: ignore[import-untyped]
import gymnasium

from atari.classic.core import Env
from atari.classic.spaces import Space
from atari.classic.vector.vector_env import Lane, VectorEnv, check_env_fns


class AsyncVectorEnv(VectorEnv):
    """Steps its environments at the same time, in processes.

    An exception in an environment is raised here.

    Args:
        env_fns: functions that make the environments.
        observation_space: the space of one environment's observations; None means the first environment's.
        action_space: the space of one environment's actions; likewise.
        shared_memory: has no effect; observations come through pipes.
        copy: has no effect; observations are new arrays.
        context: how processes start: "fork", "spawn" or "forkserver"; None means "fork" where the system has it.
        daemon: whether the processes end with this one.

    Raises:
        ValueError: there are no functions, or no such context.
    """

    def __init__(
        self,
        env_fns: Iterable[Callable[[], Env]],
        observation_space: Space[Any] | None = None,
        action_space: Space[Any] | None = None,
        shared_memory: bool = True,
        copy: bool = True,
        context: str | None = None,
        daemon: bool = True,
    ) -> None:
        functions = check_env_fns(env_fns)
        self._pipes: list[Connection] = []
        self._processes: list[Any] = []
        self.closed = False
        methods = multiprocessing.get_all_start_methods()
        self._start(functions, multiprocessing.get_context(context or ("fork" if "fork" in methods else None)), daemon)
        try:
            facts = self._all("facts", [()] * len(functions))[0]
        except BaseException:
            self.close()  # the processes wait for a command
            raise
        *spaces, self.metadata, self.reward_range, self.spec = facts
        super().__init__(len(functions), observation_space or spaces[0], action_space or spaces[1])

    def step_async(self, actions: Any) -> None:
        """Begin to step, for the next `step_wait`."""
        super().step_async(actions)
        self._send("step", [(action,) for action in self._actions or []])

    def close(self, terminate: bool = False) -> None:
        """Close the environments and end the processes; later calls do nothing.

        Args:
            terminate: end the processes without closing the environments.
        """
        if self.closed:
            return
        self.closed = True
        for process in self._processes if terminate else ():
            process.terminate()
        for pipe in self._pipes:
            with contextlib.suppress(OSError):  # the process has ended
                pipe.send(("close", ()))
        for process in self._processes:
            process.join()
        for pipe in self._pipes:
            pipe.close()

    def __del__(self) -> None:
        if hasattr(self, "closed"):
            self.close()

    def _start(self, functions: list[Callable[[], Env]], context: Any, daemon: bool) -> None:
        for function in functions:
            here, there = context.Pipe()
            process = context.Process(target=_work, args=(there, cloudpickle.dumps(function)), daemon=daemon)
            process.start()
            there.close()
            self._pipes.append(here)
            self._processes.append(process)

    def _reset_all(self, options: dict[str, Any]) -> list[Any]:
        return self._all("reset", [(options,)] * self.num_envs)

    def _step_all(self, actions: Sequence[Any]) -> list[Any]:
        return self._receive()

    def _call_all(self, name: str, arguments: Sequence[Any], options: dict[str, Any]) -> list[Any]:
        return self._all("call", [(name, arguments, options)] * self.num_envs)

    def _seed_all(self, seeds: Sequence[int | None]) -> list[Any]:
        return self._all("seed", [(seed,) for seed in seeds])

    def _all(self, command: str, arguments: Sequence[Any]) -> list[Any]:
        self._send(command, arguments)
        return self._receive()

    def _send(self, command: str, arguments: Sequence[Any]) -> None:
        with _named_end():
            for pipe, own in zip(self._pipes, arguments, strict=True):
                pipe.send((command, own))

    def _receive(self) -> list[Any]:
        with _named_end():
            answers = [pipe.recv() for pipe in self._pipes]
        for _, error in answers:
            if error is not None:
                raise error
        return [value for value, _ in answers]


@contextlib.contextmanager
def _named_end() -> Iterator[None]:
    """Raise an error that says so if a process has ended.

    Raises:
        gymnasium.error.Error: a process has ended.
    """
    try:
        yield
    except (EOFError, OSError):
        raise gymnasium.error.Error("the vector is closed, or one of its processes has ended; make it again") from None


def _work(pipe: Connection, function: bytes) -> None:
    """Answer the commands of the vector with pairs of a value and an exception, until "close"."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # the parent ends by it a process that has the parent's handler
    lane: Any = None
    while True:
        try:
            command, arguments = pipe.recv()
        except (EOFError, KeyboardInterrupt):
            command, arguments = "close", ()
        if command == "close" and lane is None:
            return
        answer: tuple[Any, Exception | None]
        try:
            lane = lane or _LaneWithFacts(cloudpickle.loads(function)())
            answer = getattr(lane, command)(*arguments), None
            pickle.dumps(answer)
        except Exception as error:
            answer = None, _sendable(error)
        if command == "close":
            return
        pipe.send(answer)


class _LaneWithFacts(Lane):
    def facts(self) -> tuple[Any, ...]:
        env = self.env
        return env.observation_space, env.action_space, env.metadata, env.reward_range, env.spec


def _sendable(error: Exception) -> Exception:
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error
