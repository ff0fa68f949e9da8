#!/usr/bin/env python
"""Makes the causal maps that are part of the package, and compares their suggestions with the labels of the games.

`scripts/generate/causal_maps.py` explores all games with single-player rules and writes atari/lab/causal/data/. With
names of games it does so for these. `--labels` prints which position labels with evidence that begins with "confirmed"
are found again, by game, and why the others are not. `--no-write` only compares.
"""

import argparse
import time
from collections import Counter
from dataclasses import replace
from os import cpu_count

import numpy as np
from tqdm import tqdm

from atari.base.frozen import FrozenDict
from atari.games.catalog import games
from atari.games.game import Game, RamLabel
from atari.lab import causes
from atari.lab.causal.files import DATA, save
from atari.lab.causal.fit import samples, table
from atari.lab.causal.map import POSITIONS, CausalMap, Suggestion
from atari.lab.labels import Labels, labels_of

NEAR = 4
"""Pixels by which a label and a suggestion may differ: labels may be of another edge, or of the frame before."""

FOUND = "found"


def outcome(causal_map: CausalMap, game: Game, label: RamLabel) -> str:
    """Whether the map finds a position label again; if not, the reason."""
    byte = causal_map.bytes[label.index]
    ours = [each for each in causal_map.suggestions if each.index == label.index and each.kind in POSITIONS]
    same = [each for each in ours if each.kind == label.kind]
    if same:
        return compare(causal_map, game, label, same[0])
    if byte.derived:
        return "derived: the game rewrites it from other bytes before it draws"
    if byte.seen < 0.02:
        return "not seen: no change of it changes the screen in these states"
    if ours:
        return "other axis"
    if moved(causal_map, label) < 10:
        return "nothing keeps its shape: changes of it make things appear, vanish or change, in these states"
    return "moves something, but by no transform that is tried"


def compare(causal_map: CausalMap, game: Game, label: RamLabel, suggestion: Suggestion) -> str:
    """Whether a suggestion gives the position that the label gives, in the states of the map."""
    ram = causal_map.ram
    assert ram is not None
    visible = labels_of(game, label.name).evaluate(ram)[1][:, 0]
    theirs, ours = values(game, label.index, label.transform, ram), values(game, label.index, suggestion.transform, ram)
    rest = (ours - theirs)[visible if visible.any() else slice(None)]
    if label.kind == "position_x":
        rest = (rest + 80) % 160 - 80
    middle = np.median(rest)
    if np.mean(np.abs(rest - middle) <= NEAR) < 0.75:
        return "found, by another transform"
    return FOUND if abs(middle) <= NEAR else "found, but its constant differs: another edge, or another thing"


def values(game: Game, index: int, transform: str | None, ram: np.ndarray) -> np.ndarray:
    """The values of a transform of a byte in states of a game."""
    label = RamLabel("position", index, "position_x", ("measured",), "", transform=transform)
    return Labels(replace(game, ram_labels=FrozenDict({label.name: label}))).evaluate(ram)[0][:, 0]


def moved(causal_map: CausalMap, label: RamLabel) -> int:
    """The number of forks in which a change of the label's byte moved something along its axis."""
    effects = causal_map.effects
    assert effects is not None
    return len(samples(table(effects[effects[:, 1] == label.index]), label.kind[-1])[0])


def confirmed(game: Game) -> list[RamLabel]:
    """The position labels of a game that its definition says are confirmed."""
    labels = game.ram_labels.values()
    return [each for each in labels if each.kind in POSITIONS and each.evidence.startswith("confirmed")]


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("games", nargs="*", metavar="GAME", help="default: all games")
    parser.add_argument("--labels", action="store_true", help="compare the suggestions with the labels")
    parser.add_argument("--no-write", action="store_true", help="do not write the maps")
    parser.add_argument("--threads", type=int, default=cpu_count())
    args = parser.parse_args()
    chosen = [games.find(name) for name in args.games] or list(games.playable())
    outcomes: Counter[str] = Counter()
    seconds = []
    for game in tqdm(chosen, unit=" games", disable=None):
        start = time.process_time()
        found = causes(game, threads=args.threads)
        seconds.append(time.process_time() - start)
        if not args.no_write:
            save(found, DATA / f"{game.id}.npz")
        if args.labels:
            for label in confirmed(game):
                result = outcome(found, game, label)
                outcomes[result] += 1
                tqdm.write(f"{game.id} {label.name} {label.index} {label.kind}: {result}")
    print(f"{len(chosen)} games, {np.median(seconds):.1f} s of processor time a game, at most {max(seconds):.1f} s")
    for result, count in outcomes.most_common():
        print(f"{count:4} {count / outcomes.total():6.1%}  {result}")


if __name__ == "__main__":
    main()
