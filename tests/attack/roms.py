"""Random ROM images, by the fast core and by the reference core: RAM, screen and sound must be equal at every frame."""

import random
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from atari.cores import NativeCore, PlainCore

SIZES = (2048, 4096, 8192, 12288, 16384, 32768, 65536)
GAME = """
title = "Random"
players = 1
notes = []
[screen]
format = "{format}"
height = 210
first_line = 34
[controllers]
left = "{controller}"
right = "{controller}"
[actions]
minimal = ["NOOP", "FIRE"]
legal = "all"
starting = []
[settings]
modes = [0]
default_mode = 0
difficulties = [0]
[rules]
lives_initial = 3
state = {{score = 0}}
step = '''
reward   = ram[{reward:#x}] - score
score    = ram[{reward:#x}]
terminal = ram[{terminal:#x}] == {value}
lives    = ram[{lives:#x}]
'''
"""
OPCODES = bytes.fromhex(
    "a9 85 95 86 84 8d 9d a5 b5 ad bd e6 c6 4c 6c 20 60 d0 10 f0 48 08 28 68 9a ba 69 e9 0a 2a a2 a0 02"
)
"""Instructions that reach the chips, drawn more often than others."""


def image(source: random.Random) -> bytes:
    """An image of random bytes, in part of frequent instructions and TIA addresses, whose vectors lead into it."""
    size = source.choice(SIZES)
    content = bytearray(source.randbytes(size))
    if source.random() < 0.8:
        for place in range(0, size, 2):
            content[place] = source.choice(OPCODES)
            if source.random() < 0.6:
                content[place + 1] = source.randrange(0x40)
    for end in range(2048, size + 1, 2048):
        address = 0xF000 + source.randrange(0x1000)
        content[end - 4 : end] = address.to_bytes(2, "little") * 2
    return bytes(content)


def attack(seed: int) -> None:
    """Play one image on both cores, with resets and random bytes written to RAM."""
    source = random.Random(seed)
    with tempfile.TemporaryDirectory() as name:
        rom, game = Path(name, "random.bin"), Path(name, "random.toml")
        rom.write_bytes(image(source))
        facts: dict[str, Any] = {part: 0x80 + source.randrange(128) for part in ("reward", "terminal", "lives")}
        facts |= {"value": source.randrange(256), "format": source.choice(("NTSC", "PAL"))}
        game.write_text(GAME.format(**facts, controller=source.choice(("joystick", "paddles"))))
        options = {"seed": seed, "repeat_action_probability": source.choice((0.0, 0.25)), "sound": True}
        fast, plain = (core(str(game), rom=rom, **options) for core in (NativeCore, PlainCore))
    fast.reset(), plain.reset()
    for frame in range(source.choice((3, 30, 120))):
        if source.random() < 0.02:
            fast.reset(), plain.reset()
        if source.random() < 0.05:
            index, value = source.randrange(128), source.randrange(256)
            fast.set_ram(index, value), plain.set_ram(index, value)
        action = source.randrange(18)
        assert fast.act(action) == plain.act(action), f"rewards differ in frame {frame}"
        same("RAM", frame, fast.ram(), plain.ram())
        same("sound", frame, fast.audio(), plain.audio())
        if source.random() < 0.5:
            same("screen", frame, fast.screen(), plain.screen())
        after = [(core.lives, core.game_over, core.truncated, core.frame_number) for core in (fast, plain)]
        assert after[0] == after[1], f"lives, ends or counts differ in frame {frame}: {after}"
    assert fast.save() == plain.save(), "the final states differ"


def same(what: str, frame: int, fast: np.ndarray, plain: np.ndarray) -> None:
    """Raises AssertionError where the cores differ."""
    places = np.argwhere(fast != plain)
    assert not len(places), f"{what} differs in frame {frame} at {places[:4].tolist()}"
