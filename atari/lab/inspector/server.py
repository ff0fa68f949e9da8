"""`serve`: the inspector's page on 127.0.0.1, its connection and its thread, and the loop that plays its inspection.

Only a browser on this computer that has the token of the address is served. The header Host is checked, which refuses
pages of other names that resolve to 127.0.0.1 (DNS rebinding). The header Origin is checked, which refuses pages of
other origins.
"""

import asyncio
import contextlib
import ctypes
import errno
import hmac
import logging
import secrets
import tempfile
import threading
import time
from collections.abc import Awaitable, Callable, Mapping
from concurrent.futures import Future
from functools import partial
from importlib import resources
from pathlib import Path
from queue import SimpleQueue
from typing import Any, TypeVar
from urllib.parse import quote

import gymnasium

from atari.base.extras import install_extra
from atari.base.program import ctrl_c_as_event

try:
    from aiohttp import WSCloseCode, WSMsgType, web
    from aiohttp.http_exceptions import HttpProcessingError
except ImportError as error:
    raise gymnasium.error.DependencyNotInstalled(f"the inspector needs aiohttp: {install_extra('lab')}") from error

from atari.lab.inspector import export, protocol
from atari.lab.inspector.inspection import FRAMES_PER_SECOND, Inspection

_TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
_MOST_MESSAGE = 1 << 13  # bytes
_MOST_LAG = 0.1  # seconds; after a longer delay the frames that were due are left out
_HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
_CLOSE_TAKEN = 4001  # the inspection went on in another tab

MOST_COMMANDS = 1000
"""The most commands of a page that wait; a page that sends more is disconnected."""

SECONDS_AFTER_ERROR = 1.0
"""Between the repetitions of an error."""

SECONDS_TO_CLOSE = 0.3
"""The time that a page has to answer a close, and the inspection's thread to end."""
_SECONDS_TO_READ = 20
"""The time that a page which has sent too many commands has to answer a close: it sends the rest of them first."""

_TOO_MANY = 4002
_SECONDS_UNTIL_REFRESH = 0.25
_SECONDS_BETWEEN_LOOKS = 0.05

T = TypeVar("T")
_ENDED = "the inspector has ended"


class InspectionThread:
    """The thread in which an inspection is used, so that the server answers while a command runs.

    It runs one call after another, and ends with the process, also in the middle of a call.
    """

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
        self._thread.join(SECONDS_TO_CLOSE)
        if self._thread.is_alive():
            thread = ctypes.c_ulong(self._thread.ident or 0)
            ctypes.pythonapi.PyThreadState_SetAsyncExc(thread, ctypes.py_object(SystemExit))
            self._thread.join(SECONDS_TO_CLOSE)
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


class Tab:
    """A page. Its commands run one after another; it gets the newest frame, as often as it can take one.

    Args:
        socket: the connection, prepared.
        inspection: the inspection.
        thread: the thread that uses the inspection.
    """

    def __init__(self, socket: web.WebSocketResponse, inspection: Inspection, thread: InspectionThread) -> None:
        self.socket = socket
        self._inspection = inspection
        self._thread = thread
        self._commands: asyncio.Queue[str] = asyncio.Queue(MOST_COMMANDS)
        self._due = asyncio.Event()
        self._sent = (-1, 0.0)  # version and time of the newest frame that was sent
        self._state = ""  # the state that the page has

    async def serve(self) -> None:
        """Send frames and run commands until the connection ends."""
        for first in (protocol.hello, protocol.state):
            await self.socket.send_json(await self._thread.call(first, self._inspection))
        tasks = [asyncio.create_task(self._repeat(step)) for step in (self._run_command, self._send_frame)]
        try:
            async for message in self.socket:
                if message.type == WSMsgType.TEXT:
                    self._commands.put_nowait(message.data)
        except asyncio.QueueFull:
            for task in tasks:
                task.cancel()
            why = f"the page sent too many commands: {MOST_COMMANDS} were waiting"
            await self.close(_TOO_MANY, why, seconds=_SECONDS_TO_READ)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def close(self, code: int, reason: str, refused: str = "", seconds: float = SECONDS_TO_CLOSE) -> None:
        """Close the connection; the page shows `refused` or the reason. A page that does not read is not waited for."""

        async def close() -> None:
            if refused:
                await self.socket.send_json({"refused": refused})
            await self.socket.close(code=code, message=reason.encode())

        with contextlib.suppress(asyncio.TimeoutError, ConnectionError):
            await asyncio.wait_for(close(), seconds)

    def update(self) -> None:
        """Send a frame if the inspection has changed since the last one, or that was a while ago."""
        version, sent = self._sent
        if self._inspection.version != version or time.perf_counter() - sent >= _SECONDS_UNTIL_REFRESH:
            self._due.set()

    async def _repeat(self, step: Callable[[], Awaitable[Any]]) -> None:
        """Repeat a step until the connection ends. The page shows errors."""
        while True:
            try:
                await step()
            except ConnectionError:
                return
            except Exception as error:
                self._inspection.fail(error)
                await self.socket.send_json({"error": self._inspection.error})
                await asyncio.sleep(SECONDS_AFTER_ERROR)

    async def _run_command(self) -> None:
        for answer in await self._thread.call(protocol.run, self._inspection, await self._commands.get()):
            await self.socket.send_json(answer)

    async def _send_frame(self) -> None:
        await self._due.wait()
        self._due.clear()
        self._sent = self._inspection.version, time.perf_counter()
        frame, (self._state, messages) = await self._thread.call(
            lambda: (protocol.frame(self._inspection), protocol.news(self._inspection, self._state))
        )
        await self.socket.send_bytes(frame)
        for message in messages:
            await self.socket.send_json(message)


class Inspector:
    """The server of one inspection. Its `token` is the secret in the address."""

    def __init__(self, inspection: Inspection) -> None:
        self.inspection = inspection
        self.token = secrets.token_urlsafe(24)
        self.port = 0
        self._thread = InspectionThread()
        self._tab: Tab | None = None
        self._runner: web.AppRunner | None = None
        self._loop: asyncio.Task[None] | None = None

    @property
    def url(self) -> str:
        """The address of the page, with the token."""
        return f"http://127.0.0.1:{self.port}/{self.token}/"

    async def start(self, port: int = 0) -> None:
        """Begin to serve on 127.0.0.1, on a free port if `port` is 0.

        Raises:
            OSError: the port is taken.
        """
        app = web.Application(client_max_size=1 << 16)
        for path, handler in (
            ("/{token}/", self._file),
            ("/{token}/ws", self._socket),
            ("/{token}/export/{name}", self._export),
            ("/{token}/{name}", self._file),
        ):
            app.router.add_get(path, partial(self._guard, handler))
        app.router.add_route("*", "/{rest:.*}", partial(self._guard, self._nothing))
        self._runner = web.AppRunner(app, access_log=None, logger=_logger(), shutdown_timeout=SECONDS_TO_CLOSE)
        await self._runner.setup()
        try:
            await web.TCPSite(self._runner, "127.0.0.1", port).start()
        except OSError as error:
            await self._runner.cleanup()
            if error.errno in (errno.EADDRINUSE, errno.EACCES):
                what = "is taken" if error.errno == errno.EADDRINUSE else "may not be used"
                raise OSError(
                    f"port {port} {what}; choose another with --port, or leave it out for a free one"
                ) from None
            raise
        self.port = int(self._runner.addresses[0][1])
        self._loop = asyncio.create_task(self._play())

    async def stop(self) -> None:
        """Close the tab and the server."""
        if self._loop is not None:
            self._loop.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._loop
        if self._tab is not None:
            await self._tab.close(WSCloseCode.GOING_AWAY, "the inspector has ended")
        if self._runner is not None:
            await self._runner.cleanup()
        self._thread.stop()

    # --- requests

    async def _guard(
        self, handler: Callable[[web.Request], Awaitable[web.StreamResponse]], request: web.Request
    ) -> web.StreamResponse:
        """Refuse other hosts, other origins and other tokens, and add the headers."""
        hosts = (f"127.0.0.1:{self.port}", f"localhost:{self.port}")
        token = request.match_info.get("token", "")
        response: web.StreamResponse
        if request.headers.getall("Host", []) not in [[host] for host in hosts]:
            response = web.Response(status=403, text="The inspector is only served at 127.0.0.1.")
        elif request.headers.getall("Origin", []) not in [[], *([f"http://{host}"] for host in hosts)]:
            response = web.Response(status=403, text="Pages of other origins may not use the inspector.")
        elif not hmac.compare_digest(token.encode("utf-8", "replace"), self.token.encode()):
            response = web.Response(
                status=403, text="The address has no valid token. Use the whole address that `atari lab` has printed."
            )
        else:
            try:
                response = await handler(request)
            except web.HTTPException as refused:
                response = web.Response(status=refused.status, text=refused.text)
            except ConnectionError:
                response = web.Response(status=400, text="The connection was lost.")
            except Exception as error:
                self.inspection.fail(error)
                response = web.Response(status=500, text=str(error))
        if not response.prepared:
            response.headers.update(_HEADERS)
        return response

    async def _nothing(self, request: web.Request) -> web.StreamResponse:
        raise web.HTTPNotFound(text=f"There is no {request.path!r} here.")

    async def _file(self, request: web.Request) -> web.StreamResponse:
        name = request.match_info.get("name", "index.html")
        static = resources.files("atari.lab.inspector") / "static"
        kind = _TYPES.get(Path(name).suffix)
        if kind is None or name not in {file.name for file in static.iterdir()}:
            raise web.HTTPNotFound(text=f"There is no {name!r} here.")
        return web.Response(body=(static / name).read_bytes(), content_type=kind, charset="utf-8")

    async def _export(self, request: web.Request) -> web.StreamResponse:
        try:
            name, content = await self._thread.call(self._exported, request.match_info["name"], request.query)
        except (ValueError, OSError, RuntimeError, gymnasium.error.Error) as error:
            return web.Response(status=400, text=str(error))
        disposition = {"Content-Disposition": f'attachment; filename="{quote(name)}"'}
        return web.Response(body=content, content_type="application/octet-stream", headers=disposition)

    def _exported(self, name: str, query: Mapping[str, str]) -> tuple[str, bytes]:
        """The name of the file of an export, and its content."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, f"export-{name}")
            if name in export.NAMES:
                export.write(self.inspection, name, path)
            elif name == "clip.mp4":
                start, stop = (int(query.get(key, "-1")) for key in ("start", "stop"))
                export.write_clip(self.inspection, path, start, stop)
            else:
                raise web.HTTPNotFound(text=f"There is no export {name!r}.")
            return f"{self.inspection.game.id}-{name}", path.read_bytes()

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        """The tab's connection. There is one at a time; a second one gets a message, and may take its place."""
        socket = web.WebSocketResponse(
            heartbeat=20, max_msg_size=_MOST_MESSAGE, compress=False, timeout=_SECONDS_TO_READ
        )
        await socket.prepare(request)
        old = None if self._tab is None or self._tab.socket.closed else self._tab
        if old is not None and request.query.get("take") != "1":
            await socket.send_json({"refused": "This session is open in another tab."})
            await socket.close()
            return socket
        self._tab = tab = Tab(socket, self.inspection, self._thread)
        if old is not None:
            await old.close(_CLOSE_TAKEN, "taken over", refused="This session went on in another tab.")
        with contextlib.suppress(ConnectionError):
            try:
                await tab.serve()
            finally:
                if self._tab is tab:  # closed, not taken over
                    self._tab = None
                    await self._thread.call(self.inspection.pause)
        return socket

    # --- the inspection

    async def _play(self) -> None:
        """Play the inspection, 60 frames a second."""
        due = time.perf_counter()
        while True:
            due += 1 / FRAMES_PER_SECOND
            now = time.perf_counter()
            if now - due > _MOST_LAG:
                due = now
            await asyncio.sleep(max(0, due - now))
            # Always the same time, and not the time that has passed: at normal speed each message has one frame more.
            try:
                await self._thread.call(self.inspection.tick, 1 / FRAMES_PER_SECOND)
            except Exception as error:
                self.inspection.fail(error)
                await asyncio.sleep(SECONDS_AFTER_ERROR)
            if self._tab is not None:
                self._tab.update()


def _logger() -> logging.Logger:
    """The log of aiohttp's server, without the tracebacks of requests that are no HTTP: these are answered by 400.

    `logging` does not keep it, so that it does not keep this module to the end of the process.
    """
    log = logging.Logger(__name__)
    log.parent = logging.getLogger()
    log.addFilter(lambda record: not (record.exc_info and isinstance(record.exc_info[1], HttpProcessingError)))
    return log


def serve(
    inspection: Inspection,
    *,
    port: int = 0,
    browser: Callable[[str], Any] | None = None,
    ready: Callable[[str], Any] = print,
) -> None:
    """Serve the page of an inspection until Ctrl-C.

    Args:
        inspection: the inspection to show.
        port: a port of 127.0.0.1; 0 takes a free port.
        browser: called with the address, such as `webbrowser.open`.
        ready: called with the address first.

    Raises:
        OSError: the port is taken.
    """

    async def run(interrupted: threading.Event) -> None:
        inspector = Inspector(inspection)
        await inspector.start(port)
        try:
            ready(inspector.url)
            if browser is not None:
                await asyncio.to_thread(browser, inspector.url)
            while not interrupted.is_set():
                await asyncio.sleep(_SECONDS_BETWEEN_LOOKS)
        finally:
            await inspector.stop()

    # An exception in the middle of a request would be the request's, which prints it.
    with ctrl_c_as_event("atari: interrupted") as interrupted:
        asyncio.run(run(interrupted))
    if interrupted.is_set():
        raise KeyboardInterrupt
