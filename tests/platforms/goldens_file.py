"""Writes the golden values, with the games and their ROM images, as the text that the program `goldens` reads.

The golden values are those of tests/conformance/goldens.json. The text is not part of the repository: it contains the
ROM images of the installed ale-py.
"""

import argparse
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import atari
from atari.games.game import Game

TESTS = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(TESTS / "instructions"))
from game_words import game_words  # noqa: E402


def golden_words(golden: dict[str, Any], stand_in: bool) -> list[str]:
    """The words of a state: check sums, check sums of all frames so far, then lives, end, reward, resets, counters."""
    names = ("ram", "screen", "audio")
    found = [golden[name] for name in names]
    if "chain" in golden:
        found += [golden["chain"][name] for name in names]
    if not stand_in:
        found += [golden["lives"], golden["game_over"]]
        found += [golden[key] for key in ("reward", "resets") if key in golden]
    found += [golden[key] for key in ("frame_number", "episode_frame_number") if key in golden]
    return [word if isinstance(word, str) else str(int(word)) for word in found]


def golden_values(golden: dict[str, Any]) -> dict[str, list[str]]:
    """The words of each golden state of a game, by name."""
    stand_in = bool(golden["stand_in"])
    values = {f"noop_{frames}": golden_words(state, stand_in) for frames, state in golden["noop"].items()}
    return {**values, "random": golden_words(golden["random"], stand_in)}


def played_game(name: str, golden: dict[str, Any]) -> Game:
    """The game as it was played for its golden values."""
    game, stand_in = atari.games[name], golden["stand_in"]
    if not stand_in:
        return game
    rules = atari.games[stand_in]  # the cartridges for two players were run under the rules of another game
    return replace(rules, id=name, rom=game.rom, screen=game.screen, controllers=game.controllers)


def game_text(name: str, golden: dict[str, Any]) -> str:
    """The lines of a game."""
    values = golden_values(golden)
    expected = "".join(f"{key} {' '.join(words)}\n" for key, words in values.items())
    return f"game {name}\nstand_in {int(bool(golden['stand_in']))}\n{game_words(played_game(name, golden))}{expected}"


def main() -> None:
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path)
    options = parser.parse_args()
    goldens = json.loads((TESTS / "conformance" / "goldens.json").read_text())["games"]
    options.output.write_text("\n".join(game_text(name, golden) for name, golden in goldens.items()))
    print(f"{len(goldens)} games in {options.output}")


if __name__ == "__main__":
    main()
