"""`MultiplayerCore`: players, options, snapshots. `test_goldens.py` compares it with Multi-Agent-ALE."""

from functools import partial
from typing import Any

import numpy as np
import pytest

import atari
from atari.cores import NativeCore
from atari.multiplayer import MultiplayerCore
from atari.testing import ContractError, check_core

GAMES = [game.id for game in atari.games.values() if game.multiplayer]


def test_twenty_seven_games_have_rules_for_several_players() -> None:
    assert len(GAMES) == 27


def core_of(game: str, *, frame_skip: int = 1, **options: Any) -> MultiplayerCore:
    """A core made with the options of cores for one player."""
    return MultiplayerCore(game, frameskip=frame_skip, **options)


@pytest.mark.parametrize("game", ["pong", "warlords", "combat", "flag_capture", "video_checkers"])
def test_it_keeps_the_contract_of_cores(game: str) -> None:
    check_core(partial(core_of, game), steps=30)
    check_core(partial(core_of, game, end_of_reset="ale_py", random_words="ale_py"), steps=12)


class PaysTheFirst(MultiplayerCore):
    def act_players(self, actions: Any) -> Any:
        return super().act_players(actions)[:1]


class LeavesPlayersOut(MultiplayerCore):
    def act_players(self, actions: Any) -> Any:
        return super().act_players([*actions, 0, 0, 0][: self.players])


class PlaysTheSecond(MultiplayerCore):
    def act_players(self, actions: Any) -> Any:
        return super().act_players([*actions[1:], actions[0]])


@pytest.mark.parametrize(
    ("core_type", "sentence"),
    [
        (PaysTheFirst, r"act_players\(\[\d+, 0\]\) must return a reward for each player, got \[0\]"),
        (LeavesPlayersOut, r"act_players\(\[0\]\) must raise TypeError or ValueError, but raised nothing"),
        (PlaysTheSecond, r"act_players\(\[\d+, 0\]\) must play as act\(\d+\); the core"),
    ],
)
def test_a_fault_of_act_players_gets_its_sentence(core_type: type[MultiplayerCore], sentence: str) -> None:
    with pytest.raises(ContractError, match=sentence):
        check_core(lambda frame_skip=1, **options: core_type("pong", frameskip=frame_skip, **options), steps=12)


@pytest.mark.parametrize("game", GAMES)
def test_every_mode_can_be_selected(game: str) -> None:
    rules = atari.games[game].multiplayer
    assert rules is not None
    for players, modes in rules.modes.items():
        for mode in (modes[0], modes[-1]):
            core = MultiplayerCore(game, mode=mode)
            core.reset()
            assert core.players == players
            assert core.act_players([0] * players) == [0] * players or game == "video_checkers"


def played(core: Any) -> Any:
    core.reset()
    for _ in range(20):
        core.act_players([3] * core.players) if isinstance(core, MultiplayerCore) else core.act(3)
    return core


@pytest.mark.parametrize(
    ("other", "text"),
    [
        (lambda: MultiplayerCore("pong", players=4), "is of a game of 4 players, not of 2"),
        (lambda: MultiplayerCore("pong", mode=10), "was taken with mode = 10, but this environment has 4"),
        (lambda: MultiplayerCore("warlords", players=2), "was taken with game = 'warlords'"),
        (lambda: NativeCore("pong", seed=0), "was taken with core = 'native', but this environment has 'multiplayer'"),
        (lambda: MultiplayerCore("pong", repeat_action_probability=0.5), "was taken with repeat_action_probability"),
    ],
)
def test_a_snapshot_of_another_core_is_refused_and_changes_nothing(other: Any, text: str) -> None:
    core, of = played(MultiplayerCore("pong", players=2)), played(other())
    for target, source, message in (
        (core, of, text),
        (of, core, "snapshot (was taken with|is of a game of 2 players)"),
    ):
        before = target.save()
        with pytest.raises(ValueError, match=message):
            target.restore(source.snapshot())
        assert target.save() == before


def test_ale_pys_numbers_of_modes_differ_where_the_game_says() -> None:
    assert MultiplayerCore("tennis", mode=1, mode_numbers="ale_py").mode == 2
    assert MultiplayerCore("boxing", mode=2, mode_numbers="ale_py").mode == 2
    with pytest.raises(ValueError, match="must be one of 1, 3, got 2"):
        MultiplayerCore("tennis", mode=2, mode_numbers="ale_py")


def test_the_end_of_a_reset_can_be_that_of_one_player() -> None:
    frames = {}
    for reference in ("multi_agent_ale", "ale_py"):
        core = MultiplayerCore("mario_bros", end_of_reset=reference, random_words="ale_py")
        core.reset()
        frames[reference] = core.ram()
    assert not np.array_equal(*frames.values())


def test_parameters_of_the_rules_can_be_set() -> None:
    def rewards(limit: int) -> int:
        core = MultiplayerCore("tennis", parameters={"max_turn_time": limit})
        core.reset()
        return sum(sum(core.act_players([0, 0])) for _ in range(400))

    assert (rewards(180), rewards(100), rewards(0)) == (-2, -3, 0)


def test_a_mode_and_a_difficulty_can_be_set() -> None:
    core = MultiplayerCore("tennis", mode_numbers="ale_py")
    core.set_mode(4)
    core.set_difficulty(1)
    assert (core.mode, core.difficulty, core.task.mode, core.task.difficulty) == (4, 1, 4, 1)
    core.reset()
    other = MultiplayerCore("tennis", **core.options)
    other.reset()
    assert np.array_equal(core.ram(), other.ram())
    for wrong, kind in ((1, ValueError), (None, TypeError), ("2", TypeError)):
        with pytest.raises(kind):
            core.set_mode(wrong)
    for wrong, kind in ((4, ValueError), (None, TypeError)):
        with pytest.raises(kind):
            core.set_difficulty(wrong)
    assert (core.mode, core.difficulty) == (4, 1)


def test_a_closed_core_says_so() -> None:
    core = MultiplayerCore("pong")
    core.close()
    with pytest.raises(RuntimeError, match="this core is closed"):
        core.act_players([0, 0])


def test_wrong_calls_change_nothing() -> None:
    core = MultiplayerCore("pong", players=4)
    core.reset()
    before = core.save()
    for actions in ([0], [0] * 5, [0, 0, 0, 18], [0, 0, 0, "x"]):
        with pytest.raises((ValueError, TypeError)):
            core.act_players(actions)
    assert core.save() == before
    with pytest.raises(ValueError, match="no game of several players named 'breakout'"):
        MultiplayerCore("breakout")
    with pytest.raises(ValueError, match="for 2 or 4 players"):
        MultiplayerCore("pong", players=3)
