"""A model of the TIA that renders pixel by pixel, at every access, as ale-py does.

The emulator defers rendering and draws spans with masks. This model renders at once: it checks for each object whether
it is lit at each column, and looks up the colour by the rules of priority. Every access has its time, in cycles of the
frame.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
from emulator.machines import TIA_FACTS, R, W

COPIES = [(0,), (0, 16), (0, 32), (0, 16, 32), (0, 64), (0,), (0, 32, 64), (0,)]
DELAYS = {W.VBLANK: 1, W.REFP0: 1, W.REFP1: 1, W.GRP0: 1, W.GRP1: 1, W.NUSIZ0: 8, W.NUSIZ1: 8, W.RESM0: 8, W.RESM1: 8}
OBJECTS = ("P0", "P1", "M0", "M1", "BL", "PF")
PAIRS = [(register, bit, OBJECTS.index(a), OBJECTS.index(b)) for register, bit, a, b in TIA_FACTS["collisions"]]


def player_lit(x: int, position: int, mode: int, graphics: int, skip_first: bool) -> bool:
    """Whether a player's pixel is on; `graphics` with its leftmost pixel in bit 7."""
    distance = (x - position) % 160
    if mode in (5, 7):
        width = 2 if mode == 5 else 4
        bit = 7 - (distance - 1) // width
        return not skip_first and 1 <= distance <= 8 * width and graphics >> bit & 1 == 1
    for offset in COPIES[mode]:
        if 0 <= distance - offset < 8 and not (offset == 0 and skip_first):
            return graphics >> (7 - (distance - offset)) & 1 == 1
    return False


def missile_lit(x: int, position: int, mode: int, size: int) -> bool:
    distance = (x - position) % 160
    return any(0 <= distance - offset < 1 << size for offset in COPIES[mode])


def ball_lit(x: int, position: int, size: int) -> bool:
    return (x - position) % 160 < 1 << size


def playfield_lit(x: int, playfield: int, mirror: bool) -> bool:
    bit: int = TIA_FACTS["playfield_bit_by_cell"]["mirror" if mirror else "repeat"][x // 4]
    return playfield >> bit & 1 == 1


def nothing_lit(x: int) -> bool:
    return False


def row(lit: Iterable[bool]) -> Any:
    return np.fromiter(lit, dtype=bool, count=160)


def reversed_bits(byte: int) -> int:
    return int(f"{byte:08b}"[::-1], 2)


class ModelTia:
    """The video part of the TIA, for NTSC. It renders one frame, which begins at cycle 0; line 0 is the first row."""

    def __init__(self, height: int) -> None:
        self.height = height
        self.framebuffer = np.zeros((height, 160), dtype=np.uint8)
        self.drawn = 0  # clock up to which it is drawn
        self.line_ends = 0  # lines whose end has been passed
        self.vblank = self.ctrlpf = self.playfield = self.collisions = 0
        self.nusiz, self.colour = [0, 0], [0, 0, 0, 0]
        self.grp, self.old_grp = [0, 0], [0, 0]
        self.refp, self.vdelp, self.enam, self.resmp = [False] * 2, [False] * 2, [False] * 2, [False] * 2
        self.enabl = self.old_enabl = self.vdelbl = False
        self.hm, self.pos = [0] * 5, [0] * 5
        self.skip_first = [False, False]
        self.m0_size_bit, self.m0_off = 0, False
        self.mirror = self.hmove_blank = self.cosmic_ark = False
        self.ark_counter = self.last_hmove = 0
        self.shapes: dict[tuple[Any, ...], Any] = {}

    # -- drawing

    def draw_to(self, clock: int) -> None:
        clock = min(clock, 228 * self.height)
        while self.drawn < clock:
            # The end of a line is passed only when drawing continues after it.
            if self.drawn == 228 * (self.line_ends + 1):
                self.end_line()
            line, offset = divmod(self.drawn, 228)
            step = min(clock, 228 * (line + 1)) - self.drawn
            self.span(line, offset, offset + step)
            self.drawn += step

    def end_line(self) -> None:
        self.line_ends += 1
        self.mirror = self.ctrlpf & 1 == 1
        self.skip_first = [False, False]
        if self.cosmic_ark:
            self.ark_counter = (self.ark_counter + 1) % 4
            self.pos[2] = (self.pos[2] - (18, 33, 0, 17)[self.ark_counter]) % 160
            self.m0_size_bit = 1 if self.ark_counter == 1 else 0
            self.m0_off = self.ark_counter == 2

    def graphics(self, player: int) -> int:
        byte = self.old_grp[player] if self.vdelp[player] else self.grp[player]
        return reversed_bits(byte) if self.refp[player] else byte

    def enabled(self) -> list[bool]:
        return [
            self.graphics(0) != 0, self.graphics(1) != 0,
            self.enam[0] and not self.resmp[0], self.enam[1] and not self.resmp[1],
            self.old_enabl if self.vdelbl else self.enabl, self.playfield != 0,
        ]  # fmt: skip

    def lit(self, number: int) -> Any:
        """One object's pixels in a line, whether or not it is enabled."""
        shape = self.shape(number)
        if shape not in self.shapes:
            function, *arguments = shape
            self.shapes[shape] = row(function(x, *arguments) for x in range(160))
        return self.shapes[shape]

    def shape(self, number: int) -> tuple[Any, ...]:
        """The function of an object's shape, and its arguments after the column."""
        if number < 2:
            mode = self.nusiz[number] & 7
            return player_lit, self.pos[number], mode, self.graphics(number), self.skip_first[number]
        if number < 4:
            nusiz = self.nusiz[number - 2]
            if number == 2 and self.m0_off:
                return (nothing_lit,)
            size = nusiz >> 4 & 3 | (self.m0_size_bit if number == 2 else 0)
            return missile_lit, self.pos[number], nusiz & 7, size
        if number == 4:
            return ball_lit, self.pos[4], self.ctrlpf >> 4 & 3
        return playfield_lit, self.playfield, self.mirror

    def span(self, line: int, start: int, stop: int) -> None:
        first, last = max(0, start - 68), stop - 68
        if last > first:
            self.pixels(line, first, last)
        if self.hmove_blank:
            self.framebuffer[line, first : max(first, min(8, last))] = 0
            if stop >= 76 > start:
                self.hmove_blank = False

    def pixels(self, line: int, first: int, last: int) -> None:
        if self.vblank & 2:
            self.framebuffer[line, first:last] = 0
            return
        enabled = self.enabled()
        off = np.zeros(160, dtype=bool)
        lit = [self.lit(number) if enabled[number] else off for number in range(6)]
        for register, bit, a, b in PAIRS:
            if (lit[a] & lit[b])[first:last].any():
                self.collisions |= 1 << (2 * register + bit - 6)
        p0, p1 = lit[0] | lit[2], lit[1] | lit[3]
        pf, ball = lit[5], lit[4]
        colour_p0, colour_p1, colour_pf, background = self.colour
        score, first_playfield = self.ctrlpf & 2 > 0, self.ctrlpf & 4 > 0
        for x in range(first, last):
            side = colour_p0 if x < 80 else colour_p1
            alone = not any(enabled[:5])
            if first_playfield:
                if pf[x]:
                    colour = side if score and alone else colour_pf
                elif ball[x]:
                    colour = colour_pf
                else:
                    colour = colour_p0 if p0[x] else colour_p1 if p1[x] else background
            elif p0[x]:
                colour = colour_p0
            elif pf[x] and score:
                colour = side
            elif p1[x]:
                colour = colour_p1
            else:
                colour = colour_pf if pf[x] or ball[x] else background
            self.framebuffer[line, x] = colour

    # -- accesses

    def read_collisions(self, cycle: int, register: int) -> int:
        """Bits 7 and 6 of a collision register."""
        self.draw_to(3 * cycle)
        return (self.collisions >> (2 * register) & 3) << 6

    def write(self, cycle: int, register: int, value: int) -> None:
        clock = 3 * cycle
        hpos = clock % 228
        delay = DELAYS.get(register, 0)
        if W.PF0 <= register <= W.PF2:
            delay = (4, 5, 2, 3)[cycle % 76 % 4]
        self.draw_to(clock + delay)
        second = register & 1  # of the pairs that begin at an even address
        if register == W.VBLANK:
            self.vblank = value
        elif register in (W.NUSIZ0, W.NUSIZ1):
            self.nusiz[second] = value
            self.skip_first[second] = False
            if second == 0:
                self.plain_missile()
        elif W.COLUP0 <= register <= W.COLUBK:
            self.colour[register - W.COLUP0] = value & 0xFE
        elif register == W.CTRLPF:
            self.ctrlpf = value
            if hpos < 147:
                self.mirror = value & 1 == 1
        elif register in (W.REFP0, W.REFP1):
            self.refp[register - W.REFP0] = value & 8 > 0
        elif register == W.PF0:
            self.playfield = self.playfield & 0xFFFF0 | value >> 4
        elif register == W.PF1:
            self.playfield = self.playfield & 0xFF00F | value << 4
        elif register == W.PF2:
            self.playfield = self.playfield & 0x00FFF | value << 12
        elif register in (W.RESP0, W.RESP1):
            self.strobe_player(second, clock, hpos)
        elif register in (W.RESM0, W.RESM1, W.RESBL):
            self.strobe_other(register, clock, hpos)
        elif register == W.GRP0:
            self.grp[0], self.old_grp[1] = value, self.grp[1]
        elif register == W.GRP1:
            self.grp[1], self.old_grp[0], self.old_enabl = value, self.grp[0], self.enabl
        elif register in (W.ENAM0, W.ENAM1):
            self.enam[register - W.ENAM0] = value & 2 > 0
        elif register == W.ENABL:
            self.enabl = value & 2 > 0
        elif W.HMP0 <= register <= W.HMBL:
            arming = register == W.HMM0 and clock == self.last_hmove + 63
            if arming and (self.hm[2], value >> 4) == (7, 6):
                self.cosmic_ark, self.ark_counter = True, 0
            self.hm[register - W.HMP0] = value >> 4
        elif register in (W.VDELP0, W.VDELP1):
            self.vdelp[register - W.VDELP0] = value & 1 > 0
        elif register == W.VDELBL:
            self.vdelbl = value & 1 > 0
        elif register in (W.RESMP0, W.RESMP1):
            if self.resmp[second] and not value & 2:
                middle = TIA_FACTS["resmp_offset_by_mode"][self.nusiz[second] & 7]
                self.pos[2 + second] = (self.pos[second] + middle) % 160
                if second == 0:
                    self.plain_missile()
            self.resmp[second] = value & 2 > 0
        elif register == W.HMOVE:
            self.hmove(clock, cycle % 76)
        elif register == W.HMCLR:
            self.hm = [0] * 5
        elif register == W.CXCLR:
            self.collisions = 0

    def plain_missile(self) -> None:
        self.m0_size_bit, self.m0_off = 0, False

    def hmove(self, clock: int, cycle: int) -> None:
        if cycle in TIA_FACTS["hmove_blank_cycles"]:
            self.hmove_blank = True
        delta = TIA_FACTS["hmove_delta_by_cycle_and_nibble"][cycle]
        self.pos = [(position + delta[nibble]) % 160 for position, nibble in zip(self.pos, self.hm, strict=True)]
        self.skip_first = [False, False]
        self.plain_missile()
        self.last_hmove = clock
        self.cosmic_ark = False

    def strobe_player(self, player: int, clock: int, hpos: int) -> None:
        position = 3 if hpos < 68 else (hpos - 68 + 5) % 160
        distance = (position - self.pos[player]) % 160
        mode = self.nusiz[player] & 7
        width = {5: 16, 7: 32}.get(mode, 8)
        about_to_start = any(0 <= distance - copy < 4 for copy in COPIES[mode])
        showing = any(4 <= distance - copy < 4 + width for copy in COPIES[mode])
        if showing and not about_to_start:
            self.draw_to(clock + 11)
        self.pos[player] = position
        self.skip_first[player] = not about_to_start

    def strobe_other(self, register: int, clock: int, hpos: int) -> None:
        position = 2 if hpos < 68 else (hpos - 68 + 4) % 160
        since = clock - self.last_hmove
        for case in TIA_FACTS["strobes_after_hmove"]:
            if (getattr(W, case["register"]), case["clocks_since_hmove"]) == (register, since) and hpos in case["hpos"]:
                position = case["position"]
        self.pos[register - W.RESM0 + 2] = position
        if register == W.RESM0:
            self.plain_missile()


COLLISION_REGISTERS = range(R.CXM0P, R.CXPPMM + 1)
