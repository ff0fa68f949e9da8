"""`Readings`: names of bytes, values of labels and objects on the screen, as the inspector shows them."""

from contextlib import suppress
from typing import Any

from atari.cores import ByteArray
from atari.games.game import Game
from atari.lab.causal.files import shipped_causes
from atari.lab.causal.map import ByteCauses, CausalMap
from atari.lab.labels import labels_of
from atari.lab.objects import positions, visible_objects


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
