"""The reset trace: a reset of the native core leaves out frames, and equals a reset of the plain core, also of programs
that run in TIA space, where they read the byte that the rules or ALE's layer left on the data bus.
"""

import random

import pytest
from emulator import wild_programs
from emulator.machines import emulator, game_of
from emulator.wild_programs import SIZES

import atari._emulator as _emulator
from atari.games.catalog import games
from atari.games.compiler import CompiledRules, compile_rules
from atari.games.rules import parse_rules


def rules_of(game: str) -> CompiledRules:
    rules = games[game].rules
    assert rules is not None
    return compile_rules(rules)


def both(image: bytes, cartridge: str, rules: CompiledRules) -> list[_emulator.Emulator]:
    """The native and the plain emulator of an image under some rules."""
    game = game_of(image, rules, cartridge)
    return [emulator(game, plain=plain) for plain in (False, True)]


def compare(pair: list[_emulator.Emulator], what: str, rng: random.Random) -> None:
    """Resets, after load and after a few frames."""
    for episode in range(3):
        for each in pair:
            each.reset()
        assert pair[0].save() == pair[1].save(), f"{what}, reset {episode}"
        for _ in range(3):
            action = rng.randrange(18)
            for each in pair:
                each.act(action)
        assert pair[0].save() == pair[1].save(), f"{what}, after reset {episode}"


@pytest.mark.parametrize("kind", list(SIZES))
def test_resets_of_random_roms(kind: str) -> None:
    rules = rules_of("boxing")
    for seed in range(4):
        for make in (wild_programs.soup, wild_programs.noise):
            rng = random.Random(seed)
            compare(both(make(rng, kind), kind, rules), f"{make.__name__} {kind} {seed}", rng)


FOUND = {
    "soup": (5, 26, 42, 51, 70, 80, 96, 105, 120, 142, 154, 165, 183, 190, 192, 216, 219, 234),
    "noise": (38, 90, 95, 135, 223, 244),
}


@pytest.mark.parametrize(("make", "seed"), [(make, seed) for make, seeds in FOUND.items() for seed in seeds])
def test_roms_that_have_found_an_error(make: str, seed: int) -> None:
    """They run in TIA space when a frame ends, or render rows after the last one of a screen."""
    rng = random.Random(seed)
    compare(both(getattr(wild_programs, make)(rng, "4K"), "4K", rules_of("boxing")), f"{make} {seed}", rng)


def test_the_rules_may_leave_another_byte_on_the_bus_in_each_episode() -> None:
    """A frame ends with the instruction at $FFFE, and the next one begins at $0000, in TIA space, with the opcode that is
    on the bus: CLC or SEC. After nine frames the rules read one or the other last, by a variable that resets keep.
    """
    begin = "78 D8 A2FF 9A A94C 8580 A900 8581 8592 85A0 A9F1 8582 A918 8590 A938 8591"  # JMP $F100 at $80
    frame = "E692 A902 8500 8502 8502 8502 A900 4CFEFF"  # VSYNC for three lines
    image = bytearray(bytes.fromhex(begin + frame).ljust(0xFFC, b"\xea") + b"\x00\xf0\x85\x00")
    again = (0xF000 + len(bytes.fromhex(begin))).to_bytes(2, "little")
    image[0x100:0x105] = b"\x26\xa0" + b"\x4c" + again  # ROL $A0, which keeps the opcodes of eight frames
    last = "ram[0x91] if frames & 64 and ram[0x92] > 8 else ram[0x90]"
    step = f"frames = frames + 1\nlast = {last}\nreward = last\nterminal = 0\nlives = 0"
    rules = parse_rules({"lives_initial": 0, "state": {"frames": 0}, "step": step, "kept_over_reset": ["frames"]})
    pair = both(bytes(image), "4K", compile_rules(rules))
    opcodes = set()
    for _ in range(4):
        for each in pair:
            each.reset()
        assert pair[0].save() == pair[1].save()
        opcodes.add(int(pair[0].ram()[0x20]) & 0x0F)
    assert opcodes == {0x00, 0x0F}
