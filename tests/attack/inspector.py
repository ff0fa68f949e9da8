"""The inspector's server: hostile and valid messages, floods, wrong origins, connections that say nothing or nonsense.

The page must be there within two seconds at any time, the log must stay empty, and the game must play on afterwards.
"""

import asyncio
import contextlib
import json
import logging
import random
import threading
import time
import urllib.request
from collections.abc import Awaitable, Callable, Iterator
from typing import Any

import aiohttp

import atari
from atari.lab.inspector.inspection import Inspection
from atari.lab.inspector.protocol import _COMMANDS
from atari.lab.inspector.server import Inspector

SECONDS_TO_ANSWER = 2.0
NUMBERS = (0, 1, -1, 57, 127, 128, 255, 256, 3600, -3600, 2**31, -(2**63), 2**64, 10**30, 0.5, 1e308, -0.0)
VALUES = (
    *NUMBERS,
    True,
    None,
    "",
    "changed",
    "correlates",
    "x" * 5000,
    "\x1b[0m",
    "<script>",
    "\ud800",
    [],
    {},
    [[[[[[1]]]]]],
)
TEXTS = (
    "",
    "{",
    "[" * 4000,
    "NaN",
    '{"do": "play", "do": "step"}',
    '{"do": ' + "9" * 4000 + "}",
    "\x00",
    '{"do": "__init__"}',
)


def attack(seed: int) -> None:
    """Attack a server for two seconds."""
    source = random.Random(seed)
    records: list[str] = []
    with collected(records), served(source) as inspector:
        end = time.monotonic() + 2
        with watched(inspector.url):
            asyncio.run(all_at_once(source, inspector, end))
        asyncio.run(asyncio.wait_for(plays_on(inspector), 20))
    assert not records, f"the log has {len(records)} lines, such as {records[0]}"


@contextlib.contextmanager
def collected(records: list[str]) -> Iterator[None]:
    """Collect what is logged as a warning or worse."""
    handler = logging.Handler(logging.WARNING)
    handler.emit = lambda record: records.append(handler.format(record))  # type: ignore[method-assign]
    logging.getLogger().addHandler(handler)
    try:
        yield
    finally:
        logging.getLogger().removeHandler(handler)


@contextlib.contextmanager
def served(source: random.Random) -> Iterator[Inspector]:
    """A server in a thread of its own."""
    game = source.choice(("breakout", "pong", "pitfall"))
    inspector = Inspector(Inspection(atari.AtariEnv(game, frameskip=1), seed=source.randrange(100)))
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    try:
        asyncio.run_coroutine_threadsafe(inspector.start(), loop).result(20)
        yield inspector
    finally:
        asyncio.run_coroutine_threadsafe(inspector.stop(), loop).result(5)
        loop.call_soon_threadsafe(loop.stop)
        thread.join()
        loop.close()


@contextlib.contextmanager
def watched(url: str) -> Iterator[None]:
    """The page is there within two seconds, all the time."""
    slowest, ended = 0.0, threading.Event()

    def watch() -> None:
        nonlocal slowest
        while not ended.wait(0.05):
            begun = time.monotonic()
            with urllib.request.urlopen(url, timeout=60) as response:
                assert response.status == 200
            slowest = max(slowest, time.monotonic() - begun)

    thread = threading.Thread(target=watch)
    thread.start()
    yield
    ended.set()
    thread.join()
    assert slowest < SECONDS_TO_ANSWER, f"the page came after {slowest:.1f} seconds"


async def all_at_once(source: random.Random, inspector: Inspector, end: float) -> None:
    """Several attacks beside each other."""
    kinds: list[Callable[[random.Random, Inspector, Any, float], Awaitable[None]]] = [
        commands, commands, flood, slow, odd_requests, nonsense, silent, exports,
    ]  # fmt: skip
    async with aiohttp.ClientSession() as client:
        chosen = [source.choice(kinds) for _ in range(source.choice((1, 2, 4)))]
        attacks = [kind(random.Random(source.random()), inspector, client, end) for kind in chosen]
        done = await asyncio.wait_for(asyncio.gather(*attacks, return_exceptions=True), 30)
    for result in done:
        if isinstance(result, BaseException) and not isinstance(result, (aiohttp.ClientError, ConnectionError)):
            raise result


def command(source: random.Random) -> str:
    """A command, right or wrong."""
    if source.random() < 0.1:
        return source.choice(TEXTS)
    name = source.choice([*_COMMANDS, "", "import"]) if source.random() < 0.9 else source.choice(VALUES)
    message = {"do": name}
    for key, kinds in _COMMANDS.get(str(name), (None, {}))[1].items():
        right = source.randrange(128) if int in (kinds if isinstance(kinds, tuple) else (kinds,)) else True
        right = source.choice(("changed", "equals", "a")) if kinds is str else right
        message[key] = right if source.random() < 0.8 else source.choice(VALUES)
    if source.random() < 0.05:
        message[source.choice(("x", "self", "session", "__class__"))] = 1
    return json.dumps(message, ensure_ascii=source.random() < 0.8 or "\ud800" in message.values())


async def commands(source: random.Random, inspector: Inspector, client: Any, end: float) -> None:
    """A page that sends commands as fast as they are answered, or nearly."""
    while time.monotonic() < end:
        async with client.ws_connect(inspector.url + source.choice(("ws", "ws?take=1"))) as page:
            reader = asyncio.create_task(read(page, end))
            while time.monotonic() < end and not page.closed and source.random() > 0.005:
                if source.random() < 0.02:
                    await page.send_bytes(source.randbytes(source.choice((0, 1, 10_000))))
                else:
                    await page.send_str(command(source))
                await asyncio.sleep(source.choice((0, 0.002, 0.02)))
            reader.cancel()


async def read(page: Any, end: float) -> None:
    """Read what the server sends; every JSON message is an object, and its errors are printable."""
    while time.monotonic() < end and (message := await page.receive()).type in (
        aiohttp.WSMsgType.TEXT,
        aiohttp.WSMsgType.BINARY,
    ):
        if message.type == aiohttp.WSMsgType.TEXT:
            json.loads(message.data)


async def flood(source: random.Random, inspector: Inspector, client: Any, end: float) -> None:
    """A page that sends more than can be done; it is disconnected."""
    text = source.choice(('{"do": "step", "frames": 3600}', '{"do": "bytes", "x": 80, "y": 90}', "x", command(source)))
    while time.monotonic() < end:
        async with client.ws_connect(inspector.url + "ws?take=1") as page:
            with contextlib.suppress(ConnectionError):
                for _ in range(20_000):
                    await page.send_str(text)
                    await asyncio.sleep(0)
                    if time.monotonic() > end:
                        break


async def slow(source: random.Random, inspector: Inspector, client: Any, end: float) -> None:
    """A page that plays and reads nothing."""
    async with client.ws_connect(inspector.url + "ws?take=1") as page:
        page._conn.transport.pause_reading()
        await page.send_str('{"do": "speed", "speed": 16.0}')
        await page.send_str('{"do": "play"}')
        while time.monotonic() < end and not page.closed:
            await page.send_str('{"do": "pixels", "index": 57}')
            await asyncio.sleep(0.01)
        page._conn.transport.resume_reading()


async def odd_requests(source: random.Random, inspector: Inspector, client: Any, end: float) -> None:
    """Requests of other hosts, other origins, other tokens and other forms; none is served."""
    good = f"127.0.0.1:{inspector.port}"
    heads = (
        f"Host: {good}\r\nOrigin: http://attacker.example\r\n",
        f"Host: {good}\r\nOrigin: http://{good}\r\nOrigin: http://attacker.example\r\n",
        f"Host: {good}\r\nHost: attacker.example\r\n",
        "Host: attacker.example\r\n",
        f"Host: {good}\r\nContent-Length: 3\r\nContent-Length: 4\r\n",
        f"Host: {good}\r\nX: {'y' * 100_000}\r\n",
        "",
    )
    while time.monotonic() < end:
        reader, writer = await asyncio.open_connection("127.0.0.1", inspector.port)
        path = source.choice(("", "ws", "export/replay.a26r", "page.js"))
        upgrade = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: QUFBQUFBQUFBQUFBQUFBQQ==\r\n"
        writer.write(f"GET /{inspector.token}/{path} HTTP/1.1\r\n{source.choice(heads)}{upgrade}\r\n".encode())
        status = (await asyncio.wait_for(reader.readline(), SECONDS_TO_ANSWER)).split()
        writer.close()
        assert status[1:2] in ([b"400"], [b"403"]), f"{path} was served: {status}"


async def nonsense(source: random.Random, inspector: Inspector, client: Any, end: float) -> None:
    """Bytes that are no HTTP, and frames that are no frames of a WebSocket."""
    upgrade = (
        f"GET /{inspector.token}/ws HTTP/1.1\r\nHost: 127.0.0.1:{inspector.port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: QUFBQUFBQUFBQUFBQUFBQQ==\r\n\r\n"
    ).encode()
    while time.monotonic() < end:
        _, writer = await asyncio.open_connection("127.0.0.1", inspector.port)
        writer.write(source.choice((b"", upgrade, b"GET / HTTP/1.1\r\n", b"\x16\x03\x01")) + source.randbytes(200))
        with contextlib.suppress(ConnectionError):
            await writer.drain()
        await asyncio.sleep(0.02)
        writer.close()


async def silent(source: random.Random, inspector: Inspector, client: Any, end: float) -> None:
    """Connections that are opened and left."""
    opened = []
    while time.monotonic() < end and len(opened) < 200:
        opened.append(await asyncio.open_connection("127.0.0.1", inspector.port))
        opened[-1][1].write(b"GET /"[: source.randrange(6)])
        await asyncio.sleep(0.005)
    await asyncio.sleep(max(0, end - time.monotonic()))
    for _, writer in opened:
        writer.transport.abort()


async def exports(source: random.Random, inspector: Inspector, client: Any, end: float) -> None:
    """Files that are asked for while others play."""
    names = (
        "replay.a26r",
        "labels.toml",
        "interventions.toml",
        "clip.mp4?start=0&stop=30",
        "clip.mp4?start=x",
        "nothing",
        "..%2fx",
    )
    while time.monotonic() < end:
        async with client.get(inspector.url + "export/" + source.choice(names)) as response:
            assert response.status in (200, 400, 404), f"status {response.status}: {await response.text()}"
            await response.read()


async def plays_on(inspector: Inspector) -> None:
    """A new page takes the inspection over and plays."""
    async with aiohttp.ClientSession() as client, client.ws_connect(inspector.url + "ws?take=1") as page:
        for text in (
            '{"do": "close_fork"}',
            '{"do": "agent", "on": false}',
            '{"do": "new_game"}',
            '{"do": "speed", "speed": 1.0}',
        ):
            await page.send_str(text)
        await page.send_str('{"do": "play"}')
        seen: set[int] = set()
        while len(seen) < 10:
            message = await page.receive()
            assert message.type in (aiohttp.WSMsgType.TEXT, aiohttp.WSMsgType.BINARY), f"the page was closed: {message}"
            if message.type == aiohttp.WSMsgType.BINARY and message.data[1] & 1:
                seen.add(int.from_bytes(message.data[4:8], "little"))
