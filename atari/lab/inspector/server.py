"""`serve`: the inspector's page on 127.0.0.1, and the loop that plays its session.

Only a browser on this computer that has the token of the address is served. The header Host is checked, which refuses
pages of other names that resolve to 127.0.0.1 (DNS rebinding). The header Origin is checked, which refuses pages of
other origins.
"""

import asyncio
import contextlib
import errno
import hmac
import secrets
import tempfile
import time
from collections.abc import Awaitable, Callable
from importlib import resources
from pathlib import Path
from typing import Any

import gymnasium

try:
    from aiohttp import WSCloseCode, WSMsgType, web
except ImportError as error:
    raise gymnasium.error.DependencyNotInstalled(
        "the inspector needs aiohttp: pip install 'atari-envs[lab]'"
    ) from error

from atari.lab.inspector import export, protocol
from atari.lab.inspector.session import FRAMES_PER_SECOND, Session

_TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
_SECONDS_UNTIL_REFRESH = 0.25
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
_CLOSE_TAKEN = 4001  # the session went on in another tab


class Inspector:
    """The server of one session. Its `token` is the secret in the address."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.token = secrets.token_urlsafe(24)
        self.port = 0
        self._tab: web.WebSocketResponse | None = None
        self._state = ""  # the state that the tab has
        self._runner: web.AppRunner | None = None
        self._loop: asyncio.Task[None] | None = None

    @property
    def url(self) -> str:
        """The address of the page, with the token."""
        return f"http://127.0.0.1:{self.port}/{self.token}/"

    def app(self) -> web.Application:
        """The application."""
        app = web.Application(middlewares=[self._guard], client_max_size=1 << 16)
        app.router.add_get("/{token}/", self._file)
        app.router.add_get("/{token}/ws", self._socket)
        app.router.add_get("/{token}/export/{name}", self._export)
        app.router.add_get("/{token}/{name}", self._file)
        return app

    async def start(self, port: int = 0) -> None:
        """Begin to serve on 127.0.0.1, on a free port if `port` is 0.

        Raises:
            OSError: the port is taken.
        """
        self._runner = web.AppRunner(self.app(), access_log=None, shutdown_timeout=1)
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
            await self._tab.close(code=WSCloseCode.GOING_AWAY, message=b"the inspector has ended")
        if self._runner is not None:
            await self._runner.cleanup()

    # --- requests

    @web.middleware
    async def _guard(
        self, request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
    ) -> web.StreamResponse:
        """Refuse other hosts, other origins and other tokens, and add the headers."""
        hosts = (f"127.0.0.1:{self.port}", f"localhost:{self.port}")
        origin, token = request.headers.get("Origin"), request.match_info.get("token", "")
        response: web.StreamResponse
        if request.headers.getall("Host", []) not in ([hosts[0]], [hosts[1]]):
            response = web.Response(status=403, text="The inspector is only served at 127.0.0.1.")
        elif origin is not None and origin not in (f"http://{host}" for host in hosts):
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
        if not response.prepared:
            response.headers.update(_HEADERS)
        return response

    async def _file(self, request: web.Request) -> web.StreamResponse:
        name = request.match_info.get("name", "index.html")
        static = resources.files("atari.lab.inspector") / "static"
        kind = _TYPES.get(Path(name).suffix)
        if kind is None or name not in {file.name for file in static.iterdir()}:
            raise web.HTTPNotFound(text=f"There is no {name!r} here.")
        return web.Response(body=(static / name).read_bytes(), content_type=kind, charset="utf-8")

    async def _export(self, request: web.Request) -> web.StreamResponse:
        name, session = request.match_info["name"], self.session
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, f"{session.game.id}-{name}")
            try:
                if name in export.NAMES:
                    export.write(session, name, path)
                elif name == "clip.mp4":
                    start, stop = (int(request.query.get(key, "-1")) for key in ("start", "stop"))
                    await asyncio.to_thread(export.write_clip, session, path, start, stop)
                else:
                    raise web.HTTPNotFound(text=f"There is no export {name!r}.")
            except (ValueError, OSError, RuntimeError, gymnasium.error.Error) as error:
                return web.Response(status=400, text=str(error))
            disposition = {"Content-Disposition": f'attachment; filename="{path.name}"'}
            return web.Response(body=path.read_bytes(), content_type="application/octet-stream", headers=disposition)

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        """The tab's connection. There is one at a time; a second one gets a message, and may take the session over."""
        socket = web.WebSocketResponse(heartbeat=20, max_msg_size=1 << 16, compress=False)
        await socket.prepare(request)
        if self._tab is not None and not self._tab.closed:
            if request.query.get("take") != "1":
                await socket.send_json({"refused": "This session is open in another tab."})
                await socket.close()
                return socket
            old, self._tab = self._tab, None
            with contextlib.suppress(ConnectionError):
                await old.send_json({"refused": "This session went on in another tab."})
                await old.close(code=_CLOSE_TAKEN)
        self._tab, self._state = socket, ""
        try:
            await socket.send_json(protocol.hello(self.session))
            await socket.send_json(protocol.state(self.session))
            async for message in socket:
                if message.type == WSMsgType.TEXT:
                    for answer in protocol.run(self.session, message.data):
                        await socket.send_json(answer)
        except ConnectionError:
            pass
        finally:
            if self._tab is socket:  # closed, not taken over
                self._tab = None
                self.session.pause()
        return socket

    # --- the session

    async def _play(self) -> None:
        """Play the session and send its frames, 60 a second."""
        due = time.perf_counter()
        sent: tuple[Any, ...] = ()
        last = 0.0
        while True:
            due += 1 / FRAMES_PER_SECOND
            now = time.perf_counter()
            if now - due > _MOST_LAG:
                due = now
            await asyncio.sleep(max(0, due - now))
            # Always the same time, and not the time that has passed: at normal speed each message has one frame more.
            self.session.tick(1 / FRAMES_PER_SECOND)
            now = time.perf_counter()
            tab = self._tab
            if tab is None or tab.closed:
                sent = ()
                continue
            key = (id(tab), self.session.version)
            if key == sent and now - last < _SECONDS_UNTIL_REFRESH:
                continue
            with contextlib.suppress(ConnectionError, RuntimeError):
                await self._send(tab)
            sent, last = key, now

    async def _send(self, tab: web.WebSocketResponse) -> None:
        await tab.send_bytes(protocol.frame(self.session))
        self._state, messages = protocol.news(self.session, self._state)
        for message in messages:
            await tab.send_json(message)


def serve(
    session: Session, *, port: int = 0, browser: Callable[[str], Any] | None = None, ready: Callable[[str], Any] = print
) -> None:
    """Serve the page of a session until Ctrl-C.

    Args:
        session: the session to show.
        port: a port of 127.0.0.1; 0 takes a free port.
        browser: called with the address, such as `webbrowser.open`.
        ready: called with the address first.

    Raises:
        OSError: the port is taken.
    """

    async def run() -> None:
        inspector = Inspector(session)
        await inspector.start(port)
        try:
            ready(inspector.url)
            if browser is not None:
                await asyncio.to_thread(browser, inspector.url)
            await asyncio.Event().wait()
        finally:
            await inspector.stop()

    asyncio.run(run())
