"""The fast core against the reference core, which is the oracle: the complete states are compared after every frame.

The fast core is the fast interpreter, translated code and the deferred TIA. Deferred rendering and deferred collisions
run only when they are read. So the test reads and compares framebuffers and latches at random frames, and framebuffers
also over many frames in a row. Between frames it resets the machines, overwrites their RAM, restores snapshots, and
loads the saved state of one core into the other.
"""

import platform
import random
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from atari_inspection import Console, same_state
from emulator import wild_programs
from emulator.programs import cpu_program, tia_program
from emulator.wild_programs import BLANKED_LOOKS, SIZES, STORES_BEFORE_TIA_SPACE

import atari
from atari.roms import find


class Cores:
    """Two fast consoles and a reference console with the same cartridge, which receive the same calls.

    The first fast console runs translated code, on platforms that have it; the second one handlers alone.
    """

    def __init__(self, image: bytes, cartridge: str, what: str, rng: random.Random, **options: Any) -> None:
        self.fast = [Console(image, cartridge, plain=False, translated=on, **options) for on in (True, False)]
        self.plain = Console(image, cartridge, plain=True, **options)
        self.all = (*self.fast, self.plain)
        self.what, self.rng, self.frames = what, rng, 0
        self.watching = False
        self.snapshots = [console.snapshot() for console in self.all]

    def play(
        self, frames: int, *, pokes: float = 0.03, resets: float = 0.01, looks: float = 0.15, travels: float = 0.08
    ) -> None:
        """Play frames; between them pokes, resets, reads and state changes happen with these probabilities."""
        for _ in range(frames):
            if self.rng.random() < pokes:
                self.poke()
            if self.rng.random() < resets:
                for console in self.all:
                    console.reset()
            if self.rng.random() < travels:
                self.travel()
            for console in self.all:
                console.run_frame()
            self.frames += 1
            self.watching ^= self.rng.random() < 0.08
            if self.watching or self.rng.random() < looks:
                self.compare_framebuffers()
            self.compare(self.rng.random() < looks)
            if self.rng.random() < 0.05:
                self.compare_arrays("sound", [console.make_samples() for console in self.all])

    def poke(self) -> None:
        ram = bytearray(self.plain.ram)
        ram[self.rng.randrange(128)] = self.rng.randrange(256)
        for console in self.all:
            console.ram = bytes(ram)

    def travel(self) -> None:
        """Load the state of one console into the other, or take a snapshot of both, or restore it."""
        choice = self.rng.random()
        if choice < 0.3:
            if self.rng.sample((True, False), 2)[0]:
                states = [fast.save() for fast in self.fast]
                self.plain.load(states[self.frames % 2])
            else:
                state = self.plain.save()
                for fast in self.fast:
                    fast.load(state)
        elif choice < 0.65:
            self.snapshots = [console.snapshot() for console in self.all]
        else:
            for console, snapshot in zip(self.all, self.snapshots, strict=True):
                console.restore(snapshot)
            self.compare(self.rng.random() < 0.5)

    def compare_framebuffers(self) -> None:
        self.compare_arrays("framebuffer", [console.framebuffer() for console in self.all])

    def compare_arrays(self, name: str, arrays: list[Any]) -> None:
        for core, array in zip(("translated", "handlers"), arrays, strict=False):
            assert np.array_equal(array, arrays[-1]), f"{self.what}, {core}, frame {self.frames}: {name}"

    def compare(self, complete: bool) -> None:
        for core, fast in zip(("translated", "handlers"), self.fast, strict=True):
            if not same_state(fast, self.plain, complete):
                differing = "; ".join(differences(seen(fast), seen(self.plain)))
                pytest.fail(f"{self.what}, {core}, frame {self.frames}: {differing} (fast, plain)")


def seen(console: Console) -> dict[str, Any]:
    """The complete state of a console by name; reading the framebuffer renders it."""
    framebuffer = console.framebuffer()
    return {
        **{name: list(part) for name, part in (("ram", console.ram), ("cartridge_ram", console.cartridge_ram))},
        "registers": console.registers,
        **console.state(),
        "framebuffer": [list(row) for row in framebuffer],
    }


def differences(first: Any, second: Any, name: str = "") -> Iterator[str]:
    """The first differing number of each part, by its path."""
    if isinstance(first, dict):
        for key in first:
            yield from differences(first[key], second[key], f"{name}.{key}".strip("."))
    elif isinstance(first, list) and first != second:
        index = next(index for index, pair in enumerate(zip(first, second, strict=True)) if pair[0] != pair[1])
        yield from differences(first[index], second[index], f"{name}[{index}]")
    elif first != second:
        yield f"{name} {first} and {second}"


def press(cores: Cores, player: bool) -> None:
    """Set the inputs of the next frames: with `player` as in a game, otherwise any."""
    rng = cores.rng
    start = 0x3E if rng.random() < 0.05 else 0x3F
    inputs: dict[str, Any] = {
        "switches": start if player else rng.randrange(256),
        "sticks": [rng.choice((0, 0, 1, 2, 4, 8, 5, 10)), rng.choice((0, 1, 2, 4, 8))],
        "fire": [rng.random() < 0.4, rng.random() < 0.2],
        "resistances": [rng.randrange(800_000) for _ in range(4)],
        "paddle_fire": [rng.random() < 0.4, rng.random() < 0.2, False, False],
    }
    for console in cores.all:
        console.set_inputs(**inputs)


@pytest.mark.parametrize("game", list(atari.games))
def test_games(game: str) -> None:
    """The cartridge of every game: a game is started and played."""
    facts = atari.games[game]
    cores = Cores(
        find(game).read_bytes(),
        facts.rom.cartridge,
        game,
        random.Random(game),
        first_line=facts.screen.first_line,
        height=facts.screen.height,
        pal=facts.screen.format == "PAL",
        hmove_blanks=facts.screen.hmove_blanks,
        paddles=(facts.controllers.left == "paddles", facts.controllers.right == "paddles"),
        swap_ports=facts.controllers.swap_ports,
        swap_paddles=facts.controllers.swap_paddles,
    )
    cores.play(40, pokes=0, resets=0)
    for _ in range(45):
        press(cores, player=True)
        cores.play(6, pokes=0.005, resets=0.001)


@pytest.mark.parametrize("translated", [True, False])
def test_what_runs(translated: bool) -> None:
    """Translated code runs if it is enabled and this processor is supported."""
    console = Console(wild_programs.noise(random.Random(0), "4K"), "4K", plain=False, translated=translated)
    known = platform.machine() in ("x86_64", "AMD64") or (platform.machine() == "aarch64" and sys.platform == "linux")
    assert console.translated == (translated and known)


def options(rng: random.Random) -> dict[str, Any]:
    """Random options of a console."""
    first = rng.choice((0, 0, 20, 34, 34, 34, 60))
    return {
        "first_line": first,
        "height": rng.choice((1, 8, 210, 210, 240, 300 - first)),
        "pal": rng.random() < 0.2,
        "hmove_blanks": rng.random() < 0.8,
        "paddles": (rng.random() < 0.5, rng.random() < 0.5),
        "swap_ports": rng.random() < 0.3,
        "swap_paddles": rng.random() < 0.3,
    }


def play(image: bytes, cartridge: str, what: str, rng: random.Random, rounds: int = 4, **chances: float) -> None:
    cores = Cores(image, cartridge, what, rng, **options(rng))
    for _ in range(rounds):
        press(cores, player=False)
        cores.play(5, **chances)


@pytest.mark.parametrize("kind", list(SIZES))
def test_roms_of_noise(kind: str) -> None:
    for seed in range(20):
        play(
            wild_programs.noise(random.Random(seed), kind),
            kind,
            f"noise {kind} {seed}",
            random.Random(seed),
            resets=0.2,
        )


@pytest.mark.parametrize("kind", list(SIZES))
def test_wild_instructions(kind: str) -> None:
    for seed in range(20):
        play(
            wild_programs.soup(random.Random(seed), kind), kind, f"soup {kind} {seed}", random.Random(seed), resets=0.1
        )


@pytest.mark.parametrize("batch", range(10))
def test_frames_that_change(batch: int) -> None:
    for seed in range(20 * batch, 20 * batch + 20):
        rng = random.Random(seed)
        play(wild_programs.changing_frames(rng), "4K", f"changing_frames {seed}", rng, rounds=6, travels=0.3)


@pytest.mark.parametrize(
    ("make", "seed"),
    [
        *(
            (wild_programs.changing_frames, seed)
            for seed in (10428, 10455, 10624, 21467, 24821, 100632, 103428, 203054, 1003155, 1107834)
        ),
        *((tia_program, seed) for seed in (10160, 10297, 12217, 100136, 100785, 100928, 703281)),
    ],
)
def test_programs_that_have_found_an_error(make: Any, seed: int) -> None:
    """Rare programs that found errors: late reflect, strobes and blanks at the end of a line, repeated frames."""
    rng = random.Random(seed)
    more = {"rounds": 6, "travels": 0.3} if make is wild_programs.changing_frames else {}
    play(make(rng), "4K", f"{make.__name__} {seed}", rng, **more)


@pytest.mark.parametrize("batch", range(6))
def test_frames_that_change_little(batch: int) -> None:
    """The renderer skips lines that equal those in the framebuffer. State that does not show may differ."""
    for seed in range(40 * batch, 40 * batch + 40):
        rng = random.Random(seed)
        image = wild_programs.nearly_still(rng)
        play(image, "4K", f"nearly_still {seed}", rng, rounds=16, pokes=0.8, resets=0, looks=0.8, travels=0.01)


@pytest.mark.parametrize("batch", range(4))
def test_collisions_that_are_read_now_and_then(batch: int) -> None:
    """The fast core reuses the collisions of a line that is the same as in the frame before, if it computed them then."""
    rare = (1943, 7160, 7542, 7575) if batch == 0 else ()  # the frame reads other latches than the frame before
    for seed in (*range(40 * batch, 40 * batch + 40), *rare):
        rng = random.Random(seed)
        play(wild_programs.glances(rng), "4K", f"glances {seed}", rng, rounds=8, pokes=0.1, resets=0, travels=0.03)


@pytest.mark.parametrize("batch", range(4))
def test_stars_in_motion(batch: int) -> None:
    for seed in range(15 * batch, 15 * batch + 15):
        rng = random.Random(seed)
        play(wild_programs.starfield(rng), "4K", f"starfield {seed}", rng, pokes=0, resets=0)


@pytest.mark.parametrize("batch", range(4))
def test_short_frames(batch: int) -> None:
    for seed in range(100 * batch, 100 * batch + 100):
        rng = random.Random(seed)
        play(wild_programs.short_frames(rng), "4K", f"short_frames {seed}", rng, looks=0.4)


@pytest.mark.parametrize("look", BLANKED_LOOKS, ids=bytes.hex)
@pytest.mark.parametrize("wait", [0, 9, 25])
@pytest.mark.parametrize("looks", [0, 0.5, 1])
def test_frames_that_end_in_a_blanked_line(look: bytes, wait: int, looks: float) -> None:
    """How far the black of HMOVE's blank reaches there depends on the first access for which the TIA renders."""
    cores = Cores(wild_programs.blank_ends(look, wait), "4K", look.hex(), random.Random(0), first_line=34, height=210)
    for _ in range(4):
        cores.play(5, pokes=0, resets=0, looks=looks, travels=0)
        cores.compare_framebuffers()


@pytest.mark.parametrize("batch", range(4))
def test_latches_read_in_blanked_lines(batch: int) -> None:
    for seed in range(100 * batch, 100 * batch + 100):
        rng = random.Random(seed)
        play(wild_programs.glances_at_blanks(rng), "4K", f"glances_at_blanks {seed}", rng, rounds=6, looks=0.3)


@pytest.mark.parametrize("end", STORES_BEFORE_TIA_SPACE, ids=bytes.hex)
@pytest.mark.parametrize("kind", ["4K", "FE"])
def test_latches_fetched_as_code_right_after_a_store(end: bytes, kind: str) -> None:
    """The last write may show later than the fetch, which then sees the collisions up to there."""
    cores = Cores(wild_programs.runs_into_tia_space(end, kind), kind, end.hex(), random.Random(0))
    cores.play(40, pokes=0, resets=0, travels=0)


@pytest.mark.parametrize("batch", range(4))
def test_waiting_and_counting(batch: int) -> None:
    for seed in range(50 * batch, 50 * batch + 50):
        rng = random.Random(seed)
        play(wild_programs.waiting(rng), "4K", f"waiting {seed}", rng)


@pytest.mark.parametrize("batch", range(4))
def test_straight_lines_that_are_entered_anywhere(batch: int) -> None:
    for seed in range(50 * batch, 50 * batch + 50):
        rng = random.Random(seed)
        play(wild_programs.entered_anywhere(rng), "4K", f"entered_anywhere {seed}", rng)


@pytest.mark.parametrize("after", [0, 900, 960, 970, 1000, 1500])
def test_the_limit_within_a_straight_line(after: int) -> None:
    """The limit of 25,000 instructions is reached among two-cycle instructions without a jump, before a TIA write."""
    round_ = [0xEA] * 2000 + [0xCA, 0xF0, 0x03, 0x4C, 0x02, 0xF0]  # DEX; BEQ past the jump to the beginning; JMP
    program = [0xA2, 12, *round_, *([0xEA] * after), 0x85, 0x09, 0x4C, 0x00, 0xF0]  # LDX #12; ...; STA COLUBK; JMP
    image = bytes(program).ljust(0xFFC, b"\xea") + bytes([0x00, 0xF0, 0x00, 0xF0])
    cores = Cores(image, "4K", f"{after} instructions after the loop", random.Random(0))
    cores.play(20, pokes=0, resets=0, travels=0)


def test_the_deadline_check_of_the_first_instruction() -> None:
    """The first TIA write after the line limit ends a frame. Here it is the image's first instruction."""
    wait = [0xA0, 25, 0xA2, 0, 0xCA, 0xD0, 0xFD, 0x88, 0xD0, 0xF8]  # 25 times 256 rounds: more than 342 lines
    writes = [0x85, 0x09, 0x69, 0x02, 0xE6, 0x80, 0x85, 0x08]  # STA COLUBK; ADC #2; INC; STA COLUPF
    program = [*writes, *wait, 0x4C, 0x00, 0xF0]  # JMP to the beginning
    image = bytes(program).ljust(0xFFC, b"\xea") + bytes([0x00, 0xF0, 0x00, 0xF0])
    Cores(image, "4K", "a late write at the first byte", random.Random(0)).play(20)


@pytest.mark.parametrize("batch", range(4))
@pytest.mark.parametrize("make", [tia_program, cpu_program])
def test_programs_that_are_compared_with_ale_py(make: Any, batch: int) -> None:
    for seed in range(15 * batch, 15 * batch + 15):
        rng = random.Random(seed)
        play(make(rng), "4K", f"{make.__name__} {seed}", rng)


@pytest.mark.parametrize("game", ["seaquest", "freeway", "enduro", "galaxian"])
def test_unread_collision_latches_are_restored(game: str) -> None:
    """A restore computes the latches from the write log of a frame that has already been rendered."""
    cores = Cores(find(game).read_bytes(), "", game, random.Random(game))
    cores.play(20, pokes=0, resets=0)
    for _ in range(60):
        press(cores, player=True)
        cores.play(3, pokes=0, resets=0, looks=0)
        cores.compare_framebuffers()
        snapshots = [console.snapshot() for console in cores.all]
        for console in cores.all:
            for _ in range(4):
                console.run_frame()
        for console, snapshot in zip(cores.all, snapshots, strict=True):
            console.restore(snapshot)
        cores.compare(complete=True)
