"""The table of games for the page: what the core plays, and what the page shows, compiled from the game definitions.

A game has one entry, an object of JSON. Its texts for people are for the page. "core" is the text that the core reads
(`web/core/game_text.cpp`), with a line for each fact: the compiled definition, the programs of labels, and the writes
of interventions. "two_players" has the same for a game of two.
"""

import gzip
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, fields
from typing import Any

from atari.base.version import VERSION
from atari.cores.compiled import definition, definition_for_players
from atari.cores.writes import make_writes, possible_values
from atari.games.actions import Action
from atari.games.game import Game, RamLabel
from atari.games.interventions import Intervention, WriteRule, compile_write, load
from atari.games.labels import compile_label
from atari.games.objects import constants, positions
from atari.games.players import choose_mode
from atari.roms import find
from atari.roms.image import md5, read_image

FORMAT = 1
"""The version of an entry and of its texts for the core, which reads this one only."""

_TWO = 2


def entry(game: Game) -> dict[str, Any]:
    """The entry of a game. A game of your own is recognised by the ROM that is found for it.

    Raises:
        FileNotFoundError: there is no ROM of a game of your own.
    """
    image = read_image(find(game)) if game.file else b""
    objects = [{"name": name, **_sizes(axes)} for name, axes in positions(game.ram_labels).items()]
    return {
        "format": FORMAT,
        "release": VERSION,
        "id": game.id,
        "title": game.title,
        "md5": md5(image) if image else game.rom.md5,
        "screen": {"width": game.screen.width, "height": max(game.screen.height, 200)},
        "frame_rate": game.screen.frame_rate,
        "controllers": [game.controllers.left, game.controllers.right],
        "actions": _names(game.minimal_actions),
        "modes": game.modes,
        "default_mode": game.default_mode,
        "difficulties": game.difficulties,
        "manual": _manual(game),
        "notes": game.notes,
        "labels": [_facts_of_label(label) for label in game.ram_labels.values()],
        "objects": objects,
        "interventions": [
            {
                "name": one.name,
                "description": one.description,
                "writes": [write.definition for write in make_writes(game, [one])],
            }
            for one in _interventions(game)
        ],
        "core": core_text(game, image),
        "two_players": _two_players(game, image),
    }


def table_files(games: Iterable[Game]) -> dict[str, bytes]:
    """The files of the table by name: `games/ID.json` for each game, `index.json`, and all of it in `table.json.gz`.

    The index has the title and the MD5 of each game's ROM by id.
    """
    entries = [entry(game) for game in games]
    index = {
        "format": FORMAT,
        "release": VERSION,
        "games": {one["id"]: {"title": one["title"], "md5": one["md5"]} for one in entries},
    }
    return {
        **{f"games/{one['id']}.json": _json(one).encode() for one in entries},
        "index.json": _json(index).encode(),
        "table.json.gz": gzip.compress(_json({**index, "games": entries}).encode(), 9, mtime=0),
    }


def core_text(game: Game, image: bytes = b"") -> str:
    """The text of a game for the core."""
    choices = {"players": 1, "modes": game.modes, "difficulties": game.difficulties}
    return _text([*_head(game, choices), *_definition_lines(definition(game, image)), *_lab_lines(game)])


def words(value: Any) -> str:
    """A text, a number or truth value, or a sequence of numbers, as words of a line."""
    if isinstance(value, str):
        return value
    return " ".join(str(int(number)) for number in (value if isinstance(value, Sequence) else [value]))


def _two_players(game: Game, image: bytes) -> dict[str, Any] | None:
    """The part of an entry for two players; None if the game has no mode for two."""
    rules = game.multiplayer
    if rules is None or _TWO not in rules.modes:
        return None
    choices = {"players": _TWO, "modes": rules.modes[_TWO], "difficulties": rules.difficulties}
    return {
        "modes": rules.modes[_TWO],
        "default_mode": choose_mode(game, None, _TWO)[0],
        "difficulties": rules.difficulties,
        "actions": _names(rules.minimal_actions),
        "core": _text(
            [*_head(game, choices), *_definition_lines(definition_for_players(game, image)), *_lab_lines(game)]
        ),
    }


def _head(game: Game, choices: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    yield "table", FORMAT
    yield "id", game.id
    yield from choices.items()


def _definition_lines(arguments: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """The arguments of `_emulator.make_game` without the image, which the page has."""
    return ((name, value) for name, value in arguments.items() if name != "image")


def _lab_lines(game: Game) -> Iterator[tuple[str, str]]:
    """Labels, objects and interventions."""
    names = list(game.ram_labels)
    for name, label in game.ram_labels.items():
        index, mask, decimal, value, visible = compile_label(label)
        written = compile_write(game, WriteRule(name, 0), f"the label {name!r}").label
        possible = sorted(possible_values(game, name)) if label.transform and "ram" in label.transform else []
        yield "label", f"{name} {words([index, mask, decimal])} {_counted(value, visible, written, possible)}"
    for axes in positions(game.ram_labels).values():
        fixed = constants(axes)
        places = [
            f"label {names.index(axes[axis].name)}"
            if axis in axes
            else f"at {fixed[axis]}"
            if axis in fixed
            else "none 0"
            for axis in ("x", "y")
        ]
        yield "object", " ".join(places)
    for intervention in _interventions(game):
        yield "intervention", json.dumps(intervention.definition(), sort_keys=True)
        for rule, write in zip(intervention.writes, make_writes(game, [intervention]), strict=True):
            made = compile_write(game, rule, intervention.name)
            facts = made.index, made.mask, made.every_frame, made.at_reset, made.once, made.paid, made.remembers
            yield "write", f"{words(facts)} {_counted(made.frames, made.condition, made.value, made.label)}"
            yield "definition", write.definition


def _facts_of_label(label: RamLabel) -> dict[str, Any]:
    """What the page shows of a label; the core has its programs."""
    compiled = ("transform", "visible", "start")
    return {name: value for name, value in asdict(label).items() if value not in (None, ()) and name not in compiled}


def _interventions(game: Game) -> Iterable[Intervention]:
    """The package's interventions of a game of the package."""
    return () if game.file else load(game).values()


def _text(lines: Iterable[tuple[str, Any]]) -> str:
    return "".join(f"{name} {words(value)}\n" for name, value in lines)


def _counted(*lists: Sequence[int]) -> str:
    """Lists of numbers, each after its length."""
    return " ".join(words([len(numbers), *numbers]) for numbers in lists)


def _sizes(axes: Mapping[str, RamLabel]) -> dict[str, int]:
    """The width and the height of an object: of the first label of its position that has them."""
    sizes = [(name, getattr(label, name)) for label in reversed([*axes.values()]) for name in ("width", "height")]
    return {name: size for name, size in sizes if size is not None}


def _names(actions: Iterable[Action]) -> list[str]:
    return [action.name for action in actions]


def _manual(game: Game) -> dict[str, Any] | None:
    manual = game.manual
    if manual is None:
        return None
    facts = {field.name: getattr(manual, field.name) for field in fields(manual) if field.name != "sources"}
    return {name: dict(value) if isinstance(value, Mapping) else value for name, value in facts.items()}


def _json(value: Any) -> str:
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False)
