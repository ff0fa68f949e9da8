"""Game files that are wrong in any way: a ValueError with file and key, never another error, a crash or a hang."""

import copy
import json
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

import atari
from atari.games.game import load_game
from atari.games.toml_file import tomllib

CATCH = Path(__file__).parents[2] / "examples" / "catch"
TEXT = (CATCH / "catch.toml").read_text()
TABLE = {
    **tomllib.loads(TEXT),
    "rom": {"md5": "", "sha256": "", "size": 4096, "cartridge": ""},
}
TABLE["controllers"]["paddle_range"] = [100, 200]
TABLE["ram"] = {"ball_x": TABLE["ram"]["ball_x"]}
TABLE["notes"] = ["A note."]
TABLE["rules"] |= {
    "kept_over_reset": [],
    "selection_frames": 0,
    "mode_select": [
        {"op": "set", "var": "goal", "value": "mode + 1"},
        {"op": "press_select_until", "frames": 1, "until": "ram[0x80] >= 0", "max": 3},
        {"op": "repeat", "times": 2, "do": [{"op": "act", "action": "NOOP", "times": 1}]},
    ],
}
VALUES: list[Any] = [
    True, -1, 0, 1, 255, 2**31, 10**4000, 0.5, float("inf"), "", "x", "RESET",
    [], [[]], ["x"], [1], [{}], {}, {"op": "set"}, "(" * 190, "-" * 1900 + "1", "1+" * 900 + "1", "1 < 2 < 3", "\0",
    "9" * 1500, "bcd(*ram)",
]  # fmt: skip


def toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, str):
        return json.dumps(value)
    return str(value).lower()


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield (*path, key)
        yield from places(item, (*path, key))


def broken() -> Iterator[tuple[tuple[Any, ...], str]]:
    """The file with each of its values missing, or another."""
    for path in places(TABLE):
        if path[0] in ("notes", "ram") and len(path) > 2:
            continue
        for value in (KeyError, *VALUES):
            table = copy.deepcopy(TABLE)
            inner: Any = table
            for key in path[:-1]:
                inner = inner[key]
            if value is KeyError:
                del inner[path[-1]]
            else:
                inner[path[-1]] = value
            yield path, "".join(f"{key} = {toml(item)}\n" for key, item in table.items())


def test_any_value_of_a_game_file_is_good_or_a_value_error(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("".join(f"{key} = {toml(item)}\n" for key, item in TABLE.items()))
    atari.AtariEnv(file, rom=CATCH / "catch.bin").reset()
    accepted, faults = 0, []
    for path, text in broken():
        file.write_text(text)
        try:
            game = load_game(file)
        except ValueError as error:
            faults.append(str(error))
            continue
        accepted += 1
        if path[0] in ("screen", "controllers", "actions", "settings", "rules"):
            with suppress(ValueError, RuntimeError):  # too deep a stack; a mode that is never reached
                atari.cores.NativeCore(game, rom=CATCH / "catch.bin")
    assert accepted > 50
    assert len(faults) > 1000
    assert all(fault.startswith(f"{file}: ") for fault in faults)


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("height = 210", "height = 210\nwidth = 320", "[screen] width is always 160, got 320"),
        ("first_line = 34", "first_line = 91", "[screen] first_line 91 is not within 0..90"),
        ("first_line = 34", "first_line = 99999999999", "screen.first_line is not an integer of 32 bits"),
        ("lives_initial = 3", "lives_initial = 2147483648", "rules.lives_initial is not an integer of 32 bits"),
        ("state = {score = 0}", "state = {score = -2147483649}", "rules.state.score is not an integer of 32 bits"),
        ("state = {score = 0}", "state = 3", "[rules]: 'state' must be a table, got 3"),
        (
            "[rules]",
            '[rules]\nmode_select = [{op = "press_select_until", frames = 1, until = "1", max = "x"}]',
            "[rules] mode_select, press_select_until: 'max' must be a whole number, got 'x'",
        ),
        ("[rules]", "[rules]\nmode_select = 3", "[rules]: 'mode_select' must be a list of tables, got 3"),
        ("[screen]", "x = " + "[" * 100_000 + "\n[screen]", "its tables or lists are nested too deeply"),
        ("[screen]", "[x]\na = " + "[" * 60 + "]" * 60 + "\n[screen]", f"x.a{'[0]' * 39} is nested too deeply"),
        ("[screen]", "#" * 300_000 + "\n[screen]", "a game definition has at most 262,144 bytes"),
        ("bcd(0x80)", "-" * 1900 + "1", "is nested too deeply"),
        ("bcd(0x80)", "1" * 2001, "[rules] step, line 1: an expression is a text of at most 2,000 characters"),
        ('["NOOP", "RIGHT", "LEFT"]', "[]", "[actions] minimal needs an action"),
        (
            "index = 2,",
            "index = 2, x = 3,",
            "[ram] player_x: x is the place of an object whose label is a position_y, not a",
        ),
        ("y = 172", "y = 256", "[ram] player_x: y 256 is not within 0..255"),
        (
            "index = 1,",
            "index = 1, y = 3,",
            "[ram] lives: y is the place of an object whose label is a position_x, not a lives",
        ),
        ("index = 3,", "index = 3, y = 9,", "[ram] ball_x: y has no effect beside the label ball_y; keep one of them"),
        (TEXT, "title = 3", "the file needs the key"),
        (TEXT, "not toml at all", "after a key in a key/value pair"),
    ],
)
def test_the_fault_is_named(tmp_path: Path, old: str, new: str, fault: str) -> None:
    assert old in TEXT
    (tmp_path / "mine.toml").write_text(TEXT.replace(old, new, 1))
    with pytest.raises(ValueError, match=r"mine\.toml: ") as error:
        atari.AtariEnv(tmp_path / "mine.toml", rom=CATCH / "catch.bin")
    assert fault in str(error.value)


def test_pipes_devices_and_folders_are_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "device.toml").symlink_to("/dev/zero")
    (tmp_path / "folder.toml").mkdir()
    for name in ("pipe", "device"):
        with pytest.raises(ValueError, match=f"{name}.toml is a device or a pipe; give a regular file"):
            atari.AtariEnv(tmp_path / f"{name}.toml")
        with pytest.raises(ValueError, match="is a device or a pipe"):
            atari.AtariEnv(CATCH / "catch.toml", rom=tmp_path / f"{name}.toml")
    with pytest.raises(IsADirectoryError, match=r"folder\.toml is a folder; give a regular file"):
        atari.AtariEnv(tmp_path / "folder.toml")
