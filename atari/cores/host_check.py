"""The machine code that this machine runs, and a short check that it is exact: `atari verify --machine`.

`goldens.json` has check sums of ale-py 0.12.1 for ten games, a copy of a part of tests/conformance/goldens.json. The
ten use different cartridges, paddles and joysticks, and much of the video and sound chip.
"""

import json
import platform
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import atari._emulator as _emulator
from atari.cores.native import NativeCore

_ARRAYS = ("ram", "screen", "audio")


@dataclass(frozen=True)
class Machine:
    """The platform of this machine, and the fast paths that the native core uses on it."""

    platform: str
    python: str
    simd: str
    """The level of SIMD instructions: "scalar", "simd128", "avx2" or "avx512"."""
    translator: str | None
    """The processor for which games are translated to machine code, "x86-64" or "arm64"; None if the interpreter's
    handlers play them."""


def machine() -> Machine:
    """The machine that runs this process."""
    return Machine(
        platform=f"{platform.system()} {platform.machine()}",
        python=f"{platform.python_implementation()} {platform.python_version()}",
        simd=_emulator.simd_level(),
        translator=_emulator.translator(),
    )


def read_goldens() -> dict[str, dict[str, Any]]:
    """The golden values by game."""
    return json.loads(Path(__file__).with_name("goldens.json").read_text("utf-8"))


def differences(game: str, golden: dict[str, Any]) -> list[str]:
    """Play a thousand frames of a game, and name the values that differ from the golden ones."""
    core = NativeCore(game, seed=123, repeat_action_probability=0.0, sound=True)
    actions = core.game.minimal_actions
    reward, resets, chain = 0, 0, dict.fromkeys(_ARRAYS, 0)
    for choice in _choices(1000, len(actions)):
        if core.game_over:
            core.reset()
            resets += 1
        reward += core.act(int(actions[choice]))
        for name in _ARRAYS:
            chain[name] = zlib.crc32(getattr(core, name)().tobytes(), chain[name])
    seen = {
        **{name: f"{zlib.crc32(getattr(core, name)().tobytes()):08x}" for name in _ARRAYS},
        "lives": core.lives,
        "game_over": core.game_over,
        "reward": reward,
        "resets": resets,
        "frame_number": core.frame_number,
        "episode_frame_number": core.episode_frame_number,
        "chain": {name: f"{value:08x}" for name, value in chain.items()},
    }
    core.close()
    return [f"{name} is {seen[name]} and must be {value}" for name, value in golden.items() if seen[name] != value]


def _choices(count: int, choices: int) -> Iterator[int]:
    x = 1
    for _ in range(count):
        x = (1664525 * x + 1013904223) % 2**32
        yield (x >> 16) % choices
