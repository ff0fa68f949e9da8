"""Bank switching: the nineteen cartridge types, their hotspots, and their RAM."""

import random
from collections.abc import Callable

import pytest
from atari_inspection import Console
from emulator.machines import MACHINE_FACTS, R, W


def image_of(size: int, seed: int = 1) -> bytes:
    return random.Random(seed).randbytes(size)


def mirrors(offset: int) -> list[int]:
    """The addresses at which a cartridge's window begins, plus an offset."""
    return [base + offset for base in range(0x1000, 0x10000, 0x2000)]


def window(machine: Console, offsets: range = range(0x100, 0xF00, 0x55), base: int = 0x1000) -> bytes:
    """Some bytes of the window, read where reads switch nothing."""
    return bytes(machine.read(base + offset) for offset in offsets)


def bank_bytes(image: bytes, bank: int, offsets: range = range(0x100, 0xF00, 0x55)) -> bytes:
    return bytes(image[4096 * bank + offset] for offset in offsets)


# -- types with banks of 4 KiB: size, bank after a reset, first hotspot

BANKED = {
    "F8": (8192, 1, 0xFF8),
    "F8 SWAPPED": (8192, 0, 0xFF8),
    "F6": (16384, 0, 0xFF6),
    "F4": (32768, 0, 0xFF4),
    "F8SC": (8192, 1, 0xFF8),
    "F6SC": (16384, 0, 0xFF6),
    "F4SC": (32768, 0, 0xFF4),
    "FASC": (12288, 2, 0xFF8),
}
SKIPPED = range(0x200, 0xF00, 0x55)  # after the RAM of the types that have RAM


@pytest.mark.parametrize("cartridge", BANKED)
def test_banks(cartridge: str) -> None:
    """Reset bank; every hotspot by reads, in all mirrors, returning the new bank's byte; no switching elsewhere."""
    size, reset_bank, first = BANKED[cartridge]
    count = size // 4096
    image = image_of(size)
    machine = Console(image, cartridge)
    assert window(machine, SKIPPED) == bank_bytes(image, reset_bank, SKIPPED)
    for mirror in mirrors(0):
        for bank in [*range(count), *reversed(range(count))]:
            assert machine.read(mirror + first + bank) == image[4096 * bank + first + bank]
            assert machine.state()["cart"]["bank"] == bank
            assert window(machine, SKIPPED, mirror) == bank_bytes(image, bank, SKIPPED)
    for bank in range(count):
        machine.read(0x1000 + first + bank)
        for offset in set(range(0x1000)) - set(range(first, first + count)):
            machine.read(0x1000 + offset)
            machine.write(0x1000 + offset, bank ^ 1)
        machine.read(first + bank)  # no A12: not the cartridge
        assert machine.state()["cart"]["bank"] == bank
    machine.reset()
    assert machine.state()["cart"]["bank"] == reset_bank


@pytest.mark.parametrize("cartridge", BANKED)
def test_banks_by_writes(cartridge: str) -> None:
    """A write of any value switches; F4SC alone, as in ale-py, ignores writes."""
    size, reset_bank, first = BANKED[cartridge]
    machine = Console(image_of(size), cartridge)
    for bank in range(size // 4096):
        machine.write(0xF000 + first + bank, 0xFF - bank)
        assert machine.state()["cart"]["bank"] == (reset_bank if cartridge == "F4SC" else bank)


def test_rom_cannot_be_written() -> None:
    for cartridge, size in (("2K", 2048), ("4K", 4096), ("F8", 8192), ("FE", 8192), ("E0", 8192), ("MB", 65536)):
        image = image_of(size)
        machine = Console(image, cartridge)
        before = window(machine)
        for offset in range(0xFE0):
            machine.write(0x1000 + offset, 0x5A)
        assert window(machine) == before


def test_2k_appears_twice() -> None:
    image = image_of(2048)
    machine = Console(image)
    for mirror in mirrors(0):
        assert bytes(machine.read(mirror + offset) for offset in range(4096)) == image * 2


def test_4k() -> None:
    image = image_of(4096)
    machine = Console(image)
    for mirror in mirrors(0):
        assert bytes(machine.read(mirror + offset) for offset in range(4096)) == image


def test_bytes_beyond_the_type_are_ignored() -> None:
    image = image_of(5000)
    assert window(Console(image, "2K"), range(0, 2048, 7)) == image[:2048:7]
    assert window(Console(image, "4K"), range(0, 4096, 7)) == image[:4096:7]


# -- RAM

PORTS = {
    "F8SC": (0x000, 0x080, 128),
    "F6SC": (0x000, 0x080, 128),
    "F4SC": (0x000, 0x080, 128),
    "FASC": (0x000, 0x100, 256),
}


@pytest.mark.parametrize("cartridge", PORTS)
def test_ram_ports(cartridge: str) -> None:
    """RAM has a write port and a read port. A read of the write port returns ROM and keeps RAM. Banks share RAM."""
    write_port, read_port, size = PORTS[cartridge]
    length, bank, first = BANKED[cartridge]
    image = image_of(length)
    machine = Console(image, cartridge)
    for offset in range(size):
        machine.write(0xF000 + write_port + offset, offset ^ 0x33)
    expected = bytes(offset ^ 0x33 for offset in range(size))
    assert machine.cartridge_ram == expected
    for mirror in mirrors(0):
        assert bytes(machine.read(mirror + read_port + offset) for offset in range(size)) == expected
        assert (
            bytes(machine.read(mirror + write_port + offset) for offset in range(size)) == image[4096 * bank :][:size]
        )
    for offset in range(size):
        machine.write(0xF000 + read_port + offset, 0xEE)
    machine.read(0x1000 + first)  # to bank 0
    assert bytes(machine.read(0x1000 + read_port + offset) for offset in range(size)) == expected
    assert machine.cartridge_ram == expected
    assert bytes(machine.read(0x1000 + offset) for offset in range(size)) == image[:size]


@pytest.mark.parametrize(
    ("cartridge", "size", "ram"),
    [("F8SC", 8192, 128), ("F6SC", 16384, 128), ("F4SC", 32768, 128), ("FASC", 12288, 256), ("E7", 16384, 2048),
     ("3E", 8192, 32768), ("CV", 2048, 1024)],
)  # fmt: skip
def test_ram_is_random_at_every_reset(cartridge: str, size: int, ram: int) -> None:
    machine = Console(image_of(size), cartridge)
    first = machine.cartridge_ram
    assert len(first) == ram
    assert list(first[:10]) == [word & 0xFF for word in MACHINE_FACTS["words_128_to_139"][2:]]
    machine.reset()
    assert machine.cartridge_ram != first
    assert machine.state()["random_words"] == 129 + 2 * (1 + ram)


@pytest.mark.parametrize("cartridge", ["2K", "4K", "F8", "F6", "F4", "E0", "FE", "DPC", "3F", "UA", "MB"])
def test_the_others_draw_no_random_bytes(cartridge: str) -> None:
    machine = Console(image_of(65536), cartridge)
    assert machine.cartridge_ram == b""
    assert machine.state()["random_words"] == 130


# -- slices


def test_e0() -> None:
    """Three segments of 1 KiB choose among eight slices; the fourth, with the hotspots, is always the last."""
    image = image_of(8192)
    machine = Console(image, "E0")
    slices = [4, 5, 6, 7]

    def check() -> None:
        assert machine.state()["cart"]["slice"] == slices
        for segment, number in enumerate(slices):
            for offset in (0x000, 0x155, 0x3DF):
                assert machine.read(0xF000 + 0x400 * segment + offset) == image[1024 * number + offset]

    check()
    rng = random.Random(3)
    for access in rng.sample([*range(0xFE0, 0x1000)] * 3, 96):
        if access < 0xFF8:
            slices[access - 0xFE0 >> 3] = access & 7
        if rng.random() < 0.5:
            assert machine.read(rng.choice(mirrors(access))) == image[7 * 1024 + (access & 0x3FF)]
        else:
            machine.write(rng.choice(mirrors(access)), rng.randrange(256))
        check()
    machine.reset()
    slices = [4, 5, 6, 7]
    check()


def test_e7() -> None:
    image = image_of(16384)
    machine = Console(image, "E7")
    for access in (Console.read, lambda machine, address: machine.write(address, 0)):
        for number in range(7):
            access(machine, 0x1FE0 + number)
            assert window(machine, range(0, 0x800, 17)) == image[2048 * number :][:0x800:17]
            assert window(machine, range(0xA00, 0xFE0, 17)) == image[14336 + 0x200 : 14336 + 0x7E0 : 17]
    # Slice 7 is RAM of 1 KiB, written in its first half and read in its second.
    assert machine.read(0x1FE7) == image[14336 + 0x7E7]
    pages = machine.cartridge_ram[0x400:]
    for offset in range(0x400):
        machine.write(0x1000 + offset, offset & 0xFF ^ offset >> 8)
        machine.write(0x1400 + offset, 0xEE)
    low = bytes(offset & 0xFF ^ offset >> 8 for offset in range(0x400))
    assert machine.cartridge_ram[0x400:] == pages
    assert bytes(machine.read(0x1400 + offset) for offset in range(0x400)) == low
    assert bytes(machine.read(0x1000 + offset) for offset in range(0x400)) == image[14336 : 14336 + 0x400]
    # Four pages of 256 bytes, written at $800 and read at $900.
    for page in range(4):
        machine.read(0x1FE8 + page)
        for offset in range(0x100):
            machine.write(0x1800 + offset, page * 50 + offset & 0xFF)
            machine.write(0x1900 + offset, 0xEE)
    for page in reversed(range(4)):
        machine.write(0x1FE8 + page, 0)
        expected = bytes(page * 50 + offset & 0xFF for offset in range(0x100))
        assert bytes(machine.read(0x1900 + offset) for offset in range(0x100)) == expected
        assert machine.cartridge_ram[1024 + 256 * page :][:256] == expected
    assert bytes(machine.read(0x1800 + offset) for offset in range(0x100)) == image[14336 : 14336 + 0x100]
    assert machine.cartridge_ram[:0x400] == low
    machine.read(0x1FE2)
    machine.write(0x1000, 0x99)  # slice 2 is ROM
    assert machine.cartridge_ram[:0x400] == low
    machine.reset()
    assert machine.state()["cart"]["slice"][:2] == [0, 0]


def test_fe_looks_at_bit_13() -> None:
    image = image_of(8192)
    machine = Console(image, "FE")
    for base in mirrors(0):
        half = image[:4096] if base & 0x2000 else image[4096:]
        assert bytes(machine.read(base + offset) for offset in range(4096)) == half
    assert machine.read(0xF123) == image[0x123]
    assert machine.read(0xD123) == image[0x1123]


@pytest.mark.parametrize("slices", [1, 2, 4, 7, 256])
def test_3f(slices: int) -> None:
    """A write of $00-$3F chooses the lower slice and also reaches the TIA."""
    image = image_of(2048 * slices)
    machine = Console(image, "3F")
    upper = image[-2048:]

    def shown() -> int:
        assert window(machine, range(0x800, 0x1000, 31)) == upper[::31]
        return int(machine.state()["cart"]["bank"])

    assert shown() == 0
    for value in (0, 1, slices - 1, 2 * slices - 1 & 0xFF, 255):
        for address in (W.COLUBK, 0x2000 + W.COLUBK, 0x1000 + W.COLUBK, 0xF000 + W.COLUBK):
            machine.write(0x3F, 0)
            machine.write(address, value)
            assert shown() == value % slices
            assert window(machine, range(0, 0x800, 31)) == image[2048 * (value % slices) :][:2048:31]
            assert machine.state()["tia"]["colour"][3] == value & 0xFE
    machine.write(0x3F, 1)
    chosen = shown()
    for address in (0x40, 0x0100 + W.COLUBK, 0x1040, 0xFFFF - 0x40, 0x80):
        machine.write(address, 0x77)
        assert shown() == chosen
    # Reads of $00-$3F give the cartridge's bytes, mirrors the TIA's.
    for address in range(0x40):
        assert machine.read(address) == machine.read(0x2000 + address) == image[2048 * chosen + address]
    machine.write(0x80, 0)
    assert machine.read(0x40 + R.INPT4) == 0x80
    machine.reset()
    assert shown() == 0


def test_3f_gives_writes_of_rom_to_the_tia() -> None:
    machine = Console(image_of(8192), "3F")
    machine.write(0x1000 + 0x740 + W.COLUP0, 0x46)
    assert machine.state()["tia"]["colour"][0] == 0x46


def test_3e() -> None:
    """$3F chooses ROM, $3E one of 32 pages of RAM: read at $000, written and read at $400."""
    image = image_of(8192)
    machine = Console(image, "3E")
    slices = [image[start : start + 2048 : 31] for start in range(0, 8192, 2048)]
    for value in (0, 1, 2, 3, 4, 255):
        machine.write(0x3F, value)
        assert window(machine, range(0, 0x800, 31)) == slices[value % 4]
        assert window(machine, range(0x800, 0x1000, 31)) == slices[3]
    for page in (0, 1, 31, 32 + 5):
        machine.write(0x3E if page else 0xF03E, page)
        for offset in range(0x400):
            machine.write(0xF400 + offset, offset * 7 + page & 0xFF)
    for page in (0, 1, 31, 5):
        machine.write(0x3E, page)
        written = page if page != 5 else 37
        expected = bytes(offset * 7 + written & 0xFF for offset in range(0x400))
        assert bytes(machine.read(0x1000 + offset) for offset in range(0x400)) == expected
        assert bytes(machine.read(0x1400 + offset) for offset in range(0x400)) == expected
        assert machine.cartridge_ram[1024 * page :][:1024] == expected
        assert window(machine, range(0x800, 0x1000, 31)) == slices[3]
    before = machine.cartridge_ram
    machine.write(0x1000 + W.COLUBK, 0x46)  # the read port is the TIA's
    assert machine.state()["tia"]["colour"][3] == 0x46
    assert [machine.read(address) for address in range(0x40)] == list(before[5 * 1024 :][:0x40])
    machine.write(W.COLUBK, 0x48)
    assert machine.state()["cart"]["slice"][2] == 1  # no other register switches
    machine.write(0x103F, 2)
    assert window(machine, range(0, 0x800, 31)) == slices[2]
    machine.write(0x1400, 0x11)  # ROM is shown there now
    assert machine.cartridge_ram == before
    machine.reset()
    assert window(machine, range(0, 0x800, 31)) == slices[0]


@pytest.mark.parametrize(
    "access", [Console.read, lambda machine, address: machine.write(address, 0)], ids=["read", "write"]
)
def test_ua(access: Callable[[Console, int], object]) -> None:
    image = image_of(8192)
    machine = Console(image, "UA")
    assert window(machine) == bank_bytes(image, 0)
    for address, bank in ((0x240, 1), (0x220, 0), (0xE240, 1), (0x2220, 0)):
        access(machine, address)
        assert window(machine) == bank_bytes(image, bank)
        for other in (0x221, 0x241, 0x1220, 0x1240, 0x2A0, 0x20, 0x40, 0x1FF8, 0x1FF9):
            access(machine, other)
            assert window(machine) == bank_bytes(image, bank)
    machine.write(0x240, 0)
    machine.reset()
    assert window(machine) == bank_bytes(image, 0)


def test_ua_passes_its_hotspots_on_to_the_tia() -> None:
    machine = Console(image_of(8192), "UA")
    machine.write(0x220, 0x70)  # HMP0
    assert machine.state()["tia"]["hm"][0] == 7
    machine.write(0x80, 0x15)
    assert machine.read(0x24F) == 0x15


@pytest.mark.parametrize("size", [2048, 4096])
def test_cv(size: int) -> None:
    """ROM above, RAM below: read at $000, written at $400."""
    image = image_of(size)
    machine = Console(image, "CV")
    assert window(machine, range(0x800, 0x1000, 13)) == image[-2048::13]
    if size == 4096:
        assert machine.cartridge_ram == image[:1024]  # not random then
    for offset in range(0x400):
        machine.write(0xF400 + offset, offset * 3 & 0xFF)
        machine.write(0xF000 + offset, 0xEE)
    expected = bytes(offset * 3 & 0xFF for offset in range(0x400))
    assert bytes(machine.read(0x1000 + offset) for offset in range(0x400)) == expected
    assert machine.cartridge_ram == expected
    machine.write(0xF900, 0x12)
    assert window(machine, range(0x800, 0x1000, 13)) == image[-2048::13]


def test_mb_goes_on_to_the_next_bank() -> None:
    image = image_of(65536)
    machine = Console(image, "MB")
    assert window(machine) == bank_bytes(image, 1)
    bank = 1
    for number in range(40):
        bank = (bank + 1) % 16
        if number % 3:
            assert machine.read(0xFFF0) == image[4096 * bank + 0xFF0]
        else:
            machine.write(0x1FF0, 0)
        assert window(machine) == bank_bytes(image, bank)
        machine.read(0x1FF1)
        machine.read(0x1FEF)
    machine.reset()
    assert window(machine) == bank_bytes(image, 1)


def test_no_switching_by_accesses_of_other_chips() -> None:
    """$0FF8 is RIOT, TIA or RAM, whatever its low bits are."""
    machine = Console(image_of(8192), "F8")
    for address in (0x0FF8, 0x2FF8, 0x0EF8, 0xEFF8):
        machine.read(address)
        machine.write(address, 0)
    assert machine.state()["cart"]["bank"] == 1
