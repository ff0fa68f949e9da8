"""`Game`, a game definition: the content of a file of `atari/games/data/`, parsed and checked.

`atari/games/SCHEMA.md` documents the files. No code depends on the name of a game: a new game is a new file.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Literal

from atari.base.frozen import FrozenDict
from atari.base.notebook import facts
from atari.base.typed_table import build, check_table, check_type
from atari.games.actions import Action, Switch, parse_actions, parse_starting_actions
from atari.games.manual import Manual, load_manual
from atari.games.multiplayer import Multiplayer, parse_multiplayer
from atari.games.rules import LABEL_ADDRESSES, Rules, check_label_expression, parse_rules
from atari.games.toml_file import check_numbers, check_paddle_range, read_toml

_FOLDER = Path(__file__).parent

TV_FRAME_RATES = FrozenDict({"NTSC": 60.0, "PAL": 50.0, "SECAM": 50.0})
"""Nominal frames a second by TV format."""


@dataclass(frozen=True)
class Rom:
    """The identity of a cartridge image: hashes of the file, its size in bytes, its bank switching.

    A game of your own may lack each of these. Without a hash, any image is accepted; without `cartridge`, the bank
    switching is detected from the image.
    """

    md5: str = ""
    sha256: str = ""
    size: int = 0
    cartridge: str = ""


@dataclass(frozen=True)
class Screen:
    """The screen of a game.

    `height` is in rows (the width is always 160), `first_line` the scan line of row 0, `format` the TV format.
    `format_detected` is False if the format comes from a table, not from detection in the first frames.
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
    """The controllers in the two ports, and the positions of the console's difficulty switches at power-on."""

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
    `ram` (all bytes). `width` and `height` are the size of the object on the screen, in pixels. `x`, of a
    `position_y`, is the column where the object always is, and `y`, of a `position_x`, its row. `sources` are documents
    that have the label, `evidence` is the result of a check against the running game.
    """

    name: str
    index: int
    kind: str
    sources: tuple[str, ...]
    evidence: str
    mask: int | None = None
    encoding: str | None = None
    weight: int | None = None
    width: int | None = None
    height: int | None = None
    x: int | None = None
    y: int | None = None
    start: int | None = None
    transform: str | None = None
    visible: str | None = None
    note: str | None = None


@dataclass(frozen=True, repr=False)
class Game:
    """One game: its ROM, screen, controllers, actions, modes, rules and the names of its RAM bytes.

    `rules` is None for the four two-player cartridges, which have no single-player rules in ALE: only environments
    for several players play them. Their action and mode tuples are empty. `multiplayer` is None for games without
    rules for several players.

    Example:
        >>> import atari
        >>> game = atari.games["ms_pacman"]
        >>> game.title, game.modes, len(game.minimal_actions)
        ('Ms. Pac-Man', (0, 1, 2, 3), 9)
    """

    id: str
    title: str
    players: int
    rom: Rom
    screen: Screen
    controllers: Controllers
    minimal_actions: tuple[Action, ...]
    legal_actions: tuple[Action, ...]
    starting_actions: tuple[Action | Switch, ...]
    modes: tuple[int, ...]
    default_mode: int
    difficulties: tuple[int, ...]
    rules: Rules | None
    multiplayer: Multiplayer | None
    ram_labels: Mapping[str, RamLabel]
    notes: tuple[str, ...]
    file: Path | None = field(default=None, compare=False)
    """The file of a game of your own, whose ROM may lie beside it; None for a game of this package."""

    @property
    def single_player(self) -> bool:
        """Whether the game has single-player rules, which an environment needs."""
        return self.rules is not None

    @property
    def manual(self) -> Manual | None:
        """Title, year, maker, description and meaning of modes and difficulties; None for a game of your own.

        The file of `atari/games/manuals/` is read at the first use. A game of your own with the id and the ROM of a
        game of this package has that game's manual.
        """
        found = _manual(self.id)
        return found[1] if found and found[0] == self.rom.md5 else None

    def __repr__(self) -> str:
        if not self.single_player:
            return f"Game({self.id!r}, {self.title!r}, {self.players} players, no single-player rules)"
        return (
            f"Game({self.id!r}, {self.title!r}, {len(self.minimal_actions)} actions, {len(self.modes)} modes, "
            f"{len(self.difficulties)} difficulties, {self.screen.format} 160x{self.screen.height})"
        )

    def _repr_html_(self) -> str:
        manual = self.manual
        makers = (manual.maker, manual.year) if manual else ()
        rows = (
            ("id", self.id),
            ("made", ", ".join(str(one) for one in makers if one)),
            ("players", self.players),
            ("screen", f"{self.screen.width}x{self.screen.height}, {self.screen.format}"),
            ("actions", f"{len(self.minimal_actions)}: {', '.join(one.name for one in self.minimal_actions)}"),
            ("modes", _numbered(self.modes, manual.modes if manual else {})),
            ("difficulties", _numbered(self.difficulties, manual.difficulties if manual else {})),
            ("reward", manual and manual.reward),
            ("lives", manual and manual.lives),
            ("end", manual and manual.end),
            ("names of RAM", ", ".join(self.ram_labels)),
        )
        return facts(self.title, rows, manual.description if manual else "")


def _numbered(values: tuple[int, ...], meanings: Mapping[int, str]) -> str:
    return "; ".join(f"{value}: {meanings[value]}" if value in meanings else str(value) for value in values)


def load_game(path: Path) -> Game:
    """Read a game definition; the file's name without the suffix is the game's id.

    Raises:
        ValueError: the file is not valid TOML or not a game definition; the message names the file and the fault. Or
            the file is a device or a pipe.
        FileNotFoundError, IsADirectoryError, PermissionError: the file cannot be read.

    Example:
        >>> from importlib.resources import files
        >>> from atari.games.game import load_game
        >>> game = load_game(files("atari") / "games" / "data" / "pong.toml")
        >>> game.id, game.modes, [action.name for action in game.minimal_actions][:3]
        ('pong', (0, 1), ['NOOP', 'FIRE', 'RIGHT'])
    """
    table = read_toml(path, "a game definition")
    try:
        return parse_game(path.stem, table)
    except (ValueError, TypeError, AttributeError) as error:
        raise ValueError(f"{path}: {error}") from error


@cache
def _manual(game_id: str) -> tuple[str, Manual] | None:
    """The MD5 of the ROM and the manual of a game of this package; None for another id."""
    definition, manual = _FOLDER / "data" / f"{game_id}.toml", _FOLDER / "manuals" / f"{game_id}.toml"
    if not manual.is_file() or not definition.is_file():
        return None
    game = load_game(definition)
    return game.rom.md5, load_manual(manual, numbers(game))


def numbers(game: Game) -> dict[str, tuple[int, ...]]:
    """The numbers that a game has: its modes, its modes for several players, and its difficulties."""
    multiplayer = game.multiplayer
    shared = multiplayer.modes.values() if multiplayer else ()
    return {
        "modes": game.modes,
        "difficulties": game.difficulties or (multiplayer.difficulties if multiplayer else ()),
        "multiplayer_modes": tuple(sorted({mode for modes in shared for mode in modes})),
    }


def parse_game(game_id: str, table: Mapping[str, Any]) -> Game:
    """A `Game` from the parsed content of a game definition.

    Raises:
        ValueError: the content is not a game definition; the message has the place and the expected content.
    """
    check_numbers(table, "")
    playing = ("actions", "settings", "rules")
    needed = playing if any(key in table for key in playing) else ()
    tables = dict.fromkeys(("screen", "controllers", *needed), dict)
    others = dict.fromkeys(("rom", "ram", "multiplayer"), dict)
    check_table(table, "the file", {"title": str, "players": int, "notes": tuple[str, ...], **tables}, others)
    return Game(
        id=game_id,
        title=table["title"],
        players=table["players"],
        rom=_rom(table.get("rom", {})),
        screen=_screen(table["screen"]),
        controllers=_controllers(table["controllers"]),
        **_play(table) if "rules" in table else _NO_PLAY,
        multiplayer=parse_multiplayer(table["multiplayer"]) if "multiplayer" in table else None,
        ram_labels=_ram_labels(table.get("ram", {})),
        notes=tuple(table["notes"]),
    )


# The fields from [actions], [settings] and [rules], for a game without single-player rules.
_NO_PLAY: Mapping[str, Any] = {
    **dict.fromkeys(("minimal_actions", "legal_actions", "starting_actions", "modes", "difficulties"), ()),
    **{"default_mode": 0, "rules": None},
}


def _play(table: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a `Game` that come from [actions], [settings] and [rules]."""
    listed, settings = table["actions"], table["settings"]
    check_table(listed, "[actions]", dict.fromkeys(("minimal", "legal", "starting"), Any))
    minimal, legal = (parse_actions(listed[key]) for key in ("minimal", "legal"))
    if not set(minimal) <= set(legal):
        raise ValueError("[actions] a minimal action is not legal")
    if not minimal:
        raise ValueError("[actions] minimal needs an action")
    numbers = tuple[int, ...]
    check_table(settings, "[settings]", {"modes": numbers, "default_mode": int, "difficulties": numbers})
    if settings["default_mode"] not in settings["modes"]:
        raise ValueError(f"[settings] default_mode {settings['default_mode']} is not one of the modes")
    if not settings["difficulties"] or not set(settings["difficulties"]) <= {0, 1, 2, 3}:
        raise ValueError(f"[settings] difficulties {settings['difficulties']} are not among 0, 1, 2, 3")
    return {
        "minimal_actions": minimal,
        "legal_actions": legal,
        "starting_actions": parse_starting_actions(listed["starting"]),
        "modes": tuple(settings["modes"]),
        "default_mode": settings["default_mode"],
        "difficulties": tuple(settings["difficulties"]),
        "rules": parse_rules(table["rules"]),
    }


def _rom(table: Mapping[str, Any]) -> Rom:
    rom = build(Rom, table, "[rom]")
    for name, value, digits in (("md5", rom.md5, 32), ("sha256", rom.sha256, 64)):
        if value and not re.fullmatch(f"[0-9a-f]{{{digits}}}", value):
            raise ValueError(f"[rom] {name} must be {digits} hexadecimal digits in lower case, got {value!r}")
    return rom


def _screen(table: Mapping[str, Any]) -> Screen:
    screen = build(Screen, table, "[screen]")
    if not 200 <= screen.height <= 256:
        raise ValueError(f"[screen] height {screen.height} is not within 200..256")
    if not 0 <= screen.first_line <= 300 - screen.height:
        raise ValueError(f"[screen] first_line {screen.first_line} is not within 0..{300 - screen.height}")
    if screen.width != 160:
        raise ValueError(f"[screen] width is always 160, got {screen.width}; leave it out")
    return screen


def _controllers(table: Mapping[str, Any]) -> Controllers:
    controllers = build(Controllers, table, "[controllers]")
    check_paddle_range("[controllers]", controllers.paddle_range)
    return controllers


_LABEL_NUMBERS = (("mask", 1, 255), ("width", 1, 160), ("height", 1, 256), ("x", 0, 159), ("y", 0, 255))
"""The numbers of a label, with the least and the greatest value of each."""


def _ram_labels(table: Mapping[str, Any]) -> FrozenDict[str, RamLabel]:
    labels = FrozenDict((name, _ram_label(name, label)) for name, label in table.items())
    for name, label in labels.items():
        for axis, known in (("x", "y"), ("y", "x")):
            other = re.sub(rf"(?<![a-z]){known}(?![a-z])", axis, name)
            if getattr(label, axis) is not None and other in labels and other != name:
                raise ValueError(f"[ram] {name}: {axis} has no effect beside the label {other}; keep one of them")
    return labels


def _ram_label(name: str, table: Mapping[str, Any]) -> RamLabel:
    where = f"[ram] {name}"
    if "name" in check_type(table, where, dict):
        raise ValueError(f"{where} must be a table, without the key 'name'")
    label = build(RamLabel, {"name": name, **table}, where)
    if label.index not in LABEL_ADDRESSES:
        raise ValueError(f"{where}: index {label.index} is not within 0..127")
    for key, low, high in _LABEL_NUMBERS:
        number = getattr(label, key)
        if number is not None and not low <= number <= high:
            raise ValueError(f"{where}: {key} {number} is not within {low}..{high}")
    for key, kind in (("x", "position_y"), ("y", "position_x")):
        if getattr(label, key) is not None and label.kind != kind:
            raise ValueError(f"{where}: {key} is the place of an object whose label is a {kind}, not a {label.kind}")
    if label.encoding not in (None, "plain", "bcd"):
        raise ValueError(f"{where}: encoding must be 'bcd' or 'plain', got {label.encoding!r}")
    for expression in (label.transform, label.visible):
        if expression is not None:
            check_label_expression(expression, where)
    return label
