"""The inspector's server: who is served, the messages, one tab at a time."""

import asyncio
import json
import signal
import socket
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from inspector_tools import new_inspection, receive, served

aiohttp = pytest.importorskip("aiohttp")

from atari.cli import main  # noqa: E402
from atari.lab.inspector import protocol  # noqa: E402
from atari.lab.inspector.server import Inspector  # noqa: E402
from atari.task import Task  # noqa: E402


@served
async def test_only_the_token_opens_the_page(inspector: Inspector, client: Any) -> None:
    async with client.get(inspector.url) as response:
        assert response.status == 200
        assert "script-src 'self'" in response.headers["Content-Security-Policy"]
        assert response.headers["Referrer-Policy"] == "no-referrer"
        assert "page.js" in await response.text()
    base = f"http://127.0.0.1:{inspector.port}"
    wrong = inspector.token[:-1] + ("a" if inspector.token[-1] != "a" else "b")
    wrongs = [f"/{wrong}/{path}" for path in ("", "ws", "export/replay.a26r")]
    for path in ("/", "/inspector.js", *wrongs, "/%C3%A9/", "/x/y/z/"):
        async with client.get(base + path) as response:
            assert response.status == 403, path
    for path in ("inspection.py", "..%2fsession.py", "nothing.js", "export/passwd"):
        async with client.get(inspector.url + path) as response:
            assert response.status == 404, path


@served
async def test_frames_and_commands(inspector: Inspector, client: Any) -> None:
    core = inspector.inspection.main.core
    async with client.ws_connect(inspector.url + "ws") as tab:
        hello = await receive(tab, "hello")
        assert (hello["game"], hello["height"]) == ("breakout", 210)
        assert hello["labels"]["57"] == ["lives"]
        frame = await receive(tab, "frame")
        assert len(frame) == 32 + 128 + 210 * 160
        assert frame[32:160] == core.ram().tobytes()
        assert np.array_equal(np.frombuffer(frame[160:], np.uint8).reshape(210, 160), core.screen())
        await tab.send_json({"do": "poke", "index": 57, "value": 3})
        await tab.send_json({"do": "select", "index": 57})
        while (frame := await receive(tab, "frame"))[32 + 57] != 3 or len(frame) == 32 + 128 + 210 * 160:
            pass
        assert frame[1] & 8  # a preview
        assert frame[-242] == 57
        await tab.send_json({"do": "bytes", "x": 100, "y": 192})
        assert 72 in (await receive(tab, "bytes"))["found"]
        await tab.send_json({"do": "pixels", "index": 72})
        assert (await receive(tab, "pixels"))["count"] > 20
        for command, text in (
            ("x", "a command is damaged: Expecting value"),
            ("[" * 5000, "it has 5,000 bytes, and 4,096 are allowed"),
            ("[" * 4000, "nested more than 4 deep"),
            ('{"do": "import os"}', "whose `do` is one of"),
            ('{"do": ["play"]}', "whose `do` is one of"),
            ('{"do": "play", "do": "pause"}', "the key 'do' is there twice"),
            ('{"do": "poke", "index": "57", "value": 1}', "poke: 'index' must be a whole number, got '57'"),
            ('{"do": "poke", "index": true, "value": 1}', "'index' must be a whole number, got True"),
            ('{"do": "poke", "index": 57}', "the command poke needs the key 'value'"),
            ('{"do": "poke", "index": 57, "value": 256}', "256"),
            ('{"do": "name", "index": 57, "name": "\\u001b"}', "control character"),
            ('{"do": "speed", "speed": NaN}', "NaN is no number of JSON"),
            ('{"do": "seek", "frame": 1e400}', "out of range"),
            ('{"do": "play", "x": 1}', "the command play has no key 'x'"),
            ('{"do": "seek", "frame": 1e3}', "'frame' must be a whole number, got 1000.0"),
        ):
            await tab.send_str(command)
            assert text in await receive(tab, "error"), command


@served
async def test_it_plays_sixty_frames_a_second_and_a_closed_tab_pauses(inspector: Inspector, client: Any) -> None:
    inspection = inspector.inspection
    async with client.ws_connect(inspector.url + "ws") as tab:
        await tab.send_json({"do": "play"})
        while inspection.at < 20:
            await receive(tab, "frame")
        assert inspection.playing
    while inspection.playing:
        await asyncio.sleep(0.01)
    assert inspection.at >= 20


@served
async def test_a_second_tab_is_told_and_can_take_the_session_over(inspector: Inspector, client: Any) -> None:
    first = await client.ws_connect(inspector.url + "ws")
    await receive(first, "frame")
    async with client.ws_connect(inspector.url + "ws") as second:
        assert await receive(second, "refused") == "This session is open in another tab."
        assert (await second.receive()).type == aiohttp.WSMsgType.CLOSE
    inspector.inspection.play()
    async with client.ws_connect(inspector.url + "ws?take=1") as third:
        await receive(third, "hello")
        assert await receive(first, "refused") == "This session went on in another tab."
        await first.close()
        await receive(third, "frame")
        assert inspector.inspection.playing  # the first tab was not closed by the user


@served
async def test_exports(inspector: Inspector, client: Any) -> None:
    async with client.get(inspector.url + "export/replay.a26r") as response:
        assert (response.status, await response.text()) == (400, "no frame was played; there is nothing to export")
    inspector.inspection.step(30)
    async with client.get(inspector.url + "export/replay.a26r") as response:
        assert response.status == 200
        assert response.headers["Content-Disposition"] == 'attachment; filename="breakout-replay.a26r"'
        assert len(await response.read()) > 100
    async with client.get(inspector.url + "export/clip.mp4?start=x&stop=2") as response:
        assert response.status == 400


def test_a_taken_port_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["lab", "pong", "--no-browser", "--port", str(port)]) == 1
    assert capsys.readouterr().err == (
        f"atari: error: port {port} is taken; choose another with --port, or leave it out for a free one\n"
    )


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["pon"], "did you mean 'pong'?"),
        (["pong", "--agent", "nothing:here"], "nothing:here cannot be imported"),
        (["nothing.a26r"], "nothing.a26r"),
        (["."], "no run folder"),
        ([".", "--rom", "a.bin"], "leave --agent and --rom out"),
        ([".", "--sticky", "0.25"], ". says what is played; leave --repeat-action-probability out"),
        (["game.a26r", "--seed", "1"], "game.a26r says what is played; leave --seed out"),
        (["game.a26r", "--mode", "1"], "game.a26r says what is played; leave --mode out"),
        (["pong", "--port", "70000"], "argument --port: '70000' is not a whole number within 0..65535"),
    ],
)
def test_mistakes_on_the_command_line(words: list[str], text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["lab", *words, "--no-browser"]) == (2 if "--port" in words else 1)
    assert text in capsys.readouterr().err


def test_it_plays_what_game_and_flags_say(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    words = ["--mode", "1", "--intervention", "lazy_enemy", "--print-task", "--json"]
    assert main(["lab", "ALE/Pong-ram-v5", *words]) == 0
    task = Task.from_json(capsys.readouterr().out)
    played = {"mode": 1, "interventions": ["lazy_enemy"], "frameskip": 1, "actions": "full"}
    assert task == Task.of("pong", **played)
    (tmp_path / "task.json").write_text(task.replace(noops=(1, 30)).to_json())
    assert main(["lab", str(tmp_path / "task.json")]) == 1
    assert "`atari lab` has no place for noops=(1, 30); give the game alone" in capsys.readouterr().err


def test_without_aiohttp(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("atari.cli.lab.find_spec", lambda name: None)
    assert main(["lab", "pong"]) == 1
    assert f"atari lab needs aiohttp: {sys.executable} -m pip install 'aiohttp>=3.9'" in capsys.readouterr().err


def test_without_a_browser_the_address_is_printed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("webbrowser.open", lambda url: bool(signal.raise_signal(signal.SIGINT)))
    assert main(["lab", "pong"]) == 130
    out, err = capsys.readouterr()
    first, second, *_ = out.splitlines()
    assert first == "pong: Pong, as PongNoFrameskip-v4, but actions='full', max_num_frames_per_episode=None"
    assert second.startswith("Pong: http://127.0.0.1:")
    assert "no browser could be opened; open the address above in one" in err


def test_a_frame_with_a_fork() -> None:
    inspection = new_inspection("breakout")
    inspection.open_fork()
    inspection.poke(57, 2)
    frame = protocol.frame(inspection)
    assert frame[1] == 16 | 32
    assert (frame[32 + 57], frame[160 + 210 * 160 + 57]) == (5, 2)


def test_the_version_counts_frames_and_the_commands_that_change_something() -> None:
    inspection = new_inspection("pong")
    versions = [inspection.version]
    for command in (
        {"do": "poke", "index": 60, "value": 7},
        {"do": "step", "frames": 1},
        {"do": "pixels", "index": 60},
    ):
        protocol.run(inspection, json.dumps(command))
        versions.append(inspection.version)
    assert versions[0] < versions[1] < versions[2] == versions[3]  # a page asks for pixels at each new version


def test_the_news_have_a_state_only_if_it_is_new() -> None:
    inspection = new_inspection("pong")
    known, messages = protocol.news(inspection, "")
    assert any("state" in message for message in messages)
    protocol.run(inspection, json.dumps({"do": "pause"}))
    assert not any("state" in message for message in protocol.news(inspection, known)[1])
    inspection.notice = "something"
    protocol.run(inspection, json.dumps({"do": "poke", "index": 60, "value": 7}))
    messages = protocol.news(inspection, known)[1]
    assert {"notice": "something"} in messages
    assert any("state" in message for message in messages)
    assert inspection.notice == ""
