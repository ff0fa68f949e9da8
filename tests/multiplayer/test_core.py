"""`MultiplayerCore`: players, options, snapshots. `test_goldens.py` compares it with Multi-Agent-ALE."""

import numpy as np
import pytest

import atari
from atari.multiplayer import MultiplayerCore

GAMES = [game.id for game in atari.games.values() if game.multiplayer]


def test_twenty_one_games_have_rules_for_several_players() -> None:
    assert len(GAMES) == 21


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


@pytest.mark.parametrize("game", ["pong", "warlords", "double_dunk", "maze_craze"])
def test_a_snapshot_of_a_sticky_game_continues(game: str) -> None:
    core = MultiplayerCore(game, repeat_action_probability=0.25)
    core.reset()
    actions = np.random.default_rng(0).integers(0, 18, (60, core.players)).tolist()
    for action in actions[:30]:
        core.act_players(action)
    state = core.snapshot()
    first = [(core.act_players(action), core.ram().tobytes()) for action in actions[30:]]
    other = MultiplayerCore(game, repeat_action_probability=0.25, seed=9)
    other.restore(state)
    assert [(other.act_players(action), other.ram().tobytes()) for action in actions[30:]] == first


def test_a_snapshot_of_another_mode_is_refused() -> None:
    core, other = MultiplayerCore("pong", players=2), MultiplayerCore("pong", players=4)
    core.reset()
    with pytest.raises(ValueError, match="mode"):
        other.restore(core.snapshot())


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


def test_wrong_calls_change_nothing() -> None:
    core = MultiplayerCore("pong", players=4)
    core.reset()
    before = core.save()
    for actions in ([0], [0] * 5, [0, 0, 0, 18], [0, 0, 0, "x"]):
        with pytest.raises((ValueError, TypeError)):
            core.act_players(actions)
    assert core.save() == before
    with pytest.raises(ValueError, match="backgammon, boxing"):
        MultiplayerCore("breakout")
    with pytest.raises(ValueError, match="for 2 or 4 players"):
        MultiplayerCore("pong", players=3)
