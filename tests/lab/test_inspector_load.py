"""The inspector's server when something goes wrong: errors, floods, slow pages, odd requests, Ctrl-C."""

import asyncio
import contextlib
import json
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from inspector_tools import receive, serve

aiohttp = pytest.importorskip("aiohttp")

from atari.lab.inspector import protocol  # noqa: E402
from atari.lab.inspector.server import Inspector  # noqa: E402

STEP = '{"do": "step", "frames": 3600}'


FLOODS = (STEP, '{"do": "bytes", "x": 80, "y": 100}', "not JSON")


async def seconds_of_get(inspector: Inspector, client: Any) -> float:
    """The time until the page is there."""
    begun = time.monotonic()
    async with client.get(inspector.url) as response:
        assert response.status == 200
        await response.read()
    return time.monotonic() - begun


async def assert_plays(inspector: Inspector, page: Any) -> None:
    """The page plays frames."""
    at = inspector.inspection.at
    while inspector.inspection.at < at + 5:
        await page.send_json({"do": "play"})  # again, because an error that is being handled may have paused it
        await receive(page, "frame")


def test_errors_are_shown_and_it_plays_on(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    def fail(*arguments: Any) -> None:
        raise IndexError("broken on purpose")

    async def use(inspector: Inspector, client: Any) -> None:
        async with client.ws_connect(inspector.url + "ws") as page:
            for owner, name, command in (
                (inspector.inspection, "tick", "pause"),
                (inspector.inspection, "_play_frame", "play"),
                (protocol, "frame", "pause"),
                (protocol, "overlay", "pause"),
                (inspector.inspection.main, "cut", "fork"),
            ):
                with monkeypatch.context() as broken:
                    broken.setattr(owner, name, fail)
                    await page.send_json({"do": command})
                    assert "broken on purpose" in await receive(page, "error"), name
                assert await seconds_of_get(inspector, client) < 2
                await assert_plays(inspector, page)
        assert 5 <= len(caplog.messages) < 60
        assert all(message.isprintable() for message in caplog.messages)

    serve(use)


def test_an_error_of_an_export_is_an_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("atari.lab.inspector.export.write", lambda *arguments: {}["no"])

    async def use(inspector: Inspector, client: Any) -> None:
        async with client.get(inspector.url + "export/replay.a26r") as response:
            assert (response.status, await response.text()) == (500, "'no'")
        assert "KeyError('no')" in inspector.inspection.error

    serve(use)


def test_commands_that_take_long_hold_up_nothing_else() -> None:
    async def use(inspector: Inspector, client: Any) -> None:
        async with client.ws_connect(inspector.url + "ws") as page:
            for _ in range(20):
                await page.send_str(STEP)
            await asyncio.sleep(0.05)
            assert await seconds_of_get(inspector, client) < 1
        assert inspector.inspection.at < 20 * 3600

    serve(use)


def test_a_slow_page_gets_the_newest_frame_and_nobody_waits_for_it() -> None:
    async def use(inspector: Inspector, client: Any) -> None:
        inspection = inspector.inspection
        async with client.ws_connect(inspector.url + "ws") as page:
            await receive(page, "hello")
            reader = page._conn.transport
            reader.pause_reading()
            await page.send_json({"do": "speed", "speed": 16})
            await page.send_json({"do": "play"})
            while inspection.at < 4000 and not inspection.over:
                await asyncio.sleep(0.02)
            at = inspection.at
            reader.resume_reading()
            inspection.pause()
            frames = [at]
            while frames[-1] != inspection.at or len(frames) == 1:
                frames.append(int.from_bytes((await receive(page, "frame"))[4:8], "little"))
            assert len(frames) < at / 4

    serve(use)


@pytest.mark.parametrize(
    ("lines", "status"),
    [
        (["Host: 127.0.0.1:PORT"], 200),
        (["Host: 127.0.0.1:PORT", "Origin: http://127.0.0.1:PORT"], 200),
        (["Host: 127.0.0.1:PORT", "Origin: http://127.0.0.1:PORT", "Origin: http://attacker.example"], 403),
        (["Host: 127.0.0.1:PORT", "Origin: http://127.0.0.1:PORT", "oRIGIN: http://127.0.0.1:PORT"], 403),
        (["Host: 127.0.0.1:PORT", "Origin: http://127.0.0.1:PORT, http://attacker.example"], 403),
        (["Host: 127.0.0.1:PORT", "Origin:"], 403),
        (["Host: 127.0.0.1:PORT", "Host: attacker.example"], 403),
        (["Host: 127.0.0.1:PORT", "Host: 127.0.0.1:PORT"], 403),
        (["Host: attacker.example", "X-Forwarded-Host: 127.0.0.1:PORT"], 403),
        (["Host:"], 403),
        ([], 403),
        (["Host: 127.0.0.1:PORT", "Content-Length: 0", "Content-Length: 5"], 400),
        (["Host: 127.0.0.1:PORT", "Content-Length: 5", "Transfer-Encoding: chunked"], 400),
        (["Host: 127.0.0.1:PORT", "Content-Length: -1"], 400),
        (["Host: 127.0.0.1:PORT", "X: " + "a" * 10_000], 400),
        (["Host: 127.0.0.1:PORT", *(f"X{number}: {'a' * 4000}" for number in range(20))], 200),
    ],
)
def test_headers_that_are_there_twice_are_refused(lines: list[str], status: int) -> None:
    async def use(inspector: Inspector, client: Any) -> None:
        for path, extra in (
            ("", []),
            (
                "ws",
                [
                    "Upgrade: websocket",
                    "Connection: Upgrade",
                    "Sec-WebSocket-Version: 13",
                    f"Sec-WebSocket-Key: {'A' * 22}==",
                ],
            ),
        ):
            reader, writer = await asyncio.open_connection("127.0.0.1", inspector.port)
            head = "\r\n".join([f"GET /{inspector.token}/{path} HTTP/1.1", *lines, *extra, "", ""])
            writer.write(head.replace("PORT", str(inspector.port)).encode())
            found = int((await reader.readline()).split()[1])
            assert found == (101 if path and status == 200 else status) or (status == 403 and found == 400)
            writer.close()

    serve(use)


def test_connections_that_say_nothing_hold_up_nothing() -> None:
    async def use(inspector: Inspector, client: Any) -> None:
        silent = [await asyncio.open_connection("127.0.0.1", inspector.port) for _ in range(100)]
        for number, (_, writer) in enumerate(silent):
            writer.write(f"GET /{inspector.token}/ HTTP/1.1\r\nHost: 127.0.0.1:{inspector.port}\r\n".encode()[:number])
        assert await seconds_of_get(inspector, client) < 2
        async with client.ws_connect(inspector.url + "ws") as page:
            await assert_plays(inspector, page)
        for _, writer in silent:
            writer.close()

    serve(use)


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[tuple["subprocess.Popen[str]", str]]:
    """`atari lab pitfall`, and its address."""
    command = [sys.executable, "-m", "atari", "lab", "pitfall", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path) as server:
        assert server.stdout is not None
        line = next(line for line in server.stdout if "http://" in line)
        yield server, line.split()[-1]
        server.kill()


@pytest.mark.parametrize("flood", FLOODS)
def test_a_flood_is_disconnected_with_a_reason(lab: tuple["subprocess.Popen[str]", str], flood: str) -> None:
    url = lab[1]

    async def run() -> None:
        async with aiohttp.ClientSession() as client:
            async with client.ws_connect(url + "ws") as page:
                pages = asyncio.create_task(asyncio.to_thread(slowest_page, url, 3.0))
                with contextlib.suppress(ConnectionError):
                    for _ in range(56_000):
                        await page.send_str(flood)
                        await asyncio.sleep(0)
                while (message := await page.receive()).type != aiohttp.WSMsgType.CLOSE:
                    assert message.type in (aiohttp.WSMsgType.BINARY, aiohttp.WSMsgType.TEXT)
                assert (message.data, message.extra) == (4002, "the page sent too many commands: 1000 were waiting")
                assert await pages < 2
            async with client.ws_connect(url + "ws") as page:
                await page.send_json({"do": "play"})
                frames = [int.from_bytes((await receive(page, "frame"))[4:8], "little") for _ in range(10)]
                assert len({*frames}) > 5

    asyncio.run(asyncio.wait_for(run(), 60))


def slowest_page(url: str, seconds: float) -> float:
    """The longest time until the page is there."""
    slowest, end = 0.0, time.monotonic() + seconds
    while (begun := time.monotonic()) < end:
        with urllib.request.urlopen(url, timeout=30) as response:
            assert response.status == 200
        slowest = max(slowest, time.monotonic() - begun)
    return slowest


@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals")
@pytest.mark.parametrize("flood", FLOODS)
def test_ctrl_c_ends_it_at_once(lab: tuple["subprocess.Popen[str]", str], flood: str) -> None:
    server, url = lab

    async def run() -> float:
        async with aiohttp.ClientSession() as client, client.ws_connect(url + "ws") as page:
            for _ in range(800):
                await page.send_str(flood)
            await asyncio.sleep(0.2)
            begun = time.monotonic()
            server.send_signal(signal.SIGINT)
            while server.poll() is None:
                await asyncio.sleep(0.01)
            return time.monotonic() - begun

    seconds = asyncio.run(asyncio.wait_for(run(), 60))
    assert server.stderr is not None
    assert (server.returncode, server.stderr.read()) == (130, "atari: interrupted\n")
    assert seconds < 2


@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals")
def test_a_page_that_reads_nothing_holds_up_neither_another_nor_ctrl_c(
    lab: tuple["subprocess.Popen[str]", str],
) -> None:
    server, url = lab

    async def block(page: Any) -> None:
        """Read nothing until the server's buffers are full."""
        page._conn.transport.pause_reading()
        await page.send_str('{"do": "play"}')
        for _ in range(80):
            await page.send_str('{"do": "pixels", "index": 57}')
            await asyncio.sleep(0.05)

    async def run() -> float:
        async with aiohttp.ClientSession() as client:
            first = await client.ws_connect(url + "ws")
            await block(first)
            second = await asyncio.wait_for(client.ws_connect(url + "ws?take=1"), 2)
            await asyncio.wait_for(receive(second, "frame"), 2)
            await block(second)
            begun = time.monotonic()
            server.send_signal(signal.SIGINT)
            while server.poll() is None and time.monotonic() < begun + 20:
                await asyncio.sleep(0.01)
            return time.monotonic() - begun

    assert asyncio.run(asyncio.wait_for(run(), 60)) < 2
    assert server.returncode == 130


def test_a_port_is_free_again_after_it_has_stopped() -> None:
    port = serve(lambda inspector, client: seconds_of_get(inspector, client)).port  # type: ignore[arg-type, return-value]
    with socket.socket() as again:
        again.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        again.bind(("127.0.0.1", port))


def test_a_command_that_waits_when_the_page_closes_is_left_out() -> None:
    async def use(inspector: Inspector, client: Any) -> None:
        async with client.ws_connect(inspector.url + "ws") as page:
            await receive(page, "frame")
            for command in ({"do": "step", "frames": 3600}, {"do": "poke", "index": 57, "value": 1}, {"do": "play"}):
                await page.send_str(json.dumps(command))
        while inspector._tab is not None:
            await asyncio.sleep(0.01)
        assert not inspector.inspection.playing

    serve(use)
