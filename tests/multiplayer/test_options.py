"""Options beyond PettingZoo: sticky actions by player, true scores, zero-sum rewards, action sets of each agent."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pettingzoo")
from pettingzoo.test import parallel_api_test

from atari.multiplayer import MultiplayerCore, parallel_env
from atari.multiplayer.parallel import MultiplayerEnv

BOXING: tuple[tuple[dict[str, Any], type[Exception], str], ...] = (
    ({"preset": "dqn"}, ValueError, "Several players have 'multiplayer_dqn'"),
    ({"preset": "dqn2015"}, ValueError, "preset 'dqn2015' is for one player; use 'multiplayer_dqn'"),
    ({"preset": "multiplayer_dqn", "stack_num": 0}, ValueError, "stack_num"),
    ({"preset": "multiplayer_dqn", "shape": 84}, TypeError, "did you mean 'img_height'"),
    ({"preset": "multiplayer_dqn", "player_indicator": True}, TypeError, "did you mean 'agent_indicator'"),
    ({"agent_indicator": 1}, TypeError, "must be True or False"),
    ({"frame_skip": 4}, TypeError, "did you mean 'frameskip'"),
    ({"stack": 4}, TypeError, "did you mean 'stack_num'"),
    ({"num_players": 2}, TypeError, "did you mean 'players'"),
    ({"max_cycles": 3, "max_episode_steps": 3}, TypeError, "two names of one option"),
    ({"rom": "a", "auto_rom_install_path": "b"}, TypeError, "two names of one option"),
    ({"obs_type": "grayscale", "agent_indicator": True}, ValueError, "add stack_num=1"),
    ({"repeat_action_probability": [0.1, 0.2, 0.3]}, ValueError, "one for each of 2 players"),
    ({"mode_numbers": "ale"}, ValueError, "mode_numbers must be one of"),
    ({"mode": 3, "mode_numbers": "ale_py"}, ValueError, "mode of boxing must be one of 2, got 3"),
    ({"players": 1}, ValueError, "boxing is for 2 players, got players=1"),
)


def play(core: MultiplayerCore, actions: Any) -> list[bytes]:
    core.reset()
    return [(core.act_players(action), core.ram().tobytes())[1] for action in actions]


def test_sticky_actions_can_differ_by_player() -> None:
    actions = np.random.default_rng(1).integers(0, 18, (80, 2)).tolist()
    both = play(MultiplayerCore("boxing", repeat_action_probability=0.25), actions)
    assert play(MultiplayerCore("boxing", repeat_action_probability=[0.25, 0.25]), actions) == both
    assert play(MultiplayerCore("boxing", repeat_action_probability=(0.25, 0.9)), actions) != both
    # Where player 2 always repeats, its action of the reset, NOOP, lasts for ever; player 1 is free.
    stuck = play(MultiplayerCore("boxing", repeat_action_probability=np.array([0.0, 1.0])), actions)
    assert stuck == play(MultiplayerCore("boxing"), [[first, 0] for first, _ in actions])


def test_probabilities_by_player_do_not_change_the_random_words() -> None:
    """Player 2's actions stick in the same frames, whatever player 1's probability is."""
    actions = np.random.default_rng(1).integers(0, 18, (80, 2)).tolist()
    idle = [[0, second] for _, second in actions]
    runs = [play(MultiplayerCore("boxing", repeat_action_probability=[p, 0.25]), idle) for p in (0.0, 0.25, 1.0)]
    assert runs[0] == runs[1] == runs[2]


def flags(corrected: bool) -> list[tuple[int, list[int]]]:
    """A game in which each player captures a flag once: the frames with a reward."""
    core = MultiplayerCore("flag_capture", corrected_scores=corrected)
    core.reset()
    source, paid = np.random.default_rng(1), []
    for frame in range(400):
        if frame % 6 == 0:
            actions = source.integers(0, 18, 2).tolist()
        if any(rewards := core.act_players(actions)):
            paid.append((frame, rewards))
    assert core.ram()[[0x6A, 0x6B]].tolist() == [1, 1]
    return paid


def test_a_corrected_capture_pays_each_player_one_at_once() -> None:
    assert flags(corrected=True) == [(286, [1, 0]), (395, [0, 1])]
    assert flags(corrected=False) == [(287, [5, 0]), (395, [0, 1])]


def test_each_point_of_a_written_score_pays_one() -> None:
    core = MultiplayerCore("flag_capture", corrected_scores=True)
    core.reset()
    for player in (0, 1):
        for score in range(1, 10):
            core.set_ram(0x6A + player, score)
            assert core.act_players([0, 0]) == [int(player == 0), int(player == 1)]


def test_games_without_an_error_are_the_same_when_corrected() -> None:
    assert parallel_env("boxing", corrected_scores=True).reset(seed=1)


@pytest.mark.parametrize(("players", "factor"), [(2, 2.0), (4, 4 / 3)])
def test_zero_sum_rewards_of_pong_are_multiples(players: int, factor: float) -> None:
    plain = MultiplayerEnv("pong", num_players=players, obs_type="ram", frameskip=4)
    other = MultiplayerEnv("pong", num_players=players, obs_type="ram", frameskip=4, zero_sum=True)
    source, points = np.random.default_rng(0), 0
    plain.reset(seed=1)
    other.reset(seed=1)
    for _ in range(500):
        actions = {agent: int(source.integers(6)) for agent in plain.agents}
        rewards, zero = plain.step(actions)[1], other.step(actions)[1]
        points += any(rewards.values())
        assert sum(zero.values()) == 0
        if sum(rewards.values()) == 0:  # the clock of the serve charges one side alone
            assert zero == {agent: reward * factor for agent, reward in rewards.items()}
        assert all(reward.dtype == np.float64 for reward in zero.values())
    assert points > 2


def test_zero_sum_is_the_reward_minus_the_mean_of_the_others() -> None:
    plain = MultiplayerEnv("space_invaders", obs_type="ram", frameskip=4)
    other = MultiplayerEnv("space_invaders", obs_type="ram", frameskip=4, zero_sum=True)
    plain.reset(seed=1)
    other.reset(seed=1)
    points = 0
    for _ in range(300):
        rewards = plain.step({"first_0": 1, "second_0": 4})[1]
        zero = other.step({"first_0": 1, "second_0": 4})[1]
        assert zero["first_0"] == rewards["first_0"] - rewards["second_0"] == -zero["second_0"]
        points += any(rewards.values())
    assert points > 2


def test_each_agent_can_have_its_own_actions() -> None:
    sets = [["NOOP", "LEFT", "RIGHT"], ["FIRE", "UP"]]
    env = MultiplayerEnv("boxing", obs_type="ram", action_sets=sets)
    same = MultiplayerEnv("boxing", obs_type="ram", full_action_space=True)
    assert [env.action_space(agent).n for agent in env.possible_agents] == [3, 2]
    assert env.action_mappings["second_0"].tolist() == [1, 2]
    env.reset(seed=1)
    same.reset(seed=1)
    for step in range(200):
        first, second = step // 7 % 3, step // 5 % 2
        one = env.step({"first_0": first, "second_0": second})[0]
        two = same.step({"first_0": (0, 4, 3)[first], "second_0": (1, 2)[second]})[0]
        assert np.array_equal(one["first_0"], two["first_0"])
    by_agent = {"second_0": ["FIRE", "UP"], "first_0": ["NOOP", "LEFT", "RIGHT"]}
    parallel_api_test(parallel_env("boxing", obs_type="ram", action_sets=by_agent), num_cycles=20)


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: parallel_env("pong_v2"), ValueError, "the version of pong is 3"),
        (lambda: parallel_env("pnog"), ValueError, "did you mean 'pong'"),
        (lambda: parallel_env("breakout"), ValueError, "no game of several players named 'breakout'"),
        (lambda: parallel_env(3), TypeError, "named by a string"),
        (lambda: parallel_env("pong", num_players=True), TypeError, "must be int"),
        (lambda: parallel_env("pong", game_version="tennis"), ValueError, "one of 'classic'"),
        (lambda: parallel_env("pong", mode=4, num_players=2), ValueError, "not both"),
        (lambda: parallel_env("pong", obs_type="pixels"), ValueError, "one of 'rgb'"),
        (lambda: parallel_env("pong", max_cycles=0), ValueError, "max_cycles"),
        (lambda: parallel_env("pong", render_mode="ansi"), ValueError, "render_mode"),
        (lambda: parallel_env("tennis", parameters={"turn": 1}), ValueError, "this game has: max_turn_time"),
        *((partial(parallel_env, "boxing", **options), error, words) for options, error, words in BOXING),
        (lambda: MultiplayerCore("pong", repeat_action_probability=[0.1]), ValueError, "one for each of 2 players"),
        (lambda: MultiplayerCore("pong", repeat_action_probability=[0.1, 2]), ValueError, r"probability\[1\] must be"),
        (lambda: MultiplayerCore("pong", repeat_action_probability="0.1"), TypeError, "must be a number"),
        (lambda: MultiplayerCore("pong", corrected_scores=1), TypeError, "must be True or False"),
        (lambda: MultiplayerEnv("pong", zero_sum="yes"), TypeError, "zero_sum must be True or False"),
        (lambda: MultiplayerEnv("pong", action_sets=[["NOOP"]]), ValueError, "must have 2 lists"),
        (lambda: MultiplayerEnv("pong", action_sets=["UP", "DOWN"]), TypeError, "list of names for each agent"),
        (lambda: MultiplayerEnv("pong", action_sets=[["UP"], []]), ValueError, "second_0 must have one action"),
        (lambda: MultiplayerEnv("pong", action_sets=[["UP"], ["UPP"]]), ValueError, "must be one of 'NOOP'"),
        (lambda: MultiplayerEnv("pong", action_sets={"first_0": ["UP"]}), ValueError, "first_0, second_0"),
        (
            lambda: MultiplayerEnv("pong", action_sets=[["UP"]] * 2, full_action_space=True),
            ValueError,
            "not both",
        ),
    ],
)
def test_a_wrong_option_is_one_sentence(make: Callable[[], Any], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        make()
