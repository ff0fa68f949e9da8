"""The golden values: check sums of ale-py 0.12.1 for each of its 108 ROM files.

`goldens.json` has the values and the protocol by which they were taken. The tests do not run ale-py. A core that passes
them equals ale-py over 2,000 frames of every game, in RAM, framebuffer and sound at every frame.
"""

import json
import zlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import atari
from atari.cores import NativeCore

GOLDENS: dict[str, Any] = json.loads(Path(__file__).with_name("goldens.json").read_text())["games"]
ARRAYS = ("ram", "screen", "audio")


class GoldenRun:
    """A core that plays the protocol of the golden values, with the sum of rewards and the check sums of all frames."""

    def __init__(self, game: str) -> None:
        golden = GOLDENS[game]
        subject = atari.games[game]
        if golden["stand_in"]:  # the two-player cartridges were run under the rules of another game
            rules = atari.games[golden["stand_in"]]
            subject = replace(rules, id=game, rom=subject.rom, screen=subject.screen, controllers=subject.controllers)
        self.core = NativeCore(subject, seed=123, repeat_action_probability=0.0, sound=True)
        self.reward = 0
        self.chain = dict.fromkeys(ARRAYS, 0)

    def act(self, action: int) -> None:
        self.reward += self.core.act(action)
        for name in ARRAYS:
            self.chain[name] = zlib.crc32(getattr(self.core, name)().tobytes(), self.chain[name])

    def sums(self) -> dict[str, str]:
        return {name: f"{zlib.crc32(getattr(self.core, name)().tobytes()):08x}" for name in ARRAYS}

    def state(self, stand_in: bool) -> dict[str, Any]:
        chain = {name: f"{value:08x}" for name, value in self.chain.items()}
        rules = {} if stand_in else {"lives": self.core.lives, "game_over": self.core.game_over}
        return {**self.sums(), **rules, "reward": self.reward, "chain": chain}


def expected(golden: dict[str, Any], keys: dict[str, Any]) -> dict[str, Any]:
    return {key: golden[key] for key in keys if key in golden}


def generated_actions(count: int, choices: int) -> Iterator[int]:
    x = 1
    for _ in range(count):
        x = (1664525 * x + 1013904223) % 2**32
        yield (x >> 16) % choices


@pytest.mark.parametrize("game", GOLDENS)
def test_a_thousand_noops(game: str) -> None:
    golden = GOLDENS[game]
    run = GoldenRun(game)
    assert run.core.ram().tobytes().hex() == golden["ram_after_load"]
    assert run.core.frame_number == golden["frame_number_after_load"]
    assert run.sums() == expected(golden["noop"]["0"], run.sums())
    for frame in range(1, 1001):
        run.act(0)
        if str(frame) in golden["noop"]:
            seen = run.state(bool(golden["stand_in"]))
            wanted = expected(golden["noop"][str(frame)], seen)
            assert {key: seen[key] for key in wanted} == wanted, f"after {frame} frames"


@pytest.mark.parametrize("game", GOLDENS)
def test_a_thousand_generated_actions(game: str) -> None:
    golden = GOLDENS[game]
    run = GoldenRun(game)
    actions = run.core.game.minimal_actions
    for index in generated_actions(1000, len(actions)):
        if run.core.game_over:
            run.core.reset()
        run.act(int(actions[index]))
    seen = run.state(bool(golden["stand_in"]))
    seen |= {"frame_number": run.core.frame_number, "episode_frame_number": run.core.episode_frame_number}
    wanted = expected(golden["random"], seen)
    assert {key: seen[key] for key in wanted} == wanted
