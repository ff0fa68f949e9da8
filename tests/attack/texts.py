"""Hostile texts in files of TOML and JSON: they are refused, or nothing that is printed has a control character."""

import contextlib
import io
import json
import random
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

import atari
from atari.cli import main
from atari.games.game import load_game
from atari.games.manual import load_manual
from atari.games.toml_file import tomllib
from atari.lab import interventions
from atari.learning.evaluation.protocols import PROTOCOLS
from atari.learning.evaluation.results import GameResult, Result
from atari.recording import VideoWriter

GAMES = Path(atari.games.__path__[0])
TEXTS = (
    "\x1b]0;x\x07",
    "\x00",
    "\x9b31m",
    "\r",
    "\u202e",
    "\u2028",
    "\n[x]\n",
    "a\tb",
    "'\"\\",
    "x" * 30_000,
    "<script>",
    "é",
)
NUMBERS = (0, -1, 2**31, 2**63, 2**64, -(2**64), 10**400, 0.5, 1e308, float("inf"), float("nan"))

REWARD = "0.1 * (player_y - before.player_y) / max(lives, 1) if visible(ball_x) else bcd(0x8A) - ram[0x8B]"
TASK = json.loads(atari.Task.of("pong", interventions=["lazy_enemy"], reward=REWARD).to_json())
PONG = GameResult("pong", (-20.0, 1.5), (1000, 2000), (False, True), (1, 2), {"stack_num": 4}, TASK)
RESULT = Result("a policy", PROTOCOLS["dopamine"], 0, (PONG,), 1000, {"python": "3.11"}).to_json()


def attack(seed: int) -> None:
    """One file of each kind."""
    source = random.Random(seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for kind in (game_file, manual_file, interventions_file, task_file, video_file, result_file):
            kind(source, folder)


def hostile(source: random.Random) -> Any:
    """A value that has no place in a file."""
    makers: list[Callable[[], Any]] = [
        lambda: source.choice(TEXTS),
        lambda: source.choice(NUMBERS),
        lambda: nested(source.choice((5, 40, 90))),
        lambda: source.choice((True, [], {}, [{}], {"": {}}, ["x", 1])),
    ]
    return source.choice(makers)()


def nested(depth: int) -> Any:
    """Lists within each other."""
    value: Any = 1
    for _ in range(depth):
        value = [value]
    return value


def mutated(source: random.Random, value: Any) -> Any:
    """A copy of a tree with one place changed: another value, another key, a text with more in it."""
    if isinstance(value, dict) and value and source.random() < 0.9:
        key = source.choice(list(value))
        if source.random() < 0.1:
            return {**value, source.choice(TEXTS): value[key]}
        return {**value, key: mutated(source, value[key])}
    if isinstance(value, list) and value and source.random() < 0.8:
        place = source.randrange(len(value))
        return [*value[:place], mutated(source, value[place]), *value[place + 1 :]]
    if isinstance(value, str) and source.random() < 0.6:
        place = source.randrange(len(value) + 1)
        return value[:place] + source.choice(TEXTS) + value[place:]
    return hostile(source)


def toml(source: random.Random, path: Path) -> str:
    """The text of a file with some places changed, sometimes cut or no TOML."""
    tree = tomllib.loads(path.read_text(encoding="utf-8"))
    for _ in range(source.choice((1, 1, 3))):
        tree = mutated(source, tree)
    text = tomli_w.dumps(tree if isinstance(tree, dict) else {"x": tree})
    text += source.choice(("",) * 9 + (f"x = {'[' * 5000}",))
    return text[: source.randrange(len(text) + 1)] if source.random() < 0.1 else text


def refused_or_read(read: Callable[[], Any]) -> Any:
    """The result, or None if a ValueError or an OSError was raised."""
    try:
        return read()
    except (ValueError, OSError):
        return None


def printed(*words: str) -> None:
    """What a command prints has no control characters."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        main(words)
    text = out.getvalue() + err.getvalue()
    bad = [one for one in text.translate({10: None, 9: None, 0xA0: None}) if not one.isprintable()]
    assert not bad, f"`atari {' '.join(words)}` has printed {bad[0]!r}"


def game_file(source: random.Random, folder: Path) -> None:
    """A game file is refused, or all its facts are printed."""
    file = folder / source.choice(("own.toml", "a b.toml", "e\x1b[31mvil.toml"))
    file.write_text(toml(source, source.choice(sorted((GAMES / "data").glob("*.toml")))), encoding="utf-8")
    game = refused_or_read(lambda: load_game(file))
    if game is not None:
        assert game.title.isprintable(), "the title is not printable"
        assert all(map(str.isprintable, game.ram_labels)), "a label's name is not printable"
    printed("info", str(file))
    printed("info", str(file), "--json")


def manual_file(source: random.Random, folder: Path) -> None:
    """A manual is refused, or read."""
    file = folder / "manual.toml"
    file.write_text(toml(source, source.choice(sorted((GAMES / "manuals").glob("*.toml")))), encoding="utf-8")
    refused_or_read(
        lambda: load_manual(file, {key: range(256) for key in ("modes", "difficulties", "multiplayer_modes")})
    )


def interventions_file(source: random.Random, folder: Path) -> None:
    """A file of interventions is refused, or its texts are printable."""
    shipped = source.choice(sorted((GAMES / "interventions" / "data").glob("*.toml")))
    file = folder / "interventions.toml"
    file.write_text(toml(source, shipped), encoding="utf-8")
    for one in (refused_or_read(lambda: interventions.load(shipped.stem, file)) or {}).values():
        assert one.name.isprintable(), "the name is not printable"
        assert one.description.replace("\n", "").replace("\t", "").isprintable(), "the description is not printable"


def task_file(source: random.Random, folder: Path) -> None:
    """A task is refused, or explained. Its options may be of the wrong kind: `Task.from_json` raises TypeError, too."""
    text = json.dumps(mutated(source, TASK))
    (folder / "task.json").write_text(text)
    with contextlib.suppress(TypeError):
        refused_or_read(lambda: atari.Task.from_json(text))
    printed("info", str(folder / "task.json"))


def video_file(source: random.Random, folder: Path) -> None:
    """What a video says of itself is refused, or printed."""
    facts = {"task": TASK, "package": "atari-envs 0.2.0", "core_seeds": [1, 2]}
    comment = json.dumps(mutated(source, facts)).replace("\x00", "")
    with VideoWriter(folder / "a.mp4", atari.games["pong"], sound=False, comment=comment) as video:
        video.write(np.zeros((210, 160, 3), np.uint8))
    printed("info", str(folder / "a.mp4"))
    printed("info", str(folder / "a.mp4"), "--json")


def result_file(source: random.Random, folder: Path) -> None:
    """The result of an evaluation is refused, or read."""
    (folder / "evaluation.json").write_text(json.dumps(mutated(source, RESULT)))
    found = refused_or_read(lambda: Result.load(folder / "evaluation.json"))
    if found is not None:
        refused_or_read(lambda: str(found))
