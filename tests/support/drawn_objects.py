"""Whether the console draws the objects that labels list: a byte of an object's place is changed, and frames compared.

A drawn object leaves its place when a byte of its place changes. If the screens stay equal, nothing shows the object.
"""

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from label_situations import endless, pure

import atari
import atari._emulator as _emulator
from atari.cores import NativeCore
from atari.games.game import Game, RamLabel
from atari.games.labels import compile_label
from atari.games.objects import constants, positions
from atari.games.toml_file import tomllib
from atari.lab.labels import Labels

Array = Any

BRIEF, LONG = 4, 20
"""Frames that are compared: many games draw an object in each second frame; some take a new place at the next move."""

PROBES, BETWEEN = 10, 8
"""An object is undrawn, or hidden though drawn, if each of so many probes shows it, with so many frames between."""

MOST_LOOKS, ENOUGH = 120, 8
"""For how many probes an object is looked for, and how many that show it are enough."""

NEAR = 12
"""An object that moves further than its size and this has left its place."""


@cache
def undecided() -> dict[str, dict[str, str]]:
    """The objects that this check cannot decide, by game, with what was seen."""
    return tomllib.loads(Path(__file__).with_name("undecided_objects.toml").read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Seen:
    """A probe of one object: whether it is listed, whether pixels change, whether they change at its own place."""

    listed: bool
    moves: bool
    leaves: bool


class Probe:
    """Probes of the objects of a game, with random bytes."""

    def __init__(self, game: Game, generator: np.random.Generator) -> None:
        self._game, self._generator = game, generator
        self._objects = positions(game.ram_labels)
        self._visible = {
            name: Labels(game, [label.name for label in axes.values()]) for name, axes in self._objects.items()
        }
        self._values = {
            label.name: _emulator.Labels([compile_label(replace(label, visible=None))])
            for axes in self._objects.values()
            for label in axes.values()
        }
        self.names = tuple(self._objects)

    def listed(self, ram: Array) -> frozenset[str]:
        """The objects that are listed in one RAM."""
        return frozenset(name for name in self.names if self._visible[name].evaluate(ram[None])[1].all())

    def look(self, core: NativeCore, name: str) -> Seen:
        """Change bytes of an object's place, one at a time; afterwards the core is as before."""
        state, ram = core.clone_state(include_rng=True), core.ram()
        height, width = core.screen().shape
        listed = name in self.listed(ram)
        box = self._box(name, ram, width, height)
        tries = [
            (label.index, *poke)
            for axis, label in self._objects[name].items()
            for poke in self._pokes(name, axis, label, ram)
        ]
        seen = Seen(listed, False, False)
        base = _play(core, state, (), BRIEF)
        for index, byte, far in tries:
            changed = _play(core, state, ((index, byte),), BRIEF)
            for before, after in zip(base, changed, strict=True):
                differs = before != after
                if differs.any():
                    seen = Seen(listed, True, seen.leaves or bool(far and box is not None and differs[box].any()))
        if listed and not seen.moves:
            base = _play(core, state, (), LONG)
            moves = any(_differ(base, _play(core, state, ((index, byte),), LONG)) for index, byte, _ in tries)
            seen = Seen(listed, moves or not tries, False)
        core.restore_state(state)
        return seen

    def offset(self, core: NativeCore, name: str, axis: str) -> int | None:
        """How far from its row (axis "x") or column (axis "y") an object is drawn; None if nothing shows it.

        A byte of its column is changed, so that pixels of the columns that it leaves change: their rows are the
        object's. The run of them that begins nearest counts.
        """
        state, ram = core.clone_state(include_rng=True), core.ram()
        axes = self._objects[name]
        place = self._place(name, ram)
        across = place["y" if axis == "x" else "x"]
        if name not in self.listed(ram) or not 0 <= place[axis] < core.screen().shape[axis == "x"]:
            return None
        label = axes[axis]
        size = (label.width if axis == "x" else label.height) or 8
        around = slice(max(place[axis] - 3, 0), place[axis] + size + 3)
        base, starts = _play(core, state, (), BRIEF), []
        for byte in [byte for byte, far in self._pokes(name, axis, label, ram) if far]:
            for before, after in zip(base, _play(core, state, ((label.index, byte),), BRIEF), strict=True):
                differs = (before != after) if axis == "x" else (before != after).T
                lines = np.flatnonzero(differs[:, around].any(axis=1))
                if lines.size:
                    starts += [int(line) - across for line in lines if line - 1 not in lines]
                    break
        core.restore_state(state)
        return min(starts, key=abs, default=None)

    def _place(self, name: str, ram: Array) -> dict[str, int]:
        """The column and the row of an object, as far as they are known, also while it is not listed."""
        axes = self._objects[name]
        return constants(axes) | {axis: int(self._evaluate(label, ram[None])[0]) for axis, label in axes.items()}

    def _pokes(self, name: str, axis: str, label: RamLabel, ram: Array) -> list[tuple[int, bool]]:
        """Bytes that put the object elsewhere on the screen, and whether it leaves its place."""
        rams = np.repeat(ram[None], 256, axis=0)
        rams[:, label.index] = np.arange(256)
        values = self._evaluate(label, rams)
        now, size = int(values[ram[label.index]]), 160 if axis == "x" else self._game.screen.height
        distance = np.abs(values - now)
        possible = (distance > 0) & (values >= 0) & (values < size - 8)
        if self._visible[name].evaluate(ram[None])[1].all():
            possible &= self._visible[name].evaluate(rams)[1].all(axis=0)
        limit = NEAR + ((label.width if axis == "x" else label.height) or NEAR)
        far = possible & (distance > limit) & ((distance < size - limit) | (axis == "y"))
        chosen = [(int(byte), True) for byte in self._some(np.flatnonzero(far))]
        return chosen + [(int(byte), False) for byte in self._some(np.flatnonzero(possible & ~far))]

    def _some(self, numbers: Array) -> Array:
        return self._generator.choice(numbers, min(3, len(numbers)), replace=False)

    def _evaluate(self, label: RamLabel, rams: Array) -> Array:
        values, shown = np.empty((1, len(rams)), np.int32), np.empty((1, len(rams)), np.bool_)
        self._values[label.name].evaluate(np.ascontiguousarray(rams), values, shown)
        return values[0]

    def _box(self, name: str, ram: Array, width: int, height: int) -> tuple[slice, slice] | None:
        """Rows and columns around an object whose two places are on the screen; None for others."""
        axes, place = self._objects[name], self._place(name, ram)
        if len(place) < 2:
            return None
        x, y = place["x"], place["y"]
        wide = next((label.width for label in axes.values() if label.width), 8)
        high = next((label.height for label in axes.values() if label.height), 8)
        if not (0 <= x <= width - wide and 0 <= y <= height - high):
            return None
        return slice(max(y - 2, 0), y + high + 2), slice(max(x - 2, 0), x + wide + 2)


def _play(core: NativeCore, state: Any, writes: tuple[tuple[int, int], ...], frames: int) -> list[Array]:
    core.restore_state(state)
    for index, byte in writes:
        core.set_ram(index, byte)
    screens = []
    for _ in range(frames):
        core.act(0)
        screens.append(core.screen())
    return screens


def _differ(one: list[Array], other: list[Array]) -> bool:
    return any((before != after).any() for before, after in zip(one, other, strict=True))


class Play:
    """A game that goes on after its end, through the screens that the cartridge then shows, with random actions."""

    def __init__(self, game: Game, seed: int, **options: Any) -> None:
        self.game, self.generator = game, np.random.default_rng(seed)
        self._folder = tempfile.TemporaryDirectory()
        file = endless(game, Path(self._folder.name))
        rom = atari.roms.find(game.id)
        self.core = NativeCore(file, rom=rom, seed=seed, repeat_action_probability=0.0, **options)
        self.core.reset()
        self._held, self._action = 0, 0

    def close(self) -> None:
        """Delete the game file."""
        self._folder.cleanup()

    def frames(self, count: int) -> None:
        """Play frames with random actions, each held for a random number of frames."""
        for _ in range(count):
            if not self._held:
                self._held = int(self.generator.integers(2, 24))
                self._action = int(self.generator.choice(list(self.game.minimal_actions)))
            self._held -= 1
            self.core.act(self._action)

    def last_life(self) -> None:
        """Take all lives but the last, where a confirmed byte holds them and the rules follow it at once."""
        label = self.game.ram_labels.get("lives")
        if label is None or label.evidence != "confirmed" or not pure(self.game, "lives"):
            return
        labels = Labels(self.game, ["lives"])
        for lives in (1, 0):
            try:
                self.core.set_ram(label.index, labels.byte_of("lives", self.core.ram(), lives))
            except ValueError:
                continue
            return

    def offsets(self) -> dict[tuple[str, str], list[int]]:
        """The offsets of each object with two places, by its name and the axis that is changed; see `Probe.offset`."""
        probe = Probe(self.game, self.generator)
        found: dict[tuple[str, str], list[int]] = {
            (name, axis): []
            for name, axes in positions(self.game.ram_labels).items()
            for axis in axes
            if len(axes | constants(axes)) == 2
        }
        for _ in range(MOST_LOOKS):
            self.frames(BETWEEN)
            for key, offsets in found.items():
                seen = probe.offset(self.core, *key) if len(offsets) < ENOUGH else None
                offsets += [] if seen is None else [seen]
        return found

    def faults(self) -> Iterator[tuple[str, str]]:
        """The objects of the next frames that are listed and never drawn, or never listed and drawn at their place."""
        probe = Probe(self.game, self.generator)
        listed = probe.listed(self.core.ram())
        candidates = {name: name in listed for name in probe.names}
        for _ in range(PROBES):
            for name, was in list(candidates.items()):
                seen = probe.look(self.core, name)
                if seen.listed != was or (seen.moves if was else not seen.leaves):
                    del candidates[name]
            if not candidates:
                return
            self.frames(BETWEEN)
        for name, was in candidates.items():
            yield name, "is listed, and nothing on the screen shows it" if was else "is hidden, and drawn"
