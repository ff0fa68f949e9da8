"""Atlantis for two partners, a game that Multi-Agent-ALE has no rules for."""

import numpy as np
import pytest

from atari.multiplayer import MultiplayerCore

FIRE = 1


def started(seed: int = 1) -> MultiplayerCore:
    core = MultiplayerCore("atlantis", seed=seed)
    core.reset()
    assert (core.mode, core.player_lives, core.game_over) == (2, [6, 6], False)
    return core


def shown(core: MultiplayerCore) -> int:
    """The score on the screen, from its binary-coded decimals."""
    high, low, middle = core.ram()[[0x21, 0x22, 0x23]].tolist()
    return int(f"{high:02x}{middle:02x}{low:02x}00")


@pytest.mark.parametrize(
    ("guns", "score", "frames"),
    [([0, 0], 1500, 1942), ([1, 0], 16_200, 4662), ([0, 1], 9200, 2750), ([1, 1], 30_000, 5430)],
)
def test_both_are_paid_the_score_of_the_screen(guns: list[int], score: int, frames: int) -> None:
    core, total, frame = started(), 0, 0
    while True:
        first, second = core.act_players([gun * FIRE if frame % 8 < 4 else 0 for gun in guns])
        frame += 1
        assert first == second
        assert core.player_lives[0] == core.player_lives[1]
        total += first
        if core.game_over:
            break
        assert total == shown(core)
    assert (total, frame, core.player_lives) == (score, frames, [0, 0])
    assert int(core.ram()[0x71]) == 0xFF  # the parts of the city


def fired(actions: list[int]) -> list[tuple[list[int], list[int]]]:
    """The first and last rows and columns of the pixels that differ from those of a game without a shot."""
    core, idle = started(), started()
    places = []
    for frame in range(50):
        core.act_players(actions if 30 <= frame < 34 else [0, 0])
        idle.act_players([0, 0])
        changed = np.argwhere(core.screen_grayscale() != idle.screen_grayscale())
        if len(changed):
            places.append((changed.min(0).tolist(), changed.max(0).tolist()))
    return places


@pytest.mark.parametrize("action", range(18))
def test_each_player_has_a_gun(action: int) -> None:
    left, right = fired([action, 0]), fired([0, action])
    if action == 1 or action > 9:
        assert left[0] == ([124, 1], [130, 7])
        assert right[0] == ([111, 151], [118, 158])
    else:
        assert left == right == []
