"""A game as data: what its file in `atari/games/` says, read, checked and frozen.

`atari/games/SCHEMA.md` documents the files. Nothing in the package knows a game by name: a new game is a new file.
"""

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

from atari.actions import PLAYER_ACTIONS, Action
from atari.rules import Rules, parse_rules

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

TV_FRAME_RATES = MappingProxyType({"NTSC": 60.0, "PAL": 50.0, "SECAM": 50.0})
"""Nominal frames a second by TV format."""


@dataclass(frozen=True)
class Rom:
    """What identifies the cartridge image of a game: hashes of the file, its size in bytes, its bank switching."""

    md5: str
    sha256: str
    size: int
    cartridge: str


@dataclass(frozen=True)
class Screen:
    """The picture a game draws.

    `height` is in rows (the width is always 160), `first_line` the scan line of row 0, `format` the TV format.
    `format_detected` is False where the format comes from a table and not from watching the first frames.
    """

    format: Literal["NTSC", "PAL", "SECAM"]
    height: int
    first_line: int
    format_detected: bool = True
    hmove_blanks: bool = True
    width: int = 160

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns) of the screen."""
        return self.height, self.width

    @property
    def frame_rate(self) -> float:
        """Nominal frames a second."""
        return TV_FRAME_RATES[self.format]


@dataclass(frozen=True)
class Controllers:
    """What is plugged into the two ports, and how the console's difficulty switches stand at power-on."""

    left: Literal["joystick", "paddles", "none"]
    right: Literal["joystick", "paddles", "none"]
    swap_ports: bool = False
    swap_paddles: bool = False
    paddle_range: tuple[int, int] | None = None
    left_difficulty: Literal["A", "B"] = "B"
    right_difficulty: Literal["A", "B"] = "B"

    @property
    def paddles(self) -> bool:
        """Whether the game is played with paddles."""
        return "paddles" in (self.left, self.right)


@dataclass(frozen=True)
class RamLabel:
    """The meaning of one byte of RAM.

    `index` is 0..127 into the RAM observation. `transform` and `visible` are expressions over `v` (this byte) and
    `ram` (all of them). `sources` name who says so, `evidence` what a check against the running game found.
    """

    name: str
    index: int
    kind: str
    sources: tuple[str, ...]
    evidence: str
    mask: int | None = None
    encoding: str | None = None
    weight: int | None = None
    start: int | None = None
    transform: str | None = None
    visible: str | None = None
    note: str | None = None


@dataclass(frozen=True, repr=False)
class Game:
    """One game: its ROM, screen, controllers, actions, modes, rules and the names of its RAM bytes.

    Games with `rules` None (the four two-player cartridges) have no single-player rules in ALE and cannot be made
    into an environment; their action and mode tuples are empty.
    """

    id: str
    title: str
    players: int
    rom: Rom
    screen: Screen
    controllers: Controllers
    minimal_actions: tuple[Action, ...]
    legal_actions: tuple[Action, ...]
    starting_actions: tuple[Action, ...]
    modes: tuple[int, ...]
    default_mode: int
    difficulties: tuple[int, ...]
    rules: Rules | None
    ram_labels: Mapping[str, RamLabel]
    notes: tuple[str, ...]

    @property
    def single_player(self) -> bool:
        """Whether the game has single-player rules, so that an environment can be made of it."""
        return self.rules is not None

    def __repr__(self) -> str:
        if not self.single_player:
            return f"Game({self.id!r}, {self.title!r}, {self.players} players, no single-player rules)"
        return (
            f"Game({self.id!r}, {self.title!r}, {len(self.minimal_actions)} actions, {len(self.modes)} modes, "
            f"{len(self.difficulties)} difficulties, {self.screen.format} 160x{self.screen.height})"
        )


def load_game(path: Path) -> Game:
    """Read one game file; its name without the suffix is the game's id.

    Raises:
        ValueError: the file is not valid TOML or not a game; the text names the file and the fault.
    """
    try:
        return parse_game(path.stem, tomllib.loads(path.read_text(encoding="utf-8")))
    except (ValueError, KeyError, TypeError) as error:
        fault = f"the key {error} is missing" if isinstance(error, KeyError) else error
        raise ValueError(f"{path}: {fault}") from error


def parse_game(game_id: str, table: Mapping[str, Any]) -> Game:
    """Make a `Game` of the parsed content of a game file."""
    _check_keys(
        table, "the file", "title players notes rom screen controllers actions settings rules ram".split()
    )
    rules = parse_rules(table["rules"]) if "rules" in table else None
    actions = table["actions"] if rules else {"minimal": [], "legal": [], "starting": []}
    settings = table["settings"] if rules else {"modes": [], "default_mode": 0, "difficulties": []}
    if rules and settings["default_mode"] not in settings["modes"]:
        raise ValueError(f"[settings] default_mode {settings['default_mode']} is not one of the modes")
    if not set(_actions(actions["minimal"])) <= set(_actions(actions["legal"])):
        raise ValueError("[actions] a minimal action is not legal")
    controllers = dict(table["controllers"])
    if "paddle_range" in controllers:
        controllers["paddle_range"] = tuple(controllers["paddle_range"])
    return Game(
        id=game_id,
        title=table["title"],
        players=table["players"],
        rom=Rom(**table["rom"]),
        screen=_screen(table["screen"]),
        controllers=Controllers(**controllers),
        minimal_actions=_actions(actions["minimal"]),
        legal_actions=_actions(actions["legal"]),
        starting_actions=_actions(actions["starting"]),
        modes=tuple(settings["modes"]),
        default_mode=settings["default_mode"],
        difficulties=tuple(settings["difficulties"]),
        rules=rules,
        ram_labels=MappingProxyType(
            {name: _ram_label(name, label) for name, label in table.get("ram", {}).items()}
        ),
        notes=tuple(table["notes"]),
    )


def _check_keys(table: Mapping[str, Any], where: str, allowed: list[str]) -> None:
    unknown = set(table) - set(allowed)
    if unknown:
        raise ValueError(f"{where} has no key {sorted(unknown)[0]!r} (expected {', '.join(allowed)})")


def _screen(table: Mapping[str, Any]) -> Screen:
    screen = Screen(**table)
    if screen.format not in TV_FRAME_RATES:
        raise ValueError(f"[screen] format {screen.format!r} is not one of {', '.join(TV_FRAME_RATES)}")
    if not 1 <= screen.height <= 256:
        raise ValueError(f"[screen] height {screen.height} is not within 1..256")
    return screen


def _actions(names: "Literal['all'] | list[str]") -> tuple[Action, ...]:
    if names == "all":
        return PLAYER_ACTIONS
    unknown = [name for name in names if name not in Action.__members__]
    if unknown:
        raise ValueError(f"[actions] unknown action {unknown[0]!r}")
    return tuple(Action[name] for name in names)


def _ram_label(name: str, table: Mapping[str, Any]) -> RamLabel:
    label = RamLabel(name=name, **{**table, "sources": tuple(table["sources"])})
    if not 0 <= label.index <= 127:
        raise ValueError(f"[ram] {name}: index {label.index} is not within 0..127")
    return label
