"""The sound generator: every mode against tables of the shift registers' next states, in steps of 512 samples."""

import random

import numpy as np
import pytest
from atari_inspection import Console
from emulator.machines import TIA_FACTS, W, console

FACTS = TIA_FACTS["sound"]
NEXT4 = {
    "poly4": FACTS["poly4_next"],
    "ones": FACTS["ones_next"],
    "div2": FACTS["div2_next"],
    "div6": FACTS["div6_next"],
}
POLY5 = FACTS["poly5_next"]
CYCLE9 = FACTS["poly9_cycle_from_p4_1_p5_1_as_p4_times_32_plus_p5"]
POLY9 = dict(zip([CYCLE9[-1], *CYCLE9], CYCLE9, strict=False)) | {0: 1}

DIRECT = {0: "ones", 1: "poly4", 4: "div2", 5: "div2", 11: "ones", 12: "div6", 13: "div6"}
AT_31 = {2: "poly4", 6: "div2", 10: "shift", 14: "div6"}  # clocked twice in the 31 states of the five-bit register
WHILE_HIGH = {3: "poly4", 7: "div2", 15: "div6"}  # clocked while its highest bit is set


class Channel:
    """One channel: a divider, a four-bit and a five-bit register."""

    def __init__(self) -> None:
        self.mode = self.frequency = self.volume = self.counter = 0
        self.p4 = self.p5 = 1

    def sample(self) -> int:
        self.counter += 1
        if self.counter > self.frequency:
            self.counter = 0
            self.clock()
        return 4 * self.volume if self.p4 >= 8 else 0

    def clock(self) -> None:
        if self.mode in DIRECT:
            self.p4 = NEXT4[DIRECT[self.mode]][self.p4]
        elif self.mode == 8:
            self.p4, self.p5 = divmod(POLY9[32 * self.p4 + self.p5], 32)
        elif self.mode == 9:
            self.p4 = 2 * self.p4 % 16 + self.p5 // 16
            self.p5 = POLY5[self.p5]
        else:
            self.p5 = POLY5[self.p5]
            if self.mode in WHILE_HIGH and self.p5 >= 16:
                self.p4 = NEXT4[WHILE_HIGH[self.mode]][self.p4]
            elif self.mode in AT_31 and self.p5 in (8, 24):
                how = AT_31[self.mode]
                self.p4 = 2 * self.p4 % 16 + self.p5 // 16 if how == "shift" else NEXT4[how][self.p4]


def write_channel(machine: Console, channel: int, mode: int, frequency: int, volume: int, high_bits: int = 0) -> None:
    machine.write(W.AUDC0 + channel, mode | high_bits & 0xF0)
    machine.write(W.AUDF0 + channel, frequency | high_bits & 0xE0)
    machine.write(W.AUDV0 + channel, volume | high_bits & 0xF0)


def test_the_tables_are_of_all_states() -> None:
    assert len(POLY9) == 512
    assert set(POLY9.values()) == set(range(1, 512))
    assert [len(table) for table in (*NEXT4.values(), POLY5)] == [16] * 4 + [32]


@pytest.mark.parametrize("mode", range(16))
def test_mode(mode: int) -> None:
    """Both channels, several frequencies in a row; the shift registers continue from batch to batch."""
    machine, models = console(), [Channel(), Channel()]
    for frequency, volume in ((0, 15), (1, 8), (2, 3), (31, 15), (0, 1), (5, 0), (0, 12)):
        for number, model in enumerate(models):
            model.mode, model.frequency, model.volume = mode, (frequency + number) % 32, volume
            write_channel(machine, number, mode, model.frequency, model.volume)
        expected = [128 + models[0].sample() + models[1].sample() for _ in range(512)]
        np.testing.assert_array_equal(machine.make_samples(), expected)


def test_changing_modes() -> None:
    """Random registers: each mode starts from the state that another mode has left."""
    rng = random.Random(5)
    machine, models = console(), [Channel(), Channel()]
    for _ in range(200):
        for number, model in enumerate(models):
            model.mode, model.frequency, model.volume = (
                rng.randrange(16),
                rng.choice((0, 0, 1, 3, 31)),
                rng.randrange(16),
            )
            write_channel(machine, number, model.mode, model.frequency, model.volume, rng.randrange(256))
        expected = [128 + models[0].sample() + models[1].sample() for _ in range(512)]
        np.testing.assert_array_equal(machine.make_samples(), expected)


def period(samples: np.ndarray) -> int:
    """The smallest distance at which a sequence repeats itself."""
    return next(n for n in range(1, len(samples)) if (samples[n:] == samples[:-n]).all())


@pytest.mark.parametrize(
    ("mode", "expected"), [(0, 1), (1, 15), (3, 465), (4, 2), (6, 31), (8, 511), (9, 31), (10, 31), (12, 6), (14, 93)]
)
def test_periods(mode: int, expected: int) -> None:
    """The lengths of the sequences, as documented in books on the 2600."""
    machine = console()
    write_channel(machine, 0, mode, 0, 15)
    machine.make_samples()
    samples = np.concatenate([machine.make_samples() for _ in range(4)])
    assert period(samples) == expected


@pytest.mark.parametrize("frequency", [0, 1, 7, 31])
def test_divider(frequency: int) -> None:
    machine = console()
    write_channel(machine, 1, 4, frequency, 9)
    samples = np.concatenate([machine.make_samples() for _ in range(2)])
    edges = np.flatnonzero(np.diff(samples.astype(int)))
    assert set(np.diff(edges)) == {frequency + 1}
    assert set(samples) == {128, 128 + 36}


def test_silence_and_loudness() -> None:
    machine = console()
    assert set(machine.make_samples()) == {128}
    for channel in (0, 1):
        write_channel(machine, channel, 0, 0, 15)
    assert machine.make_samples()[-1] == 128 + 60 + 60


def test_resets_and_frames_leave_the_sound_alone() -> None:
    """The generator never restarts. Only the values of the registers at the time of sampling count."""
    machine, undisturbed = console(), console()
    for either in (machine, undisturbed):
        write_channel(either, 0, 8, 2, 15)
        either.make_samples()
    machine.reset()
    machine.write(W.AUDC0, 4)
    machine.start_frame()
    machine.write(W.AUDC0, 8)
    np.testing.assert_array_equal(machine.make_samples(), undisturbed.make_samples())
