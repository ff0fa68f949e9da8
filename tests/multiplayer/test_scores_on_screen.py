"""Where games with rules of our own show the bytes that their rules read as scores."""

import numpy as np
import pytest

from atari.multiplayer import MultiplayerCore

LEFT, RIGHT = (0, 79), (80, 159)


@pytest.mark.parametrize(
    ("game", "mode", "address", "value", "columns"),
    [
        ("atlantis", 2, 0xA2, 0x47, (0, 159)),
        ("atlantis", 2, 0xA3, 0x12, (0, 159)),
        ("blackjack", 0, 0x86, 0x05, (40, 51)),
        ("blackjack", 0, 0x89, 0x47, (40, 51)),
        ("blackjack", 0, 0x87, 0x05, (72, 83)),
        ("blackjack", 0, 0x8A, 0x47, (72, 83)),
        ("bowling", 1, 0xA1, 0x47, LEFT),
        ("bowling", 1, 0xA2, 0x47, RIGHT),
        ("bowling", 1, 0xA6, 0x01, LEFT),
        ("bowling", 1, 0xA7, 0x01, RIGHT),
        ("freeway", 0, 0xE7, 0x47, LEFT),
        ("freeway", 0, 0xE8, 0x47, RIGHT),
        ("hangman", 4, 0xEB, 0x07, LEFT),
        ("hangman", 4, 0xEC, 0x07, RIGHT),
        ("human_cannonball", 0, 0xB6, 0x03, LEFT),
        ("human_cannonball", 0, 0xB7, 0x03, RIGHT),
    ],
)
def test_a_byte_changes_the_digits_of_its_player(
    game: str, mode: int, address: int, value: int, columns: tuple[int, int]
) -> None:
    cores = [MultiplayerCore(game, mode=mode) for _ in range(2)]
    for core in cores:
        core.reset()
        for _ in range(10):
            core.act_players([0, 0])
    cores[0].set_ram(address - 0x80, value)
    for core in cores:
        for _ in range(4):
            core.act_players([0, 0])
    changed = np.argwhere(cores[0].screen() != cores[1].screen())
    assert len(changed)
    assert columns[0] <= changed[:, 1].min()
    assert changed[:, 1].max() <= columns[1]
    assert np.ptp(changed[:, 0]) < 16
