"""Blackjack for two players, a game that Multi-Agent-ALE has no rules for."""

import random

import pytest

from atari.multiplayer import MultiplayerCore

FIRE, RIGHT, LEFT = 1, 3, 4
BETS = 0x0F, 0x10  # in RAM


def started(difficulty: int = 0) -> MultiplayerCore:
    core = MultiplayerCore("blackjack", difficulty=difficulty)
    core.reset()
    assert (chips(core), core.player_lives, core.game_over) == ([200, 200], [0, 0], False)
    return core


def chips(core: MultiplayerCore) -> list[int]:
    """The numbers on the screen: hundreds (0x0A is 1,000, 0x0B none at all) and binary-coded decimals."""
    ram = core.ram().tolist()
    return [0 if ram[6 + i] == 0x0B else 100 * ram[6 + i] + int(f"{ram[9 + i]:02x}") for i in range(2)]


def play(core: MultiplayerCore, seed: int, frames: int = 50_000, idle: int | None = None) -> int:
    """Play at random until the game is over; the number of frames. Rewards are the changes of the chips on the screen."""
    source, before = random.Random(seed), chips(core)
    for frame in range(frames):
        if frame % 10 == 0:
            actions = [0 if i == idle else source.choice((0, 1, 1, 3, 4, 11, 12)) for i in range(2)]
        rewards, lives = core.act_players(actions), core.player_lives
        after = chips(core)
        assert rewards == [b - a for a, b in zip(before, after, strict=True)]
        assert [life < 0 for life in lives] == [chip == 0 for chip in after]
        before = after
        if core.game_over:
            return frame + 1
    return frames


@pytest.mark.parametrize(
    ("seed", "difficulty", "frames"), [(0, 0, 18_050), (1, 1, 18_159), (2, 2, 31_253), (3, 3, 23_100)]
)
def test_random_players_lose_all_chips(seed: int, difficulty: int, frames: int) -> None:
    core = started(difficulty)
    assert play(core, seed) == frames
    assert (core.player_lives, core.game_over) == ([-1, -1], True)


@pytest.mark.parametrize("player", [0, 1])
def test_a_paddle_sets_the_own_bet(player: int) -> None:
    core = started()
    for other in (0, 1):
        for action in (0, RIGHT, LEFT):
            actions = [0, 0]
            actions[other] = action
            for _ in range(40):
                core.act_players(actions)
            assert action == 0 or core.ram()[BETS[other]] == {RIGHT: 0x01, LEFT: 0x25}[action]
    for action in range(18):
        actions = [0, 0]
        actions[player] = action
        for _ in range(10):
            core.act_players([0 if a == FIRE or a > 9 else a for a in actions])
            assert core.ram()[BETS[1 - player]] == 0x25


@pytest.mark.parametrize("idle", [0, 1])
def test_a_player_who_does_nothing_is_waited_for(idle: int) -> None:
    core = started()
    assert play(core, 5, 3000, idle) == 3000
    assert chips(core) == [200, 200]


def give(core: MultiplayerCore, player: int, number: int) -> None:
    core.set_ram(6 + player, number // 100)
    core.set_ram(9 + player, int(str(number % 100), 16))
    core.act_players([0, 0])


@pytest.mark.parametrize("poor", [0, 1])
def test_the_other_player_plays_on_alone(poor: int) -> None:
    core = started()
    give(core, poor, 5)
    give(core, 1 - poor, 900)
    assert play(core, 3, 3000) == 3000
    assert (chips(core)[poor], core.player_lives[poor], core.player_lives[1 - poor]) == (0, -1, 0)
    before = chips(core)
    assert play(core, 3, 3000, idle=poor) == 3000
    assert chips(core)[poor] == 0
    assert chips(core)[1 - poor] != before[1 - poor]


@pytest.mark.parametrize(("rich", "seed", "number"), [(0, 5, 1035), (1, 2, 1035)])
def test_a_player_with_1000_chips_plays_no_more(rich: int, seed: int, number: int) -> None:
    core = started()
    give(core, rich, 999)
    play(core, seed, 1200)
    assert chips(core)[rich] == number
    other = chips(core)[1 - rich]
    assert play(core, 4, 6000, idle=rich) == 6000
    assert chips(core)[rich] == number
    assert chips(core)[1 - rich] != other
    assert core.player_lives == [0, 0]
    give(core, 1 - rich, 3)
    assert play(core, 6) < 10_000
    assert (core.game_over, core.player_lives[1 - rich], core.player_lives[rich]) == (True, -1, 0)
