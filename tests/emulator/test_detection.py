"""Detection of a cartridge's type from its image: by size, then by signatures, in order."""

import random

import pytest
from atari_inspection import Console
from emulator.machines import rom

from atari import roms
from atari.games.catalog import games
from atari.games.game import Game
from atari.roms.image import read_image

CV = bytes([0x9D, 0xFF, 0xF3])
CV_2 = bytes([0x99, 0x00, 0xF4])
E0 = [bytes.fromhex(code) for code in ("8DE01F", "8DE05F", "8DE9FF", "ADE9FF", "ADEDFF", "ADF3BF")]
TYPE_3E = bytes.fromhex("853EA900")
TYPE_3F = bytes.fromhex("853F")
UA = bytes.fromhex("8D4002")
FE = [bytes.fromhex(code) for code in ("2000D0C6C5", "20C3F8A582", "D0FB2073FE", "2000F084D6")]


def filled(size: int) -> bytearray:
    """An image that matches no type: its halves differ, and no stretches are equal."""
    return bytearray(byte % 5 + 1 for byte in random.Random(7).randbytes(size))


def image(size: int, *signatures: bytes, at: int = 1000) -> bytes:
    data = filled(size)
    for number, signature in enumerate(signatures):
        data[at + 20 * number : at + 20 * number + len(signature)] = signature
    return bytes(data)


def superchip(size: int, *signatures: bytes) -> bytes:
    data = bytearray(image(size, *signatures))
    for bank in range(0, size, 4096):
        data[bank : bank + 256] = bytes([bank // 4096]) * 256
    return bytes(data)


def like_e7(before: int = 1, after: int = 1) -> bytearray:
    data = filled(16384)
    data[0x3800 - 32 : 0x3A00 + 32] = bytes([before]) * 32 + bytes([1]) * 0x200 + bytes([after]) * 32
    return data


CASES = [
    ("2K", image(2048)),
    ("CV", image(2048, CV)),
    ("CV", image(2048, CV_2)),
    ("2K", bytes(filled(2048)) * 2),  # equal halves
    ("CV", image(2048, CV) * 2),
    ("4K", image(4096)),
    ("CV", image(4096, CV_2)),
    ("4K", image(4096, TYPE_3E, TYPE_3F, TYPE_3F, UA, *E0, *FE)),  # none of these at this size
    ("F8", image(8192)),
    ("F8SC", superchip(8192)),
    ("F8SC", superchip(8192, E0[0], TYPE_3E)),
    ("4K", image(4096) * 2),
    ("4K", image(4096, E0[0]) * 2),
    *(("E0", image(8192, signature, TYPE_3E, TYPE_3F, TYPE_3F)) for signature in E0),
    ("3E", image(8192, TYPE_3E, TYPE_3F, TYPE_3F, UA)),
    ("3F", image(8192, TYPE_3F, TYPE_3F, UA, FE[0])),
    ("F8", image(8192, TYPE_3F)),  # once is not enough
    ("UA", image(8192, UA, FE[0])),
    *(("FE", image(8192, signature)) for signature in FE),
    ("F8", image(8192, CV)),
    ("DPC", image(10240)),
    ("DPC", image(10495, TYPE_3E)),
    ("DPC", image(10496)),
    ("FASC", image(12288, TYPE_3E)),
    ("F6", image(16384)),
    ("F6SC", superchip(16384, TYPE_3E)),
    ("E7", bytes(like_e7(before=2))),
    ("E7", bytes(like_e7(after=2))),
    ("F6", bytes(like_e7())),  # the neighbourhood is equal too
    ("3E", image(16384, TYPE_3E, TYPE_3F, TYPE_3F)),
    ("3F", image(16384, TYPE_3F, TYPE_3F)),
    ("F6", image(16384, UA, FE[0], E0[0])),
    ("F4", image(32768)),
    ("F4SC", superchip(32768, TYPE_3E)),
    ("3E", image(32768, TYPE_3E)),
    ("3F", image(32768, TYPE_3F, TYPE_3F)),
    ("MB", image(65536)),
    ("3E", image(65536, TYPE_3E)),
    ("3F", image(65536, TYPE_3F, TYPE_3F)),
    ("3E", image(131072, TYPE_3E)),
    ("3F", image(131072, TYPE_3F, TYPE_3F)),
    ("3F", image(6144, TYPE_3F, TYPE_3F)),
    ("3E", image(524288, TYPE_3E)),
]


@pytest.mark.parametrize(("expected", "data"), CASES, ids=[f"{name} {len(data)}" for name, data in CASES])
def test_detection(expected: str, data: bytes) -> None:
    assert Console(data).cartridge_type == expected


def test_e7_looks_at_32_bytes_on_either_side() -> None:
    data = like_e7()
    for place, expected in (
        (0x3800 - 32, "E7"),
        (0x3800 - 33, "F6"),
        (0x3A00 + 31, "E7"),
        (0x3A00 + 32, "F6"),
        (0x3900, "F6"),
    ):
        other = bytearray(data)
        other[place] = 9
        assert Console(bytes(other)).cartridge_type == expected, hex(place)


def test_last_place_of_a_signature_is_not_looked_at() -> None:
    """As in ale-py."""
    assert Console(image(8192, UA, at=8192 - 3)).cartridge_type == "F8"
    assert Console(image(8192, UA, at=8192 - 4)).cartridge_type == "UA"
    assert Console(image(8192, UA, at=0)).cartridge_type == "UA"


def test_search_goes_on_a_byte_late_after_a_hit() -> None:
    """The search skips a byte after a hit, so the two bytes of 3F twice in a row count once."""
    assert Console(image(8192, TYPE_3F * 2)).cartridge_type == "F8"
    assert Console(image(8192, TYPE_3F + b"\x00" + TYPE_3F)).cartridge_type == "3F"


def test_superchip_needs_every_bank() -> None:
    data = bytearray(superchip(16384))
    data[4096 * 2 + 255] ^= 1
    assert Console(bytes(data)).cartridge_type == "F6"


TYPES = ["2K", "4K", "F8", "F8 SWAPPED", "F6", "F4", "F8SC", "F6SC", "F4SC", "FASC", "E0", "E7", "FE", "DPC", "3F", "3E",
         "UA", "CV", "MB"]  # fmt: skip


@pytest.mark.parametrize("name", TYPES)
def test_types_by_name(name: str) -> None:
    assert Console(rom(banks=16), name).cartridge_type == name


@pytest.mark.parametrize("name", ["AR", "MC", "4A50", "0840", "f8", "F8 ", "AUTO-DETECT"])
def test_unknown_names(name: str) -> None:
    with pytest.raises(ValueError, match=f"^there is no cartridge type '{name}'; the types are {', '.join(TYPES)}$"):
        Console(rom(), name)


@pytest.mark.parametrize("size", [8448, 16896, 8448 * 4])
def test_supercharger_is_refused(size: int) -> None:
    with pytest.raises(ValueError, match=r"^Supercharger \(AR\) images are not supported: "):
        Console(image(size, TYPE_3E))


@pytest.mark.parametrize("size", [0, 1, 100, 2047, 2049, 6144, 20480, 131072, 262144])
def test_unknown_sizes_are_refused(size: int) -> None:
    with pytest.raises(ValueError, match=f"^an image of {size} bytes is of no supported cartridge type$"):
        Console(bytes(filled(size)))


@pytest.mark.parametrize(
    ("name", "size", "least"),
    [
        ("2K", 2047, 2048),
        ("4K", 2048, 4096),
        ("F8", 8191, 8192),
        ("DPC", 10239, 10240),
        ("MB", 32768, 65536),
        ("3F", 100, 2048),
    ],
)
def test_short_images_are_refused(name: str, size: int, least: int) -> None:
    sentence = f"^a cartridge of type {name} needs an image of at least {least} bytes, this one has {size}$"
    with pytest.raises(ValueError, match=sentence):
        Console(bytes(filled(size)), name)


def test_huge_images_are_refused() -> None:
    with pytest.raises(ValueError, match=r"^an image has at most 524288 bytes$"):
        Console(bytes(524289))


@pytest.mark.parametrize("game", games.values(), ids=list(games))
def test_shipped_games(game: Game) -> None:
    """The detected type is the one in the game's file."""
    assert Console(read_image(roms.find(game.id))).cartridge_type == game.rom.cartridge
