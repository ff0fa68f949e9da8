"""`Worker`: a thread in which a session is used, so that the server answers while a command runs."""

import asyncio
import ctypes
import threading
from collections.abc import Callable
from concurrent.futures import Future
from queue import SimpleQueue
from typing import Any, TypeVar

T = TypeVar("T")
_SECONDS_TO_END = 0.3
_ENDED = "the inspector has ended"


class Worker:
    """A thread that runs one call after another. It ends with the process, also in the middle of a call."""

    def __init__(self) -> None:
        self._calls: SimpleQueue[tuple[Future[Any], Callable[..., Any], tuple[Any, ...]] | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="atari lab", daemon=True)
        self._thread.start()

    async def call(self, function: Callable[..., T], *arguments: Any) -> T:
        """The result of a call, or its error. A call that is cancelled before it begins is left out.

        Raises:
            ConnectionError: the thread has ended.
        """
        future: Future[T] = Future()
        self._calls.put((future, function, arguments))
        if not self._thread.is_alive():
            self._drop_calls()
        return await asyncio.wrap_future(future)

    def stop(self) -> None:
        """End the thread, also in the middle of a call: Ctrl-C must not wait for an export of half an hour of play."""
        self._calls.put(None)
        self._thread.join(_SECONDS_TO_END)
        if self._thread.is_alive():
            thread = ctypes.c_ulong(self._thread.ident or 0)
            ctypes.pythonapi.PyThreadState_SetAsyncExc(thread, ctypes.py_object(SystemExit))
            self._thread.join(_SECONDS_TO_END)
        self._drop_calls()

    def _drop_calls(self) -> None:
        while not self._calls.empty():
            if (call := self._calls.get()) and call[0].set_running_or_notify_cancel():
                call[0].set_exception(ConnectionError(_ENDED))

    def _run(self) -> None:
        while (call := self._calls.get()) is not None:
            future, function, arguments = call
            if not future.set_running_or_notify_cancel():
                continue
            try:
                future.set_result(function(*arguments))
            except Exception as error:
                future.set_exception(error)
            except SystemExit:  # of `stop`
                future.set_exception(ConnectionError(_ENDED))
                return
