"""`Readings`: the meanings of bytes in a game, and the effects of each byte in one state, as the inspector shows them.

The effects are found in copies of the state in which bytes are changed; the screens are compared.
"""

from contextlib import suppress
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.cores import ByteArray, Core
from atari.games.game import Game
from atari.games.objects import positions, visible_objects
from atari.lab.causal.files import shipped_causes
from atari.lab.causal.map import ByteCauses, CausalMap
from atari.lab.labels import labels_of

_CHANGES = (1, 255, 8, 248, 128)
"""Added to a byte, modulo 256."""
_FRAMES = 2
_MOST_BYTES = 12

Mask = npt.NDArray[np.bool_]


class Readings:
    """The values of a game's labels in a state."""

    def __init__(self, game: Game) -> None:
        self.names: dict[int, list[str]] = {}
        """The names of the labels of each byte."""
        for name, label in game.ram_labels.items():
            self.names.setdefault(label.index, []).append(name)
        self.causes: CausalMap | None = None
        """The package's causal map of the game, if there is one."""
        with suppress(ValueError):
            self.causes = shipped_causes(game)
        self._labels = labels_of(game)
        self._positions = positions(game.ram_labels)

    def read(self, ram: ByteArray) -> tuple[dict[str, int | None], list[list[Any]]]:
        """The value of each label, None where its object is not on the screen; and the objects on the screen.

        An object is its name, x, y, width and height in pixels, None where they are not known.
        """
        values = self._labels.values(ram)
        objects = visible_objects(self._positions, values)
        return values, [[each.name, each.x, each.y, each.width, each.height] for each in objects]

    def facts(self) -> dict[int, str]:
        """The effects of each byte by the causal map, in words; empty without a map."""
        return {} if self.causes is None else {byte.index: self._fact(byte) for byte in self.causes.bytes}

    def _fact(self, byte: ByteCauses) -> str:
        if byte.derived:
            return "The game rewrites it in each frame: a poke has no effect."
        parts = [f"seen on the screen after {byte.seen:.0%} of its changes"] if byte.seen else []
        parts += [text for text, found in (("causes reward", byte.reward), ("changes lives", byte.lives)) if found]
        if byte.over:
            parts.append("ends the game")
        if byte.writes:
            names = [self.names.get(index, [f"byte {index}"])[0] for index in byte.writes[:4]]
            parts.append(f"changes {', '.join(names)}")
        if not parts:
            return "No effect is known." if byte.inert else ""
        return f"By the causal map: {'; '.join(parts)}."


def changed_pixels(core: Core, index: int) -> Mask:
    """The pixels that another value of a byte changes within the next frames, (height, 160) bool.

    The core plays and is restored; its state does not change. If the game rewrites the byte before it draws, no pixel
    changes.
    """
    state = core.clone_state(include_rng=True)
    value = int(core.ram()[index])
    try:
        twin = _screens(core)
        changed = np.zeros(core.game.screen.shape, np.bool_)
        for change in _CHANGES:
            core.restore_state(state)
            core.set_ram(index, (value + change) % 256)
            changed |= (_screens(core) != twin).any(axis=0)
        return changed
    finally:
        core.restore_state(state)


def causes_of(core: Core, x: int, y: int) -> list[int]:
    """The bytes that change a pixel or its nearest neighbours within the next frames.

    Bytes that change the pixel itself come first, then bytes that change few other pixels.
    """
    height, width = core.game.screen.shape
    rows, columns = slice(max(0, y - 1), min(height, y + 2)), slice(max(0, x - 1), min(width, x + 2))
    found = []
    for index in range(128):
        changed = changed_pixels(core, index)
        if changed[rows, columns].any():
            found.append((not changed[y, x], int(changed.sum()), index))
    return [index for *_, index in sorted(found)][:_MOST_BYTES]


def ahead(core: Core) -> ByteArray:
    """The screen after the next frame without input, (height, 160) palette indices. The state does not change."""
    state = core.clone_state(include_rng=True)
    try:
        core.act(0)
        return core.screen()
    finally:
        core.restore_state(state)


def _screens(core: Core) -> ByteArray:
    screens = []
    for _ in range(_FRAMES):
        core.act(0)
        screens.append(core.screen())
    return np.stack(screens)
