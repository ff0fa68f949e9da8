"""`draw` makes a picture of a causal map: a small heat image over the dimmed screen for each of the 128 bytes."""

from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from atari.base import durable, font
from atari.base.png import png
from atari.games.game import Game
from atari.lab.causal.map import ByteCauses, CausalMap, Suggestion

Picture = NDArray[np.uint8]
_Colour = tuple[int, int, int]

_MARGIN, _TEXT = 6, 30  # pixels: beside a cell; height of the two lines of text above its image
_WIDTH = 160
_BACKGROUND: _Colour = (18, 20, 26)
_PALE: _Colour = (226, 228, 232)
_FAINT: _Colour = (118, 122, 132)
_CATEGORIES: dict[str, tuple[_Colour, str]] = {
    "position": ((96, 176, 255), "moves something: its column or row follows the byte"),
    "score": ((255, 204, 77), "pays reward at once: the rules read it as score"),
    "lives": ((255, 107, 107), "changes the lives at once"),
    "drawn": ((126, 217, 160), "changes the screen in another way"),
    "hidden": ((188, 148, 255), "changes other bytes, reward or lives, not the screen"),
    "derived": ((118, 122, 132), "derived: rewritten before it is read, so a poke does nothing"),
    "inert": ((70, 74, 84), "nothing follows within the frames played"),
}
"""The colour in RGB and the meaning of each category of bytes."""


def draw(causal_map: CausalMap, game: Game | None = None) -> Picture:
    """The map as a picture, (rows, columns, 3) uint8 in RGB: 16 bytes a row, from address $80 to $FF.

    An image is the dimmed screen of one state. It is lit where changes of the byte changed pixels, the brighter the
    more often. Above it are address and index, the name in the game definition if `game` is given, and the map's
    suggestion or remark about the byte.
    """
    screen = causal_map.screen
    if screen is None:
        screen = np.full((causal_map.height, _WIDTH, 3), 40, np.uint8)
    labels = [] if game is None else list(game.ram_labels.values())
    cells = []
    for byte in causal_map.bytes:
        names = [label.name for label in labels if label.index == byte.index]
        suggestions = [each for each in causal_map.suggestions if each.index == byte.index]
        cells.append(_cell(causal_map, byte, screen, names, suggestions))
    rows = [np.concatenate(cells[first : first + 16], 1) for first in range(0, 128, 16)]
    grid = np.concatenate(rows, 0)
    return np.concatenate([_header(causal_map, game, screen, grid.shape[1]), grid], 0)


def write_png(causal_map: CausalMap, file: str | PathLike[str], game: Game | None = None) -> None:
    """Write the picture of `draw` to a PNG file."""
    durable.write_file(Path(file), png(draw(causal_map, game)))


def category(byte: ByteCauses, suggestions: list[Suggestion]) -> str:
    """The category of a byte: a key of `_CATEGORIES`."""
    kinds = [each.kind.split("_")[0] for each in suggestions]
    for kind in ("position", "score", "lives"):
        if kind in kinds:
            return kind
    if byte.seen >= 0.02:
        return "drawn"
    if byte.derived or byte.inert:
        return "derived" if byte.derived else "inert"
    return "hidden" if byte.writes or byte.reward or byte.lives else "derived" if byte.rewritten > 0.5 else "inert"


def _cell(
    causal_map: CausalMap, byte: ByteCauses, screen: Picture, names: list[str], suggestions: list[Suggestion]
) -> Picture:
    height = causal_map.height // 2
    kind = category(byte, suggestions)
    colour = _CATEGORIES[kind][0]
    cell = np.full((_TEXT + height + _MARGIN, _WIDTH + _MARGIN, 3), _BACKGROUND, np.uint8)
    font.write(cell, f"${0x80 + byte.index:02X} {byte.index}", 0, 5, _FAINT)
    font.write(cell, ", ".join(names), 52, 5, _PALE)
    font.write(cell, _remark(byte, kind, suggestions), 0, 18, colour)
    cell[_TEXT : _TEXT + height, :_WIDTH] = _lit(causal_map, byte, screen, kind)
    frame = cell[_TEXT : _TEXT + height, :_WIDTH]
    frame[[0, -1]] = frame[:, [0, -1]] = colour
    return cell


def _remark(byte: ByteCauses, kind: str, suggestions: list[Suggestion]) -> str:
    """The remark of a cell about its byte, in at most 26 letters if possible."""
    positions = [f"{each.kind[-1]} = {_short(each.transform)}" for each in suggestions if each.transform]
    if positions:
        return ", ".join(positions)
    for each in suggestions:
        if each.kind == "score":
            return f"score, {each.encoding}, unit {each.weight}"
    if kind == "lives":
        return "lives"
    if kind == "drawn":
        return f"seen {byte.seen:.0%}, writes {len(byte.writes)}"
    if kind == "hidden":
        effects = [name for name in ("reward", "lives", "over") if getattr(byte, name)]
        return ", ".join([*effects, f"writes {len(byte.writes)}"])
    return kind


def _short(transform: str) -> str:
    return transform if len(transform) <= 18 else "nibbles of v"


def _lit(causal_map: CausalMap, byte: ByteCauses, screen: Picture, kind: str) -> Picture:
    """The dimmed screen at half its rows, lit where changes of the byte change pixels."""
    counts = causal_map.pixel_counts
    heat = byte.pixels.astype(np.float64) if counts is None else counts[byte.index].astype(np.float64)
    heat = np.sqrt(heat / max(heat.max(), 1))
    rows = causal_map.height // 2 * 2
    heat = heat[:rows].reshape(-1, 2, _WIDTH).max(1)[..., None]
    grey = screen[:rows].mean(2).reshape(-1, 2, _WIDTH).max(1)
    dim = 14 + grey * (0.12 if kind in ("derived", "inert", "hidden") else 0.30)
    back = np.stack([dim, dim, dim * 1.15], 2)
    hot = np.clip(np.concatenate([heat * 500, heat * heat * 300, np.maximum(heat - 0.75, 0) * 900], 2), 0, 255)
    strength = np.clip(heat * 1.6, 0, 1)
    return np.clip(back * (1 - strength) + hot * strength, 0, 255).astype(np.uint8)


def _header(causal_map: CausalMap, game: Game | None, screen: Picture, width: int) -> Picture:
    doubled = screen.repeat(2, 1)
    header = np.full((len(doubled) + 3 * _MARGIN, width, 3), _BACKGROUND, np.uint8)
    header[_MARGIN : _MARGIN + len(doubled), : doubled.shape[1]] = doubled
    left = doubled.shape[1] + 24
    title = game.title if game is not None else causal_map.game
    font.write(header, title, left, 14, _PALE, 2)
    settings = ", ".join(f"{name} {value}" for name, value in causal_map.settings.items())
    font.write(header, f"the effects of each byte of RAM: {settings}", left, 43, _FAINT)
    for line, (name, (colour, text)) in enumerate(_CATEGORIES.items()):
        top = 68 + 20 * line
        header[top : top + 13, left : left + 13] = colour
        font.write(header, f"{name}: {text}" if name not in text else text, left + 20, top + 3, _PALE)
    left, lines = left + 520, len(doubled) // 17
    for place, each in enumerate(causal_map.suggestions[: 4 * lines]):
        column, line = divmod(place, lines)
        colour = _CATEGORIES[each.kind.split("_")[0]][0]
        text = str(each).replace(each.transform, _short(each.transform)) if each.transform else str(each)
        font.write(header, text, left + 440 * column, 15 + 17 * line, colour)
    return header
