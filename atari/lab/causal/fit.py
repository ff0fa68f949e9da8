"""`suggest` makes suggestions from the effects of forks: positions with their transforms, score bytes, lives bytes."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from atari.lab.causal.map import Suggestion

Integers = NDArray[np.int32]

COLUMNS = (
    "state byte old_value new_value old_then new_then frame left top right bottom pixels dx dx_score dy dy_score "
    "unbalanced reward lives reward_later lives_later over"
).split()
"""The numbers of an effect, in the order of `ForkEffect` in emulator/lab/causes.hpp."""

TOLERANCE = 2
"""Pixels by which a position may differ from its transform."""

_FEWEST = 10  # forks that a suggestion needs
_LEAST_SHARE = 0.5  # part of these forks that agree
_CLEAR = 90  # percentage of pixels that a shift explains
_MIXED = 30  # percentage of pixels without a counterpart, at most

_NEAR = 32  # changes of a byte up to this are near ones

_SLOPES = (1, -1, 2, -2, 3, 4, -4, 8, -8, 9, 16, -16)
_FINE = "(v % 16) * 15 + ((23 if v >> 4 > 7 else 7) - (v >> 4))"
_FINE_ODD = (
    "(64 if v == 0 else 4 if v == 1 else (97 if v % 2 == 0 else 10) + 15 * ((v & 15) // 2 - 1) + 8 * (v >> 7)"
    " - ((v >> 4) & 7))"
)


def _fine(v: Integers) -> Integers:
    """15 pixels for each unit of the low nibble, less the high nibble as the TIA's motion registers read it."""
    return (v % 16) * 15 + np.where(v >> 4 > 7, 23, 7) - (v >> 4)


def _fine_odd(v: Integers) -> Integers:
    """As `_fine`, with one bit of the low nibble and the sign of the high nibble in other places."""
    far = np.where(v % 2 == 0, 97, 10) + 15 * ((v & 15) // 2 - 1) + 8 * (v >> 7) - ((v >> 4) & 7)
    return np.where(v == 0, 64, np.where(v == 1, 4, far))


def _candidates(axis: str, v: Integers) -> Iterator[tuple[float, Integers, str]]:
    """Yield the transforms to try: a cost, the values of `v` without a constant, and the text of this part.

    The cost is the part of forks by which a transform must be better than the plainest transform.
    """
    for slope in _SLOPES:
        text = {1: "v", -1: "-v"}.get(slope, f"{slope} * v")
        yield 0.01 * (abs(slope) - 1), slope * v, text
    for divisor in (2, 4, 16):
        yield 0.12, v // divisor, f"v // {divisor}"
    yield 0.05, v * 3 // 2, "(v * 3) // 2"
    for bits in (15, 31, 63, 127):
        yield 0.12, v & bits, f"(v & {bits})"
    if axis == "x":
        yield 0.1, _fine(v), _FINE
        yield 0.1, _fine_odd(v), _FINE_ODD


def _plus(text: str, k: int) -> str:
    if text.startswith("-"):
        return f"{k} - {text[1:]}"
    return f"{text} + {k}" if k > 0 else f"{text} - {-k}" if k < 0 else text


def table(effects: Integers) -> dict[str, Integers]:
    """The columns of an array of effects by name."""
    return dict(zip(COLUMNS, effects.T, strict=True))


def suggest(effects: Integers, forks: NDArray[np.int64], seen: NDArray[np.int64]) -> tuple[Suggestion, ...]:
    """The suggestions for all bytes.

    Args:
        effects: (n, 22) int32, as `_emulator.Causes.effects` returns them.
        forks: (128,), the number of forks of each byte.
        seen: (128,), the number of forks in which pixels differed.
    """
    found: list[Suggestion | None] = []
    for byte in range(128):
        own = table(effects[effects[:, 1] == byte])
        found += [_position(own, axis, int(seen[byte])) for axis in "xy"]
        found += [_score(own, int(forks[byte])), _lives(own, int(forks[byte]))]
    return tuple(each for each in found if each is not None)


def samples(own: dict[str, Integers], axis: str) -> tuple[Integers, Integers, NDArray[np.bool_]]:
    """Pairs of a byte's values, and of positions: (n, 2) each, twin and fork; and the effects that they are from.

    The values are read after the compared frame, like a label's, or before it if the game has rewritten the byte.
    """
    distance, score = own[f"d{axis}"], own[f"d{axis}_score"]
    other = own["dy_score" if axis == "x" else "dx_score"]
    moves = (distance != 0) & (score >= _CLEAR) & (own["unbalanced"] <= _MIXED) & (other < _CLEAR)
    moves &= np.abs(distance) < (150 if axis == "x" else 180)
    then = own["old_then"] != own["new_then"]
    values = np.stack([np.where(then, own[f"{each}_then"], own[f"{each}_value"]) for each in ("old", "new")], 1)[moves]
    near = own["left" if axis == "x" else "top"][moves]
    shift = distance[moves]
    start = np.where(shift > 0, near, near - shift)
    return values, np.stack([start, start + shift], 1), moves


def _position(own: dict[str, Integers], axis: str, seen: int) -> Suggestion | None:
    values, places, moves = samples(own, axis)
    if len(values) < max(_FEWEST, seen // 25):
        return None
    change = np.abs(values[:, 1] - values[:, 0])
    # Far changes may leave the range that the game draws, and steps of one may be rounded.
    near = (change > 1) & (change <= _NEAR)
    allowed = np.clip(change // 2, 1, TOLERANCE)
    steps_of = np.abs(places[:, 1] - places[:, 0])
    if (change > 3).any() and (steps_of[change > 3] <= TOLERANCE).mean() > 0.5:
        return None  # it moves something a little, whatever its value
    best, value, text = 0.0, _LEAST_SHARE, ""
    for cost, expected, term in _candidates(axis, values):
        moved = places[:, 1] - places[:, 0] - (expected[:, 1] - expected[:, 0])
        if axis == "x":
            moved = (moved + 80) % 160 - 80  # positions wrap
        steps = np.abs(moved) <= allowed
        share = float(steps.mean())
        if near.sum() >= _FEWEST:
            share = max(share, float(steps[near].mean()) - 0.1)
        if share - cost <= value:
            continue
        k = _constant((places - expected)[steps].ravel(), axis, expected[steps])
        best, value, text = share, share - cost, _plus(term, k)
    if not text:
        return None
    widths = own["right"][moves] - own["left"][moves] + 1 - (np.abs(own["dx"][moves]) if axis == "x" else 0)
    heights = own["bottom"][moves] - own["top"][moves] + 1 - (np.abs(own["dy"][moves]) if axis == "y" else 0)
    width, height = (max(int(np.median(sizes)), 1) for sizes in (widths, heights))
    return Suggestion(int(own["byte"][0]), f"position_{axis}", len(values), round(best, 3), text, width, height)


def _constant(rest: Integers, axis: str, expected: Integers) -> int:
    """The constant that most places agree on within a pixel. Columns wrap; the constant gives places on the screen."""
    wraps = axis == "x"
    numbers, counts = np.unique(rest % 160 if wraps else rest, return_counts=True)
    apart = np.abs(numbers[:, None] - numbers[None, :])
    if wraps:
        apart = np.minimum(apart, 160 - apart)
    weight = ((apart <= 1) * counts[None, :]).sum(1) + counts / (counts.sum() + 1)
    k = int(numbers[weight.argmax()])
    if wraps:
        k += 160 * round((80 - int(np.median(expected)) - k) / 160)
    return k


def _score(own: dict[str, Integers], forks: int) -> Suggestion | None:
    paid = own["reward"] != 0
    if paid.sum() < max(_FEWEST, forks // 4):
        return None
    reward = own["reward"][paid].astype(np.int64)
    old, new = own["old_value"][paid], own["new_value"][paid]
    best = None
    for encoding in ("bcd", "plain"):
        change = new - old if encoding == "plain" else _bcd(new) - _bcd(old)
        known = change != 0
        if not known.any():
            continue
        weights, counts = np.unique(reward[known] // change[known], return_counts=True)
        weight = int(weights[counts.argmax()])
        share = float((reward == weight * change).mean())
        if share >= 0.4 and weight and (best is None or share > best.share + 0.05):
            best = Suggestion(
                int(own["byte"][0]), "score", int(paid.sum()), round(share, 3), weight=weight, encoding=encoding
            )
    return best


def _bcd(value: Integers) -> Integers:
    return 10 * (value >> 4) + (value & 15)


def _lives(own: dict[str, Integers], forks: int) -> Suggestion | None:
    changed = own["lives"] != 0
    if changed.sum() < max(_FEWEST, forks // 5):
        return None
    steps = (own["new_value"] - own["old_value"])[changed]
    share = max(float((own["lives"][changed] == sign * steps).mean()) for sign in (1, -1))
    if share < 0.3:
        return None
    return Suggestion(int(own["byte"][0]), "lives", int(changed.sum()), round(share, 3))
