"""`AsyncVectorEnv`: several environments, each in a process of its own."""

import contextlib
import copy as copying
import multiprocessing
import pickle
import queue
import signal
import time
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from enum import Enum
from typing import Any

import cloudpickle

from atari.classic.core import Env
from atari.classic.spaces import Space
from atari.classic.vector.utils import CloudpickleWrapper, create_shared_memory, read_from_shared_memory
from atari.classic.vector.vector_env import (
    Batches,
    ClosedError,
    NoCallError,
    PendingCallError,
    Results,
    call,
    check_env_fns,
    step_and_reset,
)

_ENDED = "the vector is closed, or one of its processes has ended; make it again"


class AsyncState(Enum):
    """The result of the next `*_wait`."""

    DEFAULT = "default"
    WAITING_RESET = "reset"
    WAITING_STEP = "step"
    WAITING_CALL = "call"


class AsyncVectorEnv(Batches):
    """Steps its environments at the same time, in processes.

    An exception in an environment is raised here.

    Args:
        env_fns: functions that make the environments.
        observation_space: the space of one environment's observations; None means the first environment's.
        action_space: the space of one environment's actions; likewise.
        shared_memory: whether a `worker` writes observations into shared memory; else they come through pipes.
        copy: False returns the same array of observations, `observations`, from each step.
        context: how processes start: "fork", "spawn" or "forkserver"; None means "fork" where the system has it.
        daemon: whether the processes end with this one.
        worker: a function that each process runs instead of this package's, with Gym's arguments: the environment's
            number, the function that makes it, the ends of a pipe here and there, the shared memory and a queue of
            errors. It answers the commands "reset", "step", "seed", "close", "_call" and "_setattr" with a pair of the
            result and whether it succeeded.

    Raises:
        ValueError: there are no functions, or no such context.
        RuntimeError: the shapes of their observations differ.
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
        worker: Callable[..., None] | None = None,
    ) -> None:
        self.env_fns = check_env_fns(env_fns)
        self.shared_memory = shared_memory
        self.parent_pipes: list[Any] = []
        self.processes: list[Any] = []
        self.closed = False
        self.viewer: Any = None
        self._state = AsyncState.DEFAULT
        self._is_foreign = worker is not None
        self._buffer: Any = None
        methods = multiprocessing.get_all_start_methods()
        ctx: Any = multiprocessing.get_context(context or ("fork" if "fork" in methods else None))
        self.error_queue: Any = ctx.Queue() if worker is not None else queue.SimpleQueue()
        try:
            if worker is None:
                self._start(ctx, daemon, _work)
                facts = self._all("facts", [None] * len(self.env_fns))[0]
            else:
                facts = _facts(self.env_fns[0])
                if shared_memory:
                    self._buffer = create_shared_memory(observation_space or facts[0], len(self.env_fns), ctx)
                self._start(ctx, daemon, worker)
            *spaces, self.metadata, self.reward_range, self.spec = facts
            super().__init__(
                len(self.env_fns), observation_space or spaces[0], action_space or spaces[1], is_copied=copy
            )
            if self._buffer is not None:
                self.observations = read_from_shared_memory(self._buffer, self.single_observation_space, self.num_envs)
            self._check_spaces()
        except BaseException:
            self.close()  # the processes wait for a command
            raise

    def reset_async(self, **options: Any) -> None:  # noqa: D102
        self._begin(AsyncState.WAITING_RESET, "reset", [options or None] * self.num_envs)

    def reset_wait(self, timeout: float | None = None, **kwargs: Any) -> Any:
        """The first observations, after `reset_async`.

        Raises:
            multiprocessing.TimeoutError: they took longer than `timeout`, in seconds; they may be waited for again.
        """
        return self._batch(self._wait(AsyncState.WAITING_RESET, timeout))

    def step_async(self, actions: Any) -> None:
        """Begin to step, for the next `step_wait`.

        Raises:
            ValueError: the number of actions is not that of the environments.
        """
        self._begin(AsyncState.WAITING_STEP, "step", self._one_each(actions, "actions"))

    def step_wait(self, timeout: float | None = None, **kwargs: Any) -> Results:
        """The results of a step, after `step_async`.

        Raises:
            gymnasium.error.Error: there are no actions.
            multiprocessing.TimeoutError: it took longer than `timeout`, in seconds; it may be waited for again.
        """
        return self._results(self._wait(AsyncState.WAITING_STEP, timeout))

    def call_async(self, name: str, *args: Any, **kwargs: Any) -> None:  # noqa: D102
        self._begin(AsyncState.WAITING_CALL, "_call", [(name, args, kwargs)] * self.num_envs)

    def call_wait(self, timeout: float | None = None, **kwargs: Any) -> list[Any]:
        """The results of the methods, after `call_async`.

        Raises:
            multiprocessing.TimeoutError: they took longer than `timeout`, in seconds; they may be waited for again.
        """
        return self._wait(AsyncState.WAITING_CALL, timeout)

    def set_attr(self, name: str, values: Any) -> None:  # noqa: D102
        self._all("_setattr", [(name, value) for value in self._checked_values(values)])

    def seed(self, seeds: Any = None, *, seed: Any = None) -> list[Any]:  # type: ignore[override]  # noqa: D102
        return self._all("seed", self._checked_seeds(seeds, seed))

    def close_extras(self, timeout: float | None = None, terminate: bool = False, **kwargs: Any) -> None:
        """Close the environments and end the processes.

        Args:
            timeout: seconds after which processes that still work are terminated; None means to wait.
            terminate: end the processes without closing the environments.
            **kwargs: have no effect.
        """
        for process in self.processes if terminate else ():
            process.terminate()
        for pipe in self.parent_pipes:
            with contextlib.suppress(OSError):  # the process has ended
                pipe.send(("close", None))
        end = None if timeout is None else time.monotonic() + timeout
        for process in self.processes:
            process.join(None if end is None else max(0.0, end - time.monotonic()))
            if process.is_alive():
                process.terminate()
                process.join()
        for pipe in self.parent_pipes:
            pipe.close()

    def _batch(self, observations: Iterable[Any]) -> Any:
        if self._buffer is None:
            return super()._batch(observations)
        return copying.deepcopy(self.observations) if self.copy else self.observations

    def _check_observation_spaces(self) -> bool:
        if self._is_foreign:  # it may not answer this
            return True
        return self._check_fit(facts[0] for facts in self._all("facts", [None] * self.num_envs))

    def _assert_is_running(self) -> None:
        if self.closed:
            raise ClosedError(_ENDED)

    def _poll(self, timeout: float | None = None) -> bool:
        """Whether all processes have answered within `timeout` seconds; True with None, which waits for them later."""
        self._assert_is_running()
        if timeout is None:
            return True
        end = time.monotonic() + timeout
        return all(pipe.poll(max(0.0, end - time.monotonic())) for pipe in self.parent_pipes)

    def _raise_if_errors(self, successes: Sequence[bool]) -> None:
        """Raise the error of a process, from `error_queue`, if one did not succeed."""
        errors = [self.error_queue.get() for success in successes if not success]
        if errors:
            _, kind, value = errors[-1] if self._is_foreign else errors[0]
            raise value if isinstance(value, BaseException) else kind(value)

    def _start(self, context: Any, daemon: bool, worker: Callable[..., None]) -> None:
        for number, function in enumerate(self.env_fns):
            here, there = context.Pipe()
            errors = self.error_queue if self._is_foreign else None
            wrapper: Any = CloudpickleWrapper
            arguments: tuple[Any, ...] = number, wrapper(function), there, here, self._buffer, errors
            if not self._is_foreign:
                arguments = number, cloudpickle.dumps(function), there, None, None, None
            process = context.Process(target=worker, args=arguments, daemon=daemon)
            process.start()
            there.close()
            self.parent_pipes.append(here)
            self.processes.append(process)

    def _begin(self, state: AsyncState, command: str, data: Sequence[Any]) -> None:
        self._assert_is_running()
        if self._state is not AsyncState.DEFAULT:
            pending = self._state.value
            raise PendingCallError(f"{pending}_async() is not finished; call {pending}_wait() first", pending)
        self._send(command, data)
        self._state = state

    def _wait(self, state: AsyncState, timeout: float | None) -> list[Any]:
        self._assert_is_running()
        name = state.value
        if self._state is not state:
            what = "actions" if state is AsyncState.WAITING_STEP else ""
            cure = f"{name}({what})"
            raise NoCallError(
                f"{name}_wait() came before {name}_async({what}); call it first, or {cure}", f"{name}_async"
            )
        if not self._poll(timeout):
            raise multiprocessing.TimeoutError(f"{name}_wait() took longer than {timeout} seconds")
        self._state = AsyncState.DEFAULT
        return self._receive()

    def _all(self, command: str, data: Sequence[Any]) -> list[Any]:
        self._assert_is_running()
        self._send(command, data)
        return self._receive()

    def _send(self, command: str, data: Sequence[Any]) -> None:
        with _named_end():
            for pipe, own in zip(self.parent_pipes, data, strict=True):
                pipe.send((command, own))

    def _receive(self) -> list[Any]:
        with _named_end():
            answers = [pipe.recv() for pipe in self.parent_pipes]
        if not self._is_foreign:
            for number, (value, success) in enumerate(answers):
                if not success:
                    self.error_queue.put((number, type(value), value))
        self._raise_if_errors([success for _, success in answers])
        return [value for value, _ in answers]


@contextlib.contextmanager
def _named_end() -> Iterator[None]:
    """Raise an error that says so if a process has ended."""
    try:
        yield
    except (EOFError, OSError) as error:
        traceback.clear_frames(error.__traceback__)  # CPython 3.13 reports a buffer of theirs that is found as garbage
        raise ClosedError(_ENDED) from None


def _work(number: int, function: bytes, pipe: Any, *_: Any) -> None:
    """Answer the commands of the vector with pairs of a value and True, or of an exception and False, until "close"."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # the parent ends by it a process that has the parent's handler
    env: Any = None
    while True:
        try:
            command, data = pipe.recv()
        except (EOFError, KeyboardInterrupt):
            command, data = "close", None
        if command == "close" and env is None:
            return
        answer: tuple[Any, bool]
        try:
            if env is None:
                env = cloudpickle.loads(function)()
            answer = _COMMANDS[command](env, data), True
            pickle.dumps(answer)
        except Exception as failure:
            answer = _sendable(failure), False
        if command == "close":
            return
        pipe.send(answer)


_COMMANDS: dict[str, Callable[[Any, Any], Any]] = {
    "reset": lambda env, options: env.reset(**options or {}),
    "step": step_and_reset,
    "seed": lambda env, seed: env.seed(seed),
    "_call": lambda env, given: call(env, *given),
    "_setattr": lambda env, given: setattr(env, *given),
    "facts": lambda env, _: _facts_of(env),
    "close": lambda env, _: env.close(),
}


def _facts_of(env: Env) -> tuple[Any, ...]:
    return env.observation_space, env.action_space, env.metadata, env.reward_range, env.spec


def _facts(function: Callable[[], Env]) -> tuple[Any, ...]:
    env = function()
    try:
        return _facts_of(env)
    finally:
        env.close()


def _sendable(failure: Exception) -> Exception:
    try:
        pickle.loads(pickle.dumps(failure))
    except Exception:
        return RuntimeError(f"{type(failure).__name__}: {failure}")
    return failure
