"""Plays a game into the situations in which a label may be wrong, and compares labels with the emulator's own figures.

The situations are resets in each mode, play, ends, demo screens after an end, and the wrap of the score. The figures
are `core.lives`, and the score of the rules, which other tests compare with ale-py in each frame.
"""

import ast
import re
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rules_interpreter import evaluate

import atari
from atari.cores import NativeCore
from atari.games.game import Game, load_game
from atari.games.objects import positions
from atari.lab import Ram
from atari.lab.labels import Labels

Array = Any


@dataclass(frozen=True)
class Played:
    """Frames of play: `ram` (frames, 128) uint8, `lives` (frames,) int, and the situation of each frame."""

    ram: Array
    lives: Array
    situation: Array


class Recorder:
    """Plays frames with random actions and records them."""

    def __init__(self, game: Game, rom: Path | None = None) -> None:
        self.core = NativeCore(game, repeat_action_probability=0.0, rom=rom)
        self._rows: list[tuple[Any, int, str]] = []
        self.begin()

    def begin(self) -> None:
        """Begin the same game again."""
        self.core.seed(0)
        self.core.reset()
        self._random = np.random.default_rng(0)

    def record(self, situation: str) -> None:
        """Record the frame that the console shows."""
        self._rows.append((self.core.ram(), self.core.lives, situation))

    def play(self, frames: int, situation: str) -> bool:
        """Play until the game is over or these frames are played, and return whether it is over."""
        actions = self.core.game.legal_actions
        action = 0
        for frame in range(frames):
            if frame % 6 == 0:
                action = int(actions[self._random.integers(len(actions))])
            self.core.act(action)
            self.record("end" if self.core.game_over else situation)
            if self.core.game_over:
                return True
        return False

    def play_out(self, frames: int, hurried: int, situation: str = "play") -> bool:
        """Play until the game is over, after some frames with one life, and return whether it is over."""
        if self.play(frames, situation):
            return True
        self.hurry()
        return self.play(hurried, situation)

    def hurry(self) -> None:
        """Take all lives but the last, where a byte holds them and the rules follow it at once."""
        game = self.core.game
        label = game.ram_labels.get("lives")
        if label is None or label.evidence != "confirmed" or not pure(game, "lives"):
            return
        labels, ram = Labels(game, ["lives"]), self.core.ram()
        for lives in (1, 0):
            with suppress(ValueError):
                self.core.set_ram(label.index, labels.byte_of("lives", ram, lives))
                return

    def full_score(self) -> None:
        """Write nines into all digits of the score."""
        for label in self.core.game.ram_labels.values():
            if label.kind == "score" and label.encoding == "bcd" and label.evidence.startswith("confirmed"):
                mask = label.mask or 255
                self.core.set_ram(label.index, int(self.core.ram()[label.index]) & (255 ^ mask) | 0x99 & mask)

    def played(self) -> Played:
        """All frames, after closing the core."""
        self.core.close()
        ram, lives, situation = zip(*self._rows, strict=True)
        return Played(np.stack(ram), np.array(lives), np.array(situation))


def situations(game: Game, frames: int) -> Iterator[Played]:
    """Plays of a game, with about this number of frames each, resets with fewer."""
    recorder = Recorder(game)
    for mode in game.modes:
        for difficulty in game.difficulties if mode == game.default_mode else game.difficulties[:1]:
            recorder.core.set_mode(mode)
            recorder.core.set_difficulty(difficulty)
            recorder.begin()
            recorder.record("reset")
            recorder.play(30, "reset")
    yield recorder.played()
    recorder = Recorder(game)
    if recorder.play_out(frames // 3, 2 * frames // 3):
        recorder.core.reset()
        recorder.record("reset")
    yield recorder.played()
    recorder = Recorder(game)
    recorder.play(60, "play")
    recorder.full_score()
    recorder.play(frames // 3, "wrap")
    yield recorder.played()
    with tempfile.TemporaryDirectory() as folder:
        recorder = Recorder(load_game(endless(game, Path(folder))), atari.roms.find(game))
    recorder.play_out(frames // 3, 2 * frames // 3, "demo")
    yield recorder.played()


def endless(game: Game, folder: Path) -> Path:
    """A game file with the rules of a game, without its end: so the console reaches the screens after it."""
    text = (Path(atari.__file__).parent / "games" / "data" / f"{game.id}.toml").read_text(encoding="utf-8")
    file = folder / f"{game.id}.toml"
    rules = re.compile(r"(\n\[rules\].*?\nstep = '''.*?)'''", re.DOTALL)
    file.write_text(rules.sub(r"\1terminal = 0\n'''", text, count=1), encoding="utf-8")
    return file


def pure(game: Game, name: str) -> bool:
    """Whether the rules give this value of a frame by its RAM alone, without what was before."""
    assert game.rules is not None
    lines = dict(game.rules.step)
    return name in lines and not names_of(name, lines) & {*game.rules.state, "xram", "rng"}


def points(game: Game, ram: Array) -> Array:
    """The score of the rules in each frame, (frames,), if it is pure."""
    assert game.rules is not None
    needed = {"points", *names_of("points", dict(game.rules.step))}
    lines = [(name, source) for name, source in game.rules.step if name in needed]
    addresses = {int(number, 16) for _, line in lines for number in re.findall("0x[0-9A-F]+", line)}
    columns = sorted(address - 0x80 for address in addresses if 0x80 <= address <= 0xFF)
    rows, inverse = np.unique(ram[:, columns], axis=0, return_inverse=True)
    return np.array([_points(lines, columns, row) for row in rows])[inverse.reshape(-1)]


def _points(lines: list[tuple[str, str]], columns: list[int], row: Array) -> int:
    memory = np.zeros(128, np.uint8)
    memory[columns] = row
    variables: dict[str, int] = {}
    for name, source in lines:
        variables[name] = evaluate(source, memory, variables)
    return variables["points"]


def names_of(name: str, lines: dict[str, str]) -> set[str]:
    """The names that a line of the rules depends on."""
    found: set[str] = set()
    queue = [name]
    while queue:
        for node in ast.walk(ast.parse(lines[queue.pop()], mode="eval")):
            if isinstance(node, ast.Name) and node.id not in found:
                found.add(node.id)
                if node.id in lines:
                    queue.append(node.id)
    return found


def undrawn_at_reset(game: Game) -> set[str]:
    """The visible objects that none of the first four frames shows: many games draw an object in each second frame."""
    recorder = Recorder(game)
    frames = []
    for _ in range(4):
        frames.append(undrawn(recorder))
        recorder.core.act(0)
    return set.intersection(*frames)


def undrawn(recorder: Recorder) -> set[str]:
    """The objects whose box has one colour, or is beside the screen: of those with two places and confirmed labels.

    An object that is partly beside the screen may be under its edge.
    """
    screen, found = recorder.core.screen(), set()
    labels = positions(recorder.core.game.ram_labels)
    for each in Ram(recorder.core).objects():
        confirmed = all(label.evidence.startswith("confirmed") for label in labels[each.name].values())
        if confirmed and each.x is not None and each.y is not None:
            left, top, width, height = each.x, each.y, each.width or 8, each.height or 8
            inside = screen[max(top, 0) : max(top + height, 0), max(left, 0) : max(left + width, 0)]
            box = screen[max(top - 2, 0) : top + height + 2, max(left - 2, 0) : left + width + 2]
            if not inside.size or (inside.size == width * height and (box == box.flat[0]).all()):
                found.add(each.name)
    return found
