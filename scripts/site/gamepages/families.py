"""Families of RAM labels, whose names, bytes and meanings count on: `block_bits_0` to `block_bits_35`."""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import groupby

from atari.games.game import RamLabel

Meaning = Callable[[RamLabel], str]

_NUMBER = re.compile(r"(\d+)")
_FEWEST = 3  # labels of a family; fewer have a row each


def families(labels: Iterable[RamLabel], meaning: Meaning) -> list[list[RamLabel]]:
    """The labels in order of their bytes, those of a family together in order of their names."""

    def alike(label: RamLabel) -> tuple[str, str, str]:
        return _NUMBER.sub("#", label.name), label.kind, _NUMBER.sub("#", meaning(label))

    found: list[list[RamLabel]] = []
    for _, members in groupby(sorted(labels, key=alike), alike):
        for run in _runs(sorted(members, key=lambda label: _numbers(label.name)), meaning):
            found += [run] if len(run) >= _FEWEST else [[label] for label in run]
    return sorted(found, key=lambda family: min((label.index, label.name) for label in family))


def _runs(labels: Iterable[RamLabel], meaning: Meaning) -> Iterator[list[RamLabel]]:
    """The labels in runs, in which the byte and each number of the meaning change by the same step."""

    def step(earlier: RamLabel, later: RamLabel) -> list[int]:
        pairs = zip(*([label.index, *_numbers(meaning(label))] for label in (earlier, later)), strict=True)
        return [after - before for before, after in pairs]

    run: list[RamLabel] = []
    for label in labels:
        if len(run) > 1 and step(run[-2], run[-1]) != step(run[-1], label):
            kept = [run.pop()] if len(run) == 2 else []  # the second may begin the next run
            yield run
            run = kept
        run.append(label)
    yield run


def merged(texts: Sequence[str]) -> str:
    """Texts of a family as one text, with each number that changes as a series, such as "ram[3 to 9]"."""
    return "".join(map(series, zip(*map(_NUMBER.split, texts), strict=True)))


def series(texts: Sequence[str]) -> str:
    """Equal texts as one, and numbers as "0 to 35" or "27, 43, ... 171"."""
    if len({*texts}) == 1:
        return texts[0]
    return f"{texts[0]} to {texts[-1]}" if abs(int(texts[1]) - int(texts[0])) == 1 else shortened(texts)


def shortened(texts: Sequence[str]) -> str:
    """The first two texts and the last."""
    return ", ".join(texts) if len(texts) <= _FEWEST else f"{texts[0]}, {texts[1]}, ... {texts[-1]}"


def _numbers(text: str) -> list[int]:
    return [int(number) for number in _NUMBER.findall(text)]
