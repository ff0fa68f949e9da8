"""`Tab`: the connection of a page to a session, with bounded queues."""

import asyncio
import contextlib
import time
from collections.abc import Awaitable, Callable
from typing import Any

from aiohttp import WSMsgType, web

from atari.lab.inspector import protocol
from atari.lab.inspector.session import Session
from atari.lab.inspector.worker import Worker

MOST_COMMANDS = 1000
"""The most commands of a page that wait; a page that sends more is disconnected."""

SECONDS_AFTER_ERROR = 1.0
"""Between the repetitions of an error."""

SECONDS_TO_CLOSE = 0.3
_TOO_MANY = 4002
_SECONDS_UNTIL_REFRESH = 0.25


class Tab:
    """A page. Its commands run one after another; it gets the newest frame, as often as it can take one.

    Args:
        socket: the connection, prepared.
        session: the session.
        worker: the thread that uses the session.
    """

    def __init__(self, socket: web.WebSocketResponse, session: Session, worker: Worker) -> None:
        self.socket = socket
        self._session = session
        self._worker = worker
        self._commands: asyncio.Queue[str] = asyncio.Queue(MOST_COMMANDS)
        self._due = asyncio.Event()
        self._sent = (-1, 0.0)  # version and time of the newest frame that was sent
        self._state = ""  # the state that the page has

    async def serve(self) -> None:
        """Send frames and run commands until the connection ends."""
        for first in (protocol.hello, protocol.state):
            await self.socket.send_json(await self._worker.call(first, self._session))
        tasks = [asyncio.create_task(self._repeat(step)) for step in (self._run_command, self._send_frame)]
        try:
            async for message in self.socket:
                if message.type == WSMsgType.TEXT:
                    self._commands.put_nowait(message.data)
        except asyncio.QueueFull:
            await self.close(_TOO_MANY, f"the page sent too many commands: {MOST_COMMANDS} were waiting")
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def close(self, code: int, reason: str, refused: str = "") -> None:
        """Close the connection; the page shows `refused` or the reason. A page that does not read is not waited for."""

        async def close() -> None:
            if refused:
                await self.socket.send_json({"refused": refused})
            await self.socket.close(code=code, message=reason.encode())

        with contextlib.suppress(asyncio.TimeoutError, ConnectionError):
            await asyncio.wait_for(close(), SECONDS_TO_CLOSE)

    def update(self) -> None:
        """Send a frame if the session has changed since the last one, or that was a while ago."""
        version, sent = self._sent
        if self._session.version != version or time.perf_counter() - sent >= _SECONDS_UNTIL_REFRESH:
            self._due.set()

    async def _repeat(self, step: Callable[[], Awaitable[Any]]) -> None:
        """Repeat a step until the connection ends. The page shows errors."""
        while True:
            try:
                await step()
            except ConnectionError:
                return
            except Exception as error:
                self._session.fail(error)
                await self.socket.send_json({"error": self._session.error})
                await asyncio.sleep(SECONDS_AFTER_ERROR)

    async def _run_command(self) -> None:
        for answer in await self._worker.call(protocol.run, self._session, await self._commands.get()):
            await self.socket.send_json(answer)

    async def _send_frame(self) -> None:
        await self._due.wait()
        self._due.clear()
        self._sent = self._session.version, time.perf_counter()
        frame, (self._state, messages) = await self._worker.call(self._present)
        await self.socket.send_bytes(frame)
        for message in messages:
            await self.socket.send_json(message)

    def _present(self) -> tuple[bytes, tuple[str, list[dict[str, Any]]]]:
        return protocol.frame(self._session), protocol.news(self._session, self._state)
