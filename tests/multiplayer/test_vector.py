"""`AtariVectorEnv` with several players beside games played one by one, with the preprocessing in NumPy and OpenCV."""

import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest
from multiplayer.reference import Reference

from atari import AtariVectorEnv

GAMES = [
    ("pong", 2, {}),
    ("pong", 4, {"mode": 33}),
    ("joust", 2, {"repeat_action_probability": 0.25}),
    ("warlords", 4, {"repeat_action_probability": 0.25}),
    ("combat", 2, {"mode": 8, "difficulty": 3}),
    ("blackjack", 2, {}),
    ("wizard_of_wor", 2, {}),
    ("maze_craze", 2, {}),
    ("flag_capture", 2, {}),
    ("joust", 2, {"preset": "multiplayer_dqn"}),
    ("warlords", 4, {"preset": "multiplayer_dqn"}),
]


def moves(rng: np.random.Generator, envs: AtariVectorEnv) -> Any:
    return rng.integers(envs.single_action_space.nvec[0], size=(envs.num_envs, len(envs.single_action_space.nvec)))


def check(envs: AtariVectorEnv, games: list[Reference], results: Any) -> None:
    observation, rewards, terminations, truncations, info = results
    for row, game in enumerate(games):
        assert np.array_equal(observation["ram"][row], game.core.ram())
        assert np.array_equal(observation["image"][row], game.stack)
        assert rewards[row].tolist() == game.signals[0].tolist()
        assert terminations[row].tolist() == game.signals[1].tolist()
        assert truncations[row].tolist() == game.signals[2].tolist()
        assert info["lives"][row].tolist() == game.core.player_lives
        assert info["frame_number"][row] == game.core.frame_number


@pytest.mark.parametrize(("game", "players", "options"), GAMES)
def test_a_vector_equals_games_played_one_by_one(game: str, players: int, options: dict[str, Any]) -> None:
    """The preset limits the frames after the beginning; without it, the frames of a reset count, too."""
    limit = {"max_frames" if "preset" in options else "max_num_frames_per_episode": 300}
    envs = AtariVectorEnv(game, 2, players=players, obs_type="dict", full_action_space=True, **limit, **options)
    played = {name: value for name, value in options.items() if name != "preset"}
    games = [Reference(game, players, 300, full=True, fill="preset" in options, **played) for _ in range(2)]
    observation, info = envs.reset(seed=5)
    for row, one in enumerate(games):
        one.reset(5 + row)
    check(envs, games, (observation, *games_signals(games), info))
    for step in range(200):
        actions = np.random.default_rng(step // 3).integers(18, size=(2, players))
        results = envs.step(actions)
        for row, one in enumerate(games):
            if one.ended:
                one.reset()
            else:
                one.step(actions[row])
        check(envs, games, results)
    assert games[0].core.frame_number > 500


def games_signals(games: list[Reference]) -> Any:
    return tuple(np.array(part) for part in zip(*(game.signals for game in games), strict=True))


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_players_are_out_one_by_one_in_every_autoreset_mode(mode: str) -> None:
    envs = AtariVectorEnv("warlords", 2, players=4, obs_type="ram", autoreset_mode=mode)
    games = [Reference("warlords", 4, images=False) for _ in range(2)]
    envs.reset(seed=1)
    for row, one in enumerate(games):
        one.reset(1 + row)
    rng = np.random.default_rng(2)
    seen: set[int] = set()
    ended = 0
    for _ in range(1800):
        actions = moves(rng, envs)
        ram, rewards, terminations, truncations, info = envs.step(actions)
        ends = []
        for row, one in enumerate(games):
            if not one.ended:
                one.step(actions[row])
            elif mode == "NextStep":
                one.reset()
            else:
                one.signals = np.zeros(4), *one.signals[1:]
            ends.append(one.ended)
            assert rewards[row].tolist() == one.signals[0].tolist()
            assert terminations[row].tolist() == one.signals[1].tolist()
            assert truncations[row].tolist() == one.signals[2].tolist()
            seen.add(int(one.out.sum()))
            ended += one.ended
            if mode == "SameStep" and one.ended:
                assert info["final_obs"][row].tolist() == one.core.ram().tolist()
                assert info["final_info"]["lives"][row].tolist() == one.core.player_lives
                assert info["final_info"]["episode"]["r"][row].sum() != 0
                one.reset()
            assert np.array_equal(ram[row], one.core.ram())
        if mode == "SameStep":
            assert ("final_obs" in info) == any(ends)
            assert not any(ends) or info["_final_obs"].tolist() == ends
        if mode == "Disabled" and all(ends):
            envs.reset(options={"reset_mask": np.array(ends)})
            for one in games:
                one.reset()
    assert {0, 1, 2} <= seen
    assert ended


def test_players_who_are_out_take_the_first_action_of_the_task() -> None:
    """Which moves them here; the single environment has its own list of these actions."""
    from atari.multiplayer import MultiplayerEnv

    options: dict[str, Any] = {
        "players": 4,
        "obs_type": "ram",
        "frameskip": 4,
        "actions": ("RIGHT", "NOOP", "FIRE", "LEFT"),
    }
    envs, game = AtariVectorEnv("warlords", 1, **options), MultiplayerEnv("warlords", **options)
    envs.reset(seed=1)
    game.reset(seed=1)
    rng, after = np.random.default_rng(2), 0
    while game.agents and after < 100:
        actions = rng.integers(4, size=4)
        ram = envs.step(actions[np.newaxis])[0]
        game.step(dict(zip(game.possible_agents, actions.tolist(), strict=True)))
        assert ram[0].tolist() == game.core.ram().tolist()
        after += len(game.agents) < 4
    assert after == 100


def test_numbers_of_threads_and_batches_make_no_difference() -> None:
    steps = [(i, 4 * step) for i in range(4) for step in range(1, 40)]
    played = []
    for options in ({"num_threads": 1}, {"num_threads": 3}, {"num_threads": 2, "batch_size": 2}):
        envs = AtariVectorEnv("pong", 4, players=4, repeat_action_probability=0.1, **options)
        seen: dict[tuple[int, int], Any] = {}
        _, info = envs.reset(seed=3)
        first = info["frame_number"][0]
        while any(step not in seen for step in steps):  # a batch has the environments that end their step first
            numbers = list(zip(info["env_id"].tolist(), (info["frame_number"] - first).tolist(), strict=True))
            actions = [[(frame // 16 * 7 + i * 3 + player) % 6 for player in range(4)] for i, frame in numbers]
            observation, rewards, *_, info = envs.step(np.array(actions))
            for row, i in enumerate(info["env_id"].tolist()):
                seen[i, int(info["frame_number"][row] - first)] = observation[row].tobytes(), rewards[row].tolist()
        played.append(seen)
    for seen in played[1:]:
        assert [seen[step] for step in steps] == [played[0][step] for step in steps]


def test_some_environments_alone_are_stepped() -> None:
    envs = AtariVectorEnv("pong", 4, players=2, obs_type="ram")
    envs.reset(seed=1)
    games = [Reference("pong", 2) for _ in range(4)]
    for row, one in enumerate(games):
        one.reset(1 + row)
    order = np.array([2, 0])
    for actions in ([[2, 3], [3, 2]], [[3, 3], [2, 2]]):
        ram, rewards, *_ = envs.step(np.array(actions), env_id=order)
        assert rewards.shape == (2, 2)
        for row, environment in enumerate(order):
            games[environment].step(actions[row])
            assert np.array_equal(ram[row], games[environment].core.ram())


def test_a_fork_has_the_state_of_the_game() -> None:
    envs = AtariVectorEnv("warlords", 2, players=4, obs_type="dict")
    envs.reset(seed=4)
    rng = np.random.default_rng(1)
    while not envs.step(moves(rng, envs))[2].any():
        pass
    envs.fork(0, [1])
    observation, _ = envs.observe()
    assert np.array_equal(observation["ram"][0], observation["ram"][1])


def test_snapshots_of_another_number_of_players_are_refused_and_change_nothing() -> None:
    vectors = [AtariVectorEnv("pong", 2, players=players) for players in (None, 2, 4)]
    for seed, envs in enumerate(vectors):
        envs.reset(seed=seed)
        for _ in range(5):
            envs.step(envs.action_space.sample())
    for envs in vectors:
        before = pickle.dumps(envs.snapshot())
        for other in vectors:
            if other is envs:
                continue
            states = other.snapshot()
            for refused in (states, pickle.loads(pickle.dumps(states)), [envs.snapshot()[0], states[1]]):
                with pytest.raises(ValueError, match=r"environment \d cannot .* players = \d, not \d"):
                    envs.restore(None, refused)
                assert pickle.dumps(envs.snapshot()) == before


def test_a_snapshot_of_another_mode_is_refused() -> None:
    envs, other = AtariVectorEnv("pong", 1, players=2, mode=3), AtariVectorEnv("pong", 1, players=2, mode=10)
    for one in (envs, other):
        one.reset(seed=3)
    before = envs.ram()
    with pytest.raises(ValueError, match="with mode = 10, but this environment has 3; restore it into"):
        envs.restore(None, other.snapshot())
    assert np.array_equal(envs.ram(), before)


def test_an_indicator_of_the_player_is_that_of_supersuit() -> None:
    plain = AtariVectorEnv("pong", 2, players=2)
    shown = AtariVectorEnv("pong", 2, players=2, agent_indicator=True)
    last = AtariVectorEnv("pong", 2, players=2, agent_indicator=True, channels_last=True)
    one, two, three = (envs.reset(seed=1)[0] for envs in (plain, shown, last))
    assert two.shape == (2, 2, 6, 84, 84) == shown.observation_space.shape
    assert three.shape == (2, 2, 84, 84, 6) == last.observation_space.shape
    assert np.array_equal(np.moveaxis(three, -1, 2), two)
    for player in range(2):
        assert np.array_equal(two[:, player, :4], one)
        assert (two[:, player, 4 + player] == 255).all()
        assert (two[:, player, 5 - player] == 0).all()
    ram = AtariVectorEnv("pong", 1, players=4, agent_indicator=True, obs_type="ram").reset(seed=1)[0]
    assert ram[0, :, 128:].tolist() == (255 * np.eye(4, dtype=int)).tolist()
    rgb = AtariVectorEnv("pong", 1, players=2, grayscale=False, agent_indicator=True, channels_last=True)
    assert rgb.reset(seed=1)[0].shape == (1, 2, 84, 84, 14)
    supersuit = pytest.importorskip("supersuit.utils.agent_indicator")
    space = gymnasium.spaces.Box(0, 255, (84, 84, 4), np.uint8)
    theirs = supersuit.change_observation(np.moveaxis(one[0], 0, -1), space, (1, 2))
    assert np.array_equal(theirs, three[0, 1])


def test_all_other_options_are_as_with_one_player() -> None:
    envs = AtariVectorEnv("pong", 2, players=2, noop_max=10, frameskip=(2, 5), clip_reward=True, stack_num=2)
    first, info = envs.reset(seed=1)
    assert first.shape == (2, 2, 84, 84)
    assert info["episode_frame_number"].max() < 10
    assert envs.action_space == gymnasium.spaces.MultiDiscrete([[6, 6]] * 2)
    assert envs.single_action_space == gymnasium.spaces.MultiDiscrete([6, 6])
    out = np.zeros((2, 2, 84, 84), np.uint8)
    for _ in range(200):
        observation, rewards, terminations, truncations, _ = envs.step(envs.action_space.sample(), out=out)
        assert observation is out
        assert rewards.dtype == np.float64
        assert terminations.dtype == truncations.dtype == np.bool_
        assert set(rewards.ravel()) <= {-1.0, 0.0, 1.0}
    assert envs.lanes[0].player_lives == [0, 0]
    assert envs.get_attr("mode") == (4, 4)
    envs.set_attr("mode", 10)
    with pytest.raises(ValueError, match="pong has no mode 1; it has 3, 4,"):
        envs.set_attr("mode", 1)


def test_games_may_differ() -> None:
    envs = AtariVectorEnv(["pong", "joust"], players=2, obs_type="ram")
    _, info = envs.reset(seed=1)
    assert info["action_mask"].sum(1).tolist() == [6, 18]
    assert envs.step(np.full((2, 2), 17))[1].shape == (2, 2)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"game": "breakout"}, "breakout has no rules for several players; these games have: atlantis"),
        ({"players": 3}, "pong is for 2 or 4 players, got players=3"),
        ({"players": 5}, "players must be within 1..4, got 5"),
        ({"players": 2.0}, "players must be an integer within 1..4, got 2.0"),
        ({"mode": 33}, "mode of pong for 2 players must be one of 3, 4, "),
        ({"game": "joust", "difficulty": 1}, r"difficulty of joust must be one of \(0,\), got 1"),
        ({"preset": "dqn2015"}, "preset 'dqn2015' is for one player; use 'multiplayer_dqn'"),
        ({"continuous": True}, "continuous=True is for one player; leave it or players=2 out"),
        ({"use_fire_reset": True}, "fire='before_noops' is for one player; leave it or players=2 out"),
        ({"players": 1, "agent_indicator": True}, "has no effect, because one player plays; add players=2"),
        ({"agent_indicator": True, "grayscale": False}, "which RGB images have last; add channels_last=True"),
        ({"game": "warlords", "players": None}, "is a two-player cartridge without single-player rules"),
    ],
)
def test_wrong_options_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(TypeError if "must be an integer" in message else ValueError, match=message):
        AtariVectorEnv(**{"game": "pong", "num_envs": 2, "players": 2, **options})


@pytest.mark.parametrize(
    ("actions", "error", "message"),
    [
        ([0, 1], ValueError, r"actions must have the shape \(2, 2\), got \(2,\)"),
        ([[0, 1, 2], [0, 1, 2]], ValueError, r"actions must have the shape \(2, 2\), got \(2, 3\)"),
        ([[0, 1], [0, 6]], ValueError, r"action 6 in row 1 is not within 0..5"),
        ([[0, -1], [0, 1]], ValueError, r"action -1 in row 0 is not within 0..5"),
        ([[0.0, 1.0], [0.0, 1.0]], TypeError, r"actions must be integers of shape \(2, 2\), got float64"),
    ],
)
def test_wrong_actions_are_refused_and_nothing_is_played(actions: Any, error: type[Exception], message: str) -> None:
    envs = AtariVectorEnv("pong", 2, players=2, obs_type="ram")
    _, info = envs.reset(seed=1)
    with pytest.raises(error, match=message):
        envs.step(actions)
    assert envs.observe()[1]["frame_number"].tolist() == info["frame_number"].tolist()
    envs.step(np.zeros((2, 2), np.int32))
