"""The DPC chip of Pitfall II against a model: fetchers, random numbers, music."""

import random

import pytest
from atari_inspection import Console

AMPLITUDES = (0, 4, 5, 9, 6, 10, 11, 15)


class ModelDpc:
    """The chip, given the offset of each access in the 4 KiB window and the time in cycles."""

    def __init__(self, image: bytes) -> None:
        self.image, self.display = image, image[8192:10240]
        self.top, self.bottom, self.flag, self.counter = [0] * 8, [0] * 8, [0] * 8, [0] * 8
        self.music = [False] * 8
        self.random = 1
        self.reset()

    def reset(self) -> None:
        self.bank, self.looked_at, self.fraction = 1, 0, 0.0

    def clock_random(self) -> None:
        parity = sum(self.random >> bit & 1 for bit in (7, 5, 4, 3)) % 2
        self.random = 2 * self.random % 256 + 1 - parity

    def switch(self, offset: int) -> None:
        self.bank = {0xFF8: 0, 0xFF9: 1}.get(offset, self.bank)

    def read(self, offset: int, cycles: int) -> int:
        if 0x80 <= offset < 0xFC0:
            return self.image[4096 * self.bank + offset]
        self.clock_random()
        if offset >= 0x40:
            self.switch(offset)
            return self.image[4096 * self.bank + offset]
        function, i = divmod(offset, 8)
        low = self.counter[i] % 256
        if low == self.top[i]:
            self.flag[i] = 255
        elif low == self.bottom[i]:
            self.flag[i] = 0
        result = 0
        if function == 0 and i < 4:
            result = self.random
        elif function == 0:
            self.play(cycles)
            result = AMPLITUDES[sum(1 << k for k in range(3) if self.music[5 + k] and self.flag[5 + k])]
        elif function == 1:
            result = self.display[2047 - self.counter[i]]
        elif function == 2:
            result = self.display[2047 - self.counter[i]] & self.flag[i]
        elif function == 7:
            result = self.flag[i]
        if not (i >= 5 and self.music[i]):
            self.counter[i] = (self.counter[i] - 1) % 2048
        return result

    def write(self, offset: int, value: int) -> None:
        self.clock_random()
        self.switch(offset)
        if not 0x40 <= offset < 0x80:
            return
        function, i = divmod(offset - 0x40, 8)
        high, low = divmod(self.counter[i], 256)
        if function == 0:
            self.top[i], self.flag[i] = value, 0
        elif function == 1:
            self.bottom[i] = value
        elif function == 2:
            self.counter[i] = 256 * high + (self.top[i] if i >= 5 and self.music[i] else value)
        elif function == 3:
            self.counter[i] = 256 * (value % 8) + low
            if i >= 5:
                self.music[i] = value & 16 > 0
        elif function == 6:
            self.random = 1

    def play(self, cycles: int) -> None:
        pulses = (15750.0 * (cycles - self.looked_at)) / 1193191.66666667 + self.fraction
        self.looked_at = cycles
        whole = int(pulses)
        self.fraction = pulses - whole
        if whole <= 0:
            return
        for i in (5, 6, 7):
            if self.music[i]:
                high, low = divmod(self.counter[i], 256)
                low = 0 if self.top[i] == 0 else (low - whole % (self.top[i] + 1))
                if low < 0:
                    low += self.top[i] + 1
                if low <= self.bottom[i]:
                    self.flag[i] = 0
                elif low <= self.top[i]:
                    self.flag[i] = 255
                self.counter[i] = 256 * high + low


def same_state(machine: Console, model: ModelDpc) -> None:
    cart = machine.state()["cart"]
    for name in ("bank", "top", "bottom", "flag", "counter", "random", "fraction"):
        assert cart[name] == getattr(model, name), name
    assert [bool(on) for on in cart["music"]] == model.music


@pytest.mark.parametrize("seed", range(20))
def test_as_model(seed: int) -> None:
    """Random accesses with time passing, frames beginning and resets, which leave most registers."""
    rng = random.Random(seed)
    image = rng.randbytes(10495)
    machine, model = Console(image), ModelDpc(image)
    machine_time = model_time = 0  # of the two, since the last reset
    # A reset reads the vector, which clocks the random number.
    model.read(0xFFC, 0)
    model.read(0xFFD, 0)
    same_state(machine, model)
    for _ in range(600):
        step = rng.choice((3, 4, 70, 1500))
        machine_time += step
        model_time += step
        machine.cycles = machine_time
        offset = rng.choice(
            (rng.randrange(0x40), rng.randrange(0x40, 0x80), rng.randrange(0x40, 0x80), rng.randrange(0x1000))
        )
        if rng.random() < 0.1:
            offset = rng.choice((4, 5, 6, 7, 0xFF8, 0xFF9))
        address = 0xF000 + offset
        if rng.random() < 0.5:
            assert machine.read(address) == model.read(offset, model_time)
        else:
            value = rng.choice((0, 3, 16, 19, rng.randrange(256)))
            machine.write(address, value)
            model.write(offset, value)
        same_state(machine, model)
        if rng.random() < 0.02:
            machine.start_frame()
            machine_time = 0
        if rng.random() < 0.005:
            machine.reset()
            model.reset()
            model.read(0xFFC, 0)
            model.read(0xFFD, 0)
            machine_time = model_time = 0


def test_random_numbers() -> None:
    """The first ones, each by a read of the register; the seed is 1."""
    machine = Console(bytes(10495), "DPC")
    machine.write(0x1070, 0)  # start anew
    assert [machine.read(0x1000) for _ in range(8)] == [0x03, 0x07, 0x0F, 0x1E, 0x3D, 0x7A, 0xF4, 0xE8]


def test_random_numbers_repeat_after_255() -> None:
    machine = Console(bytes(10495), "DPC")
    seen = [machine.read(0x1000) for _ in range(255)]
    assert len(set(seen)) == 255
    assert 0xFF not in seen
    assert [machine.read(0x1001) for _ in range(255)] == seen


def test_fetcher_reads_display_data_backwards() -> None:
    image = random.Random(2).randbytes(10495)
    machine = Console(image, "DPC")
    machine.write(0x1050, 0x34)  # counter of fetcher 0: $234
    machine.write(0x1058, 0x02)
    first = 8192 + 2047 - 0x234
    assert bytes(machine.read(0x1008) for _ in range(100)) == image[first : first + 100]


@pytest.mark.parametrize("size", [10240, 10495, 10496])
def test_sizes(size: int) -> None:
    assert Console(bytes(size)).cartridge_type == "DPC"
