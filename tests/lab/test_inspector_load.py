"""The inspector's server when something goes wrong: errors, floods, slow pages, odd requests, Ctrl-C.

No test compares a time. Where a command has to take long, it takes until the test ends it; see `busy`.
"""

import asyncio
import contextlib
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest
from inspector_tools import receive, serve, served

aiohttp = pytest.importorskip("aiohttp")

from atari.lab.inspector import protocol  # noqa: E402
from atari.lab.inspector.server import MOST_COMMANDS, SECONDS_AFTER_ERROR, InspectionThread, Inspector  # noqa: E402

UPGRADE = (
    "Upgrade: websocket",
    "Connection: Upgrade",
    "Sec-WebSocket-Version: 13",
    f"Sec-WebSocket-Key: {'A' * 22}==",
)


async def get(inspector: Inspector, client: Any) -> None:
    """The page is there."""
    async with client.get(inspector.url) as response:
        assert response.status == 200
        await response.read()


async def assert_plays(inspector: Inspector, page: Any) -> None:
    """The page plays frames."""
    at = inspector.inspection.at
    while inspector.inspection.at < at + 5:
        await page.send_json({"do": "play"})  # again, because an error that is being handled may have paused it
        await receive(page, "frame")


@contextlib.asynccontextmanager
async def busy(inspector: Inspector) -> AsyncIterator[None]:
    """The inspection runs a command that ends with the block."""
    begun, end = threading.Event(), threading.Event()
    command = asyncio.create_task(inspector._thread.call(lambda: begun.set() or end.wait()))
    await asyncio.to_thread(begun.wait)
    try:
        yield
    finally:
        end.set()
        await command


def test_errors_are_shown_and_it_plays_on(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    """Each is logged once, and a loop that fails pauses before it goes on."""
    sleep, pauses = asyncio.sleep, [0]
    failures: dict[str, int] = {}

    async def shorter_sleep(seconds: float) -> None:
        pauses[0] += seconds == SECONDS_AFTER_ERROR
        await sleep(min(seconds, 0.02))

    async def use(inspector: Inspector, client: Any) -> None:
        async with client.ws_connect(inspector.url + "ws") as page:
            for owner, name, command in (
                (inspector.inspection, "tick", "pause"),
                (inspector.inspection, "_play_frame", "play"),
                (protocol, "frame", "pause"),
                (protocol, "overlay", "pause"),
                (inspector.inspection.main, "cut", "fork"),
            ):

                def fail(*arguments: Any, failing: str = name) -> None:
                    failures[failing] = failures.get(failing, 0) + 1
                    raise IndexError("broken on purpose")

                with monkeypatch.context() as broken:
                    broken.setattr(owner, name, fail)
                    await page.send_json({"do": command})
                    assert "broken on purpose" in await receive(page, "error"), name
                await get(inspector, client)
                await assert_plays(inspector, page)

    monkeypatch.setattr(asyncio, "sleep", shorter_sleep)
    serve(use)
    lines = [message for message in caplog.messages if message.startswith("atari lab, ")]
    assert len(lines) == sum(failures.values()) >= len(failures) == 5
    assert all(line.isprintable() for line in lines)
    assert pauses[0] == sum(failures[name] for name in ("tick", "frame", "overlay"))


@served
async def test_an_error_of_an_export_is_an_answer(
    inspector: Inspector, client: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("atari.lab.inspector.export.write", lambda *arguments: {}["no"])
    async with client.get(inspector.url + "export/replay.a26r") as response:
        assert (response.status, await response.text()) == (500, "'no'")
    assert "KeyError('no')" in inspector.inspection.error


@served
async def test_a_slow_page_gets_the_newest_frame_and_nobody_waits_for_it(inspector: Inspector, client: Any) -> None:
    inspection = inspector.inspection
    async with client.ws_connect(inspector.url + "ws") as page:
        await receive(page, "hello")
        reader = page._conn.transport
        reader.pause_reading()
        await page.send_json({"do": "speed", "speed": 16})
        await page.send_json({"do": "play"})
        while inspection.at < 1600 and not inspection.over:
            await asyncio.sleep(0.02)
        at = inspection.at
        reader.resume_reading()
        inspection.pause()
        frames = [at]
        while frames[-1] != inspection.at or len(frames) == 1:
            frames.append(int.from_bytes((await receive(page, "frame"))[4:8], "little"))
        assert len(frames) < at / 4


@pytest.mark.parametrize(
    ("lines", "status"),
    [
        (["Host: 127.0.0.1:PORT"], 200),
        (["Host: 127.0.0.1:PORT", "Origin: http://127.0.0.1:PORT"], 200),
        (["Host: localhost:PORT"], 200),
        (["Host: attacker.example:PORT"], 403),  # DNS rebinding
        (["Host: 127.0.0.1"], 403),
        (["Host: 127.0.0.1:PORT.attacker.example"], 403),
        (["Host: 127.0.0.1:PORT", "Origin: http://attacker.example"], 403),
        (["Host: 127.0.0.1:PORT", "Origin: null"], 403),
        (["Host: 127.0.0.1:PORT", "Origin: http://127.0.0.1:1"], 403),
        (["Host: 127.0.0.1:PORT", "Origin: https://127.0.0.1:PORT"], 403),
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
@served
async def test_other_hosts_other_origins_and_bad_headers_are_refused(
    inspector: Inspector, client: Any, lines: list[str], status: int
) -> None:
    for path, extra, good in (("", (), 200), ("inspector.js", (), 200), ("ws", UPGRADE, 101)):
        reader, writer = await asyncio.open_connection("127.0.0.1", inspector.port)
        head = "\r\n".join([f"GET /{inspector.token}/{path} HTTP/1.1", *lines, *extra, "", ""])
        writer.write(head.replace("PORT", str(inspector.port)).encode())
        found = int((await reader.readline()).split()[1])
        assert found == (good if status == 200 else status) or (status == 403 and found == 400)
        writer.close()


@served
async def test_connections_that_say_nothing_hold_up_nothing(inspector: Inspector, client: Any) -> None:
    silent = [await asyncio.open_connection("127.0.0.1", inspector.port) for _ in range(100)]
    for number, (_, writer) in enumerate(silent):
        writer.write(f"GET /{inspector.token}/ HTTP/1.1\r\nHost: 127.0.0.1:{inspector.port}\r\n".encode()[:number])
    await get(inspector, client)
    async with client.ws_connect(inspector.url + "ws") as page:
        await assert_plays(inspector, page)
    for _, writer in silent:
        writer.close()


@served
async def test_a_flood_is_disconnected_with_a_reason_and_holds_up_nothing(inspector: Inspector, client: Any) -> None:
    async with client.ws_connect(inspector.url + "ws") as page:
        await receive(page, "frame")
        async with busy(inspector):
            for _ in range(MOST_COMMANDS + 2):  # one runs, and one is too many
                await page.send_str("not JSON")
            while (message := await page.receive()).type != aiohttp.WSMsgType.CLOSE:
                assert message.type in (aiohttp.WSMsgType.BINARY, aiohttp.WSMsgType.TEXT)
            assert (message.data, message.extra) == (4002, "the page sent too many commands: 1000 were waiting")
            await get(inspector, client)
    async with client.ws_connect(inspector.url + "ws") as page:
        await assert_plays(inspector, page)


@served
async def test_a_page_that_reads_nothing_holds_up_neither_another_nor_the_end(
    inspector: Inspector, client: Any
) -> None:
    for query in ("ws", "ws?take=1"):
        page = await client.ws_connect(inspector.url + query)
        await receive(page, "frame")
        assert inspector._tab is not None
        reader, writer = page._conn.transport, inspector._tab.socket._req.transport  # type: ignore[union-attr]
        for transport, option in ((reader, socket.SO_RCVBUF), (writer, socket.SO_SNDBUF)):
            transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, option, 4096)
        reader.pause_reading()
        await page.send_json({"do": "play"})
        while writer.get_write_buffer_size() < 1 << 16:  # the page's frames wait from here on
            await asyncio.sleep(0.01)


def test_the_end_interrupts_a_command_and_leaves_out_the_others() -> None:
    begun, thread = threading.Event(), InspectionThread()

    def endless() -> None:
        begun.set()
        while True:
            time.sleep(0.001)

    async def run() -> list[Any]:
        calls = [asyncio.create_task(thread.call(function)) for function in (endless, begun.clear)]
        await asyncio.to_thread(begun.wait)
        thread.stop()
        return await asyncio.gather(*calls, thread.call(begun.clear), return_exceptions=True)

    assert list(map(repr, asyncio.run(run()))) == ["ConnectionError('the inspector has ended')"] * 3
    thread._thread.join(60)
    assert not thread._thread.is_alive()
    assert begun.is_set()


@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals")
def test_ctrl_c_ends_it(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "atari", "lab", "pitfall", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path) as server:
        assert server.stdout is not None
        assert server.stderr is not None
        url = next(line for line in server.stdout if "http://" in line).split()[-1]

        async def run() -> None:
            async with aiohttp.ClientSession() as client, client.ws_connect(url + "ws") as page:
                for _ in range(260):
                    for text in ('{"do": "step", "frames": 3600}', '{"do": "bytes", "x": 80, "y": 100}', "not JSON"):
                        await page.send_str(text)
                server.send_signal(signal.SIGINT)

        asyncio.run(asyncio.wait_for(run(), 60))
        assert (server.wait(60), server.stderr.read()) == (130, "atari: interrupted\n")


def test_a_port_is_free_again_after_it_has_stopped() -> None:
    port = serve(get).port
    with socket.socket() as again:
        again.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        again.bind(("127.0.0.1", port))


@served
async def test_a_command_that_waits_when_the_page_closes_is_left_out(inspector: Inspector, client: Any) -> None:
    async with client.ws_connect(inspector.url + "ws") as page:
        await receive(page, "frame")
        async with busy(inspector):
            for command in ({"do": "poke", "index": 57, "value": 1}, {"do": "play"}):
                await page.send_json(command)
            await page.close()
    while inspector._tab is not None:
        await asyncio.sleep(0.01)
    assert not inspector.inspection.playing
