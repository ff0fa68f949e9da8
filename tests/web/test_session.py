"""A play session of the page's core: run-ahead, play that is taken back, labels written, and calls that are refused."""

import json
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import web_tools
from web_tools import image, needs_core, node, packed

import atari
from atari.cores import NativeCore
from atari.lab.labels import labels_of
from atari.web.table import core_text, entry

pytestmark = needs_core


def called(game: str, *calls: list[Any], **options: Any) -> list[Any]:
    """The results of calls of play_calls.mjs."""
    one = atari.games[game]
    found: list[Any] = node(
        "play_calls.mjs", core=core_text(one), image=image(game), options=options, calls=list(calls)
    )
    return found


def test_the_screen_is_rgb_with_alpha() -> None:
    core = NativeCore("pong", seed=4)
    core.reset()
    rgb = core.screen_rgb()
    rgba = np.concatenate([rgb, np.full((*rgb.shape[:2], 1), 255, np.uint8)], axis=2)
    assert called("pong", ["reset"], ["rgba"], seed=4)[1] == zlib.crc32(rgba.tobytes())


@pytest.mark.parametrize("frames", [0, 1, 2])
def test_the_screen_ahead_is_that_of_later_frames(frames: int) -> None:
    start = [["reset"], *[["act", 3]] * 70]
    ahead = called("seaquest", *start, ["ahead", frames, 5])
    later = called("seaquest", *start, *[["act", 5]] * frames, ["rgba"])
    assert ahead[-1][0] == later[-1]
    assert ahead[-1][1:4] == ahead[-2][:3]  # nothing has changed


def test_play_is_taken_back_frame_by_frame() -> None:
    forth: list[list[Any]] = [call for i in range(200) for call in (["remember"], ["act", i % 18])]
    seen = called("seaquest", ["reset"], ["act", 0], *forth, *[["goBack"]] * 201)
    shown = [seen[1], *seen[3:402:2]]
    back = seen[402:-1]
    assert [one[:3] for one in back] == [one[:3] for one in reversed(shown[:-1])]
    assert [one[7:9] for one in back] == [one[7:9] for one in reversed(shown[:-1])]
    assert seen[-1] == seen[-2][:3] + seen[-1][3:]  # there is no older state


def test_old_states_are_dropped_beyond_the_budget() -> None:
    forth: list[list[Any]] = [call for i in range(300) for call in (["remember"], ["act", i % 18])]
    start = [["reset"], *[["act", 0]] * 60, ["budget", 60_000]]  # the first frames differ in more
    kept = called("pong", *start, *forth)[len(start) :: 2]
    assert kept[:20] == list(range(1, 21))
    assert 20 < kept[-1] < 299


def test_bytes_of_labels() -> None:
    core = NativeCore("breakout", seed=0)
    core.reset()
    game = core.game
    names = list(game.ram_labels)
    wanted = [(name, value) for name in names[:6] for value in (0, 3, 57, 1000)]
    calls = [["byteOf", names.index(name), value] for name, value in wanted]
    for (name, value), byte in zip(wanted, called("breakout", ["reset"], *calls, seed=0)[1:], strict=True):
        if byte >= 0:
            assert labels_of(game, name).byte_of(name, core.ram(), value) == byte
        else:
            with pytest.raises(ValueError, match="cannot be"):
                labels_of(game, name).byte_of(name, core.ram(), value)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (["act", 18], "an action is a number from 0 to 17"),
        (["act", 0, 0, 2000], "the strength of a paddle is out of range"),
        (["ahead", 1, -1], "an action is a number from 0 to 17"),
        (["ahead", 61, 0], "0 to 60 frames ahead"),
        (["mode", 99], "pong has no such mode"),
        (["difficulty", 9], "pong has no such difficulty"),
        (["poke", 128, 0], "an index 0..127 and a value 0..255"),
        (["addWrite", "{"], "the JSON is damaged"),
        (["addWrite", "[]"], "a write is no object of JSON"),
        (["addWrite", '{"to": "nothing", "value": 1}'], "pong has no label 'nothing'"),
        (["addWrite", '{"to": "player_y", "value": 9999}'], "player_y cannot be 9999"),
        (["addWrite", '{"to": 5, "value": "old + 1"}'], 'a write has no whole number "value"'),
        (["addWrite", '{"to": 5, "value": 1, "condition": "1"}'], 'a write has more, "condition"'),
        (["addWrite", '{"to": 5, "value": 1, "when": "never"}'], "cannot be applied at such a time"),
        (["addWrite", '{"to": 256, "value": 1}'], 'a write has a wrong "to"'),
        (["removeWrite", 0], "there is no write in slot 0"),
        (["restore", packed(b"x")], "not a snapshot of atari-envs"),
        (["replay"], "this game is not recorded"),
    ],
)
def test_a_refused_call_changes_nothing(call: list[Any], message: str) -> None:
    before, refused, after = called("pong", ["reset"], call, ["poke", 0, 0])
    assert message in refused["error"]
    assert before[1:] == after[1:]


def test_a_write_too_many() -> None:
    calls = [["addWrite", json.dumps({"to": place, "value": 0})] for place in range(65)]
    *slots, refused = called("pong", *calls)
    assert slots == list(range(64))
    assert "at most 64 writes" in refused["error"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"mode": 9}, "pong has no mode 9; it has 0, 1"),
        ({"repeat_action_probability": 2}, "a number from 0 to 1"),
        ({"seed": -1}, "a seed is a whole number"),
        ({"frame_skip": 4}, "there is no option 'frame_skip'"),
        ({"interventions": ["nothing"]}, "no such intervention as 'nothing'"),
    ],
)
def test_a_refused_option(options: dict[str, Any], message: str) -> None:
    with pytest.raises(AssertionError, match=message):
        called("pong", **options)


@pytest.mark.parametrize(
    ("text", "size", "message"),
    [
        ("", 4096, "has the format 0, and this core reads 1"),
        ("table 1\nsomething 3", 4096, "an unknown line 'something'"),
        ("table 1\nheight ten", 4096, "the word 'ten' in place of a number"),
        (None, 600_000, "more bytes than any cartridge"),
        (None, 5, "a cartridge of type 2K needs an image of at least 2048 bytes"),
    ],
)
def test_a_game_that_is_refused(text: str | None, size: int, message: str) -> None:
    core = core_text(atari.games["pong"]) if text is None else text
    with pytest.raises(AssertionError, match=message):
        node("play_calls.mjs", core=core, image=packed(bytes(size)), options={}, calls=[])


def test_a_module_that_the_browser_refuses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "core.wasm").write_bytes((web_tools.BUILD / "core.wasm").read_bytes()[:1000])
    monkeypatch.setattr(web_tools, "BUILD", tmp_path)
    with pytest.raises(AssertionError, match="This browser cannot run the emulator"):
        called("pong")


def test_a_game_of_your_own() -> None:
    catch = atari.games.resolve("examples/catch/catch.toml")
    one = entry(catch)
    core = NativeCore(catch, seed=1)
    core.reset()
    found = node(
        "play_calls.mjs",
        core=one["core"],
        image=packed(atari.roms.find(catch).read_bytes()),
        options={"seed": 1},
        calls=[["reset"], *[["act", 3]] * 30],
        labels=len(one["labels"]),
        objects=len(one["objects"]),
    )
    for _ in range(30):
        core.act(3)
    assert found[-1][0] == zlib.crc32(core.ram().tobytes())
    assert found[-1][-2] == list(labels_of(catch).values(core.ram()).values())
