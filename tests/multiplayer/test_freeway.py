"""Freeway for two players, a game that Multi-Agent-ALE has no rules for."""

import pytest

from atari.multiplayer import MultiplayerCore

UP, FRAMES = 2, 8190


def scores(actions: list[int], mode: int = 0, difficulty: int = 0, most: int = 10_000) -> list[int]:
    """The sums of the rewards of a game, or of its first frames, in which each player holds an action."""
    core = MultiplayerCore("freeway", mode=mode, difficulty=difficulty)
    core.reset()
    totals, frames = [0, 0], 0
    while not core.game_over and frames < most:
        totals = [total + reward for total, reward in zip(totals, core.act_players(actions), strict=True)]
        frames += 1
    assert frames == min(FRAMES, most)
    # The digits of the screen, in binary-coded decimal, are what was paid.
    assert totals == [10 * (byte >> 4) + (byte & 15) for byte in core.ram()[[0x67, 0x68]].tolist()]
    return totals


@pytest.mark.parametrize("mode", range(8))
def test_only_the_own_sticks_up_raises_a_score(mode: int) -> None:
    assert min(scores([UP, UP], mode)) > 0
    first, second = scores([UP, UP], mode, most=4000)
    assert scores([UP, 0], mode, most=4000) == [first, 0]
    assert scores([0, UP], mode, most=4000) == [0, second]
    assert first > 0 < second


@pytest.mark.parametrize("action", [1, 3, 4, 5, 17])
def test_actions_without_up_score_nothing(action: int) -> None:
    assert scores([action, action]) == [0, 0]


def test_a_difficulty_switch_is_of_one_player() -> None:
    first, second = zip(*(scores([UP, UP], difficulty=difficulty) for difficulty in range(4)), strict=True)
    assert first[0] == first[2] != first[1] == first[3]
    assert second[0] == second[1] != second[2] == second[3]
