"""`Overlay`: the values that a video shows below the game's screen."""

from array import array
from collections.abc import Sequence

import numpy as np

from atari.cores import ByteArray
from atari.games.actions import Action
from atari.games.game import Game

OVERLAYS = ("score", "lives", "action", "ram", "curve")
CURVE_ROWS = 32
_RAM_LINES = 8
_NO_LIVES = ("0", "1", "0 if terminal else 1")
"""The expressions of `lives` in the rules of games that have none."""
_LINE, _ZERO = (236, 236, 236), (74, 74, 74)


class Overlay:
    """The score, the lives, the action and the RAM as text, and the score of the game so far as a curve.

    Args:
        parts: some of `OVERLAYS`; None means no part.
        game: the game; the lives of a game without lives are not shown.

    Raises:
        ValueError: there is no such part.
    """

    def __init__(self, parts: Sequence[str] | None, game: Game) -> None:
        if isinstance(parts, str) or not set(parts or ()) <= set(OVERLAYS):
            raise ValueError(f"overlay is a tuple of some of {', '.join(map(repr, OVERLAYS))}, got {parts!r}")
        self.parts = tuple(part for part in parts or () if part != "lives" or _has_lives(game))
        self.caption_lines = bool({"score", "lives", "action"} & set(self.parts)) + _RAM_LINES * ("ram" in self.parts)
        self.begin_game()

    def size(self, size: tuple[int, int]) -> tuple[int, int]:
        """(rows, columns) of screens of this size with the curve."""
        return size[0] + CURVE_ROWS * ("curve" in self.parts), size[1]

    def begin_game(self) -> None:
        """Begin with a score of 0."""
        self.score = 0
        self._scores = array("d", [0])

    def add(self, reward: int) -> None:
        """Add the reward of a frame."""
        self.score += reward
        if "curve" in self.parts:
            self._scores.append(self.score)

    def caption(
        self,
        actions: Sequence[int | None],
        ram: ByteArray,
        scores: Sequence[int] | None = None,
        lives: Sequence[int] = (),
    ) -> str:
        """The lines of text.

        Args:
            actions: ALE's number of each player's action.
            ram: (128,) uint8.
            scores: the score of each player; None is the sum of the rewards of one.
            lives: the lives of each player.
        """
        words = []
        if "score" in self.parts:
            words.append(f"score {', '.join(map(str, scores or (self.score,)))}")
        if "lives" in self.parts:
            words.append(f"lives {', '.join(map(str, lives))}")
        if "action" in self.parts:
            words.append(f"action {', '.join('-' if one is None else Action(one).name for one in actions)}")
        lines = ["   ".join(words)] if words else []
        if "ram" in self.parts:
            rows = ram.reshape(_RAM_LINES, 16)
            lines += [f"{128 + 16 * i:02X}:  {rows[i].tobytes().hex(' ').upper()}" for i in range(_RAM_LINES)]
        return "\n".join(lines)

    def draw(self, image: ByteArray) -> ByteArray:
        """The image (rows, columns, 3) with the curve below it, from the game's first frame to this one."""
        if "curve" not in self.parts:
            return image
        columns = image.shape[1]
        scores = np.frombuffer(self._scores)
        shown = scores[np.linspace(0, len(scores) - 1, columns - 2).astype(int)]
        low = min(scores.min(), 0.0)
        high = max(scores.max(), 0.0, low + 1.0)  # without points the curve is a line at the bottom
        rows = np.rint((high - np.append(shown, 0.0)) / (high - low) * (CURVE_ROWS - 3)).astype(int) + 1
        whole = np.zeros((image.shape[0] + CURVE_ROWS, columns, 3), np.uint8)
        whole[: image.shape[0]] = image
        strip = whole[image.shape[0] :]
        strip[rows[-1], 1:-1] = _ZERO
        first, second = rows[:-1], np.append(rows[1:-1], rows[-2])  # each column joins its score and the next one
        row = np.arange(CURVE_ROWS)[:, np.newaxis]
        strip[:, 1:-1][(row >= np.minimum(first, second)) & (row <= np.maximum(first, second))] = _LINE
        return whole


def _has_lives(game: Game) -> bool:
    """Whether the game's rules, for one player or for several, count lives."""
    rules = (game.rules, game.multiplayer and game.multiplayer.rules)
    names = [(one, name) for one in rules if one for name in one.outputs if name.startswith("lives")]
    return any(one.expression(name) not in _NO_LIVES for one, name in names)
