"""`AtariEnv`, except the equality with ale-py over all games, which `conformance/` tests."""

import inspect
import itertools
import pickle
from collections.abc import Callable
from typing import Any

import ale_py.env
import gymnasium
import numpy as np
import pytest
from env_tools import comparable, over, play, started, unchanged
from gymnasium.utils.env_checker import data_equivalence

import atari
from atari import Action, AtariEnv
from atari.task.observation_kinds import KINDS

# Options.


def test_options_and_defaults_are_those_of_ale_py() -> None:
    ours = inspect.signature(AtariEnv).parameters.values()
    theirs = inspect.signature(ale_py.env.AtariEnv).parameters.values()
    assert [option.name for option in ours if option.kind is option.POSITIONAL_OR_KEYWORD] == [
        option.name for option in theirs
    ]
    assert [option.name for option in ours if option.kind is option.KEYWORD_ONLY] == ["core", "rom", "interventions"]
    defaults = {option.name: option.default for option in theirs if option.name not in ("game", "render_mode")}
    for name, value in defaults.items():
        assert AtariEnv("breakout", **{name: value}).task == AtariEnv("breakout").task, name


@pytest.mark.parametrize(
    ("option", "value", "error", "text"),
    [
        ("game", "brekout", ValueError, "there is no game 'brekout'; did you mean 'breakout'?"),
        ("game", "combat", ValueError, "'combat' is a two-player cartridge without single-player rules"),
        ("game", None, TypeError, "a game is named by a string such as 'breakout', got None"),
        ("mode", 5, ValueError, "breakout has no mode 5; it has 0, 4, 8, 12, 16, 20, 24, 28, 32, 36, 40, 44"),
        ("mode", "4", TypeError, "mode must be an integer or None, got '4'"),
        ("difficulty", 3, ValueError, "breakout has no difficulty 3; it has 0, 1"),
        ("obs_type", "image", ValueError, f"obs_type must be one of {', '.join(map(repr, KINDS))}, got 'image'"),
        ("obs_type", ["rgb"], ValueError, f"obs_type must be one of {', '.join(map(repr, KINDS))}, got ['rgb']"),
        ("frame_skip", 4, TypeError, "AtariEnv has no option 'frame_skip'; did you mean 'frameskip'?"),
        ("frameskip", 0, ValueError, "frameskip must be within 1..10000, got 0"),
        ("frameskip", -4, ValueError, "frameskip must be within 1..10000, got -4"),
        ("frameskip", "4", TypeError, "frameskip must be an integer within 1..10000, got '4'"),
        ("frameskip", 4.0, TypeError, "frameskip must be an integer within 1..10000, got 4.0"),
        ("frameskip", True, TypeError, "frameskip must be an integer within 1..10000, got True"),
        ("frameskip", (3, 3), ValueError, "needs low < high, got (3, 3)"),
        ("frameskip", (5, 2), ValueError, "needs low < high, got (5, 2)"),
        ("frameskip", (0, 3), ValueError, "frameskip must be within 1..10000, got 0"),
        ("frameskip", (2,), ValueError, "a frameskip range is (low, high), got (2,)"),
        ("frameskip", (2, "5"), TypeError, "frameskip must be an integer within 1..10000, got '5'"),
        ("repeat_action_probability", -0.25, ValueError, "repeat_action_probability must be within 0..1, got -0.25"),
        ("repeat_action_probability", 1.5, ValueError, "repeat_action_probability must be within 0..1, got 1.5"),
        ("repeat_action_probability", float("nan"), TypeError, "must be a number within 0..1, got nan"),
        ("repeat_action_probability", 10**400, TypeError, "must be a number within 0..1, got 1000"),
        ("repeat_action_probability", "0.25", TypeError, "must be a number within 0..1, got '0.25'"),
        ("continuous_action_threshold", 1.5, ValueError, "continuous_action_threshold must be within 0..1, got 1.5"),
        ("continuous_action_threshold", None, TypeError, "must be a number within 0..1, got None"),
        ("max_num_frames_per_episode", -1, ValueError, "must be within 0..2147483647, got -1"),
        ("max_num_frames_per_episode", 99.5, TypeError, "must be an integer within 0..2147483647, got 99.5"),
        ("render_mode", "ansi", ValueError, "must be one of 'human', 'rgb_array', 'rgb_array_list', got 'ansi'"),
        ("core", "stella", ValueError, "core must be one of 'native', 'ale', 'plain', got 'stella'"),
        ("core", [], ValueError, "core must be one of 'native', 'ale', 'plain', got []"),
    ],
)
def test_a_wrong_option_is_refused(option: str, value: Any, error: type[Exception], text: str) -> None:
    with pytest.raises(error) as caught:
        AtariEnv(**{"game": "breakout", option: value})
    assert text in str(caught.value)


def test_the_core_is_within_reach() -> None:
    env = gymnasium.make("ALE/Pong-v5").unwrapped
    assert isinstance(env, AtariEnv)
    assert isinstance(env.core, atari.cores.NativeCore)
    assert env.core.game is env.game is atari.games["pong"]


# Observations, rewards, info.


@pytest.mark.parametrize(("obs_type", "shape"), [("rgb", (250, 160, 3)), ("grayscale", (250, 160)), ("ram", (128,))])
def test_observations_are_what_the_core_shows(obs_type: Any, shape: tuple[int, ...]) -> None:
    env = AtariEnv("adventure", obs_type=obs_type)
    observation, _ = env.reset(seed=0)
    shown = {"rgb": env.core.screen_rgb, "grayscale": env.core.screen_grayscale, "ram": env.core.ram}[obs_type]
    assert env.observation_space == gymnasium.spaces.Box(0, 255, shape, np.uint8)
    assert np.array_equal(observation, shown())
    observation, *_ = env.step(1)
    assert np.array_equal(observation, shown())


def test_sound_comes_beside_the_image() -> None:
    env = started("seaquest", sound_obs=True, obs_type="grayscale")
    observation, *_ = env.step(1)
    assert list(observation) == ["image", "sound"]
    assert np.array_equal(observation["image"], env.core.screen_grayscale())
    assert np.array_equal(observation["sound"], env.core.audio())
    assert observation["sound"].shape == (512,)
    assert observation in env.observation_space


def test_info_counts_lives_and_frames() -> None:
    env = AtariEnv("breakout", frameskip=3)
    _, info = env.reset(seed=1)
    assert {key: info[key] for key in info if key != "seeds"} == {
        "lives": 5,
        "episode_frame_number": 0,
        "frame_number": 0,
    }
    assert env.step(0)[4] == {"lives": 5, "episode_frame_number": 3, "frame_number": 3}
    assert env.reset()[1] == {"lives": 5, "episode_frame_number": 0, "frame_number": 3}
    assert env.reset(seed=1)[1]["frame_number"] == 0


def test_a_seeded_reset_reports_the_words_of_the_seed() -> None:
    info = AtariEnv("pong").reset(seed=5)[1]
    assert info["seeds"] == (16823399, 2940995229)
    assert all(type(word) is np.uint32 for word in info["seeds"])


def test_the_reward_is_the_float_sum_over_the_frames() -> None:
    env = started(repeat_action_probability=0.0)
    env.core.set_ram(0x4D, 0x12)
    reward = env.step(0)[1]
    assert (reward, type(reward)) == (12.0, float)


def test_the_end_of_the_game_is_terminated_not_truncated() -> None:
    env = started()
    env.core.set_ram(0x39, 0)
    assert env.step(0)[2:4] == (True, False)


def test_the_frame_limit_is_truncated_not_terminated() -> None:
    env = started(max_num_frames_per_episode=10)
    assert [env.step(0)[2:4] for _ in range(3)] == [(False, False), (False, False), (False, True)]
    assert env.core.episode_frame_number == 10


def test_no_limit_by_default() -> None:
    env = started("pong", frameskip=5000)
    assert env.step(0)[3] is False


def test_without_a_seed_no_two_environments_are_alike() -> None:
    first, second = AtariEnv("seaquest"), AtariEnv("seaquest")
    first.reset()
    second.reset()
    assert play(first, 300) != play(second, 300)  # after 80 steps one pair in some thousands is equal


@pytest.mark.parametrize("seed", [-1, 1.5, "1"])
def test_a_wrong_seed_is_refused(seed: Any) -> None:
    env = started()
    with unchanged(env), pytest.raises(gymnasium.error.Error, match="Seed must be"):
        env.reset(seed=seed)


@pytest.mark.parametrize("options", [{"any": "thing"}, {"noops": 3}, {"fire": True}, {"reset_mask": [True]}, ["noops"]])
def test_an_option_of_reset_without_effect_is_refused(options: Any) -> None:
    env = started()
    with unchanged(env), pytest.raises(TypeError, match="option"):
        env.reset(options=options)


@pytest.mark.parametrize("options", [{}, {"new_game": True}, {"fire": False}])
def test_options_of_reset_that_are_true_of_each_reset(options: dict[str, Any]) -> None:
    first, second = AtariEnv("pong"), AtariEnv("pong")
    assert np.array_equal(first.reset(seed=1, options=options)[0], second.reset(seed=1)[0])


def test_a_frameskip_range_is_drawn_each_step() -> None:
    env = started(frameskip=(2, 5))
    seen = []
    for _ in range(60):
        before = env.core.frame_number
        env.step(0)
        seen.append(env.core.frame_number - before)
    assert set(seen) == {2, 3, 4}


@pytest.mark.parametrize(
    ("game", "frameskip", "rate"),
    [("pong", 4, 15), ("pong", 1, 60), ("pong", (2, 5), 20), ("pacman", 4, 12), ("pong", 10_000, 1)],
)
def test_render_fps_is_the_rate_of_steps_rounded_to_an_int(game: str, frameskip: Any, rate: int) -> None:
    """`gymnasium.utils.play.play` refuses a float."""
    fps = AtariEnv(game, frameskip=frameskip).metadata["render_fps"]
    assert (fps, type(fps)) == (rate, int)


# Actions.


def test_the_actions_are_those_the_game_uses() -> None:
    env = AtariEnv("breakout")
    assert env.action_space == gymnasium.spaces.Discrete(4)
    assert env.get_action_meanings() == ["NOOP", "FIRE", "RIGHT", "LEFT"]


def test_full_action_space_is_all_that_are_legal() -> None:
    assert AtariEnv("breakout", full_action_space=True).get_action_meanings() == [Action(n).name for n in range(18)]
    assert AtariEnv("skiing", full_action_space=True).action_space == gymnasium.spaces.Discrete(9)


def test_keys_stand_for_actions() -> None:
    assert AtariEnv("pong").get_keys_to_action() == {
        ("e",): 0,
        (" ",): 1,
        ("d",): 2,
        ("a",): 3,
        ("d", " "): 4,
        ("a", " "): 5,
    }
    keys = AtariEnv("seaquest").get_keys_to_action()
    assert keys["w", "d", " "] == 14
    assert len(keys) == 18


def test_there_are_no_keys_for_continuous_actions() -> None:
    with pytest.raises(AttributeError, match="can't be provided for this Atari environment as `continuous=True`"):
        AtariEnv("pong", continuous=True).get_keys_to_action()


@pytest.mark.parametrize(
    ("action", "error", "text"),
    [
        (4, ValueError, "action 4 is not within 0..3 (breakout)"),
        (-1, ValueError, "action -1 is not within 0..3 (breakout)"),
        (2**70, ValueError, "is not within 0..3"),
        (1.0, TypeError, "an action is an integer within 0..3, got 1.0"),
        ("FIRE", TypeError, "an action is an integer within 0..3, got 'FIRE'"),
        (None, TypeError, "an action is an integer within 0..3, got None"),
        ([1], TypeError, "an action is an integer within 0..3, got [1]"),
        (np.array([1]), TypeError, "an action is an integer within 0..3"),
        (float("nan"), TypeError, "an action is an integer within 0..3, got nan"),
        (Action.RIGHT, TypeError, "an ALE action; pass env.unwrapped.get_action_meanings().index('RIGHT')"),
        ([0.5, 0.0, float("nan")], ValueError, "radius 0..1, angle -pi..pi, fire 0..1, got (0.5, 0.0, nan)"),
        ([1.5, 0.0, 0.0], ValueError, "got (1.5, 0.0, 0.0)"),
        ([-0.5, 0.0, 0.0], ValueError, "got (-0.5, 0.0, 0.0)"),
        ([0.5, 4.0, 0.0], ValueError, "got (0.5, 4.0, 0.0)"),
        ([0.5, 0.0, float("inf")], ValueError, "got (0.5, 0.0, inf)"),
        ([1e300, 0.0, 0.0], ValueError, "got (inf, 0.0, 0.0)"),
        ([0.5, 0.0], TypeError, "a continuous action is three floats (radius, angle, fire), got [0.5, 0.0]"),
        (np.zeros((3, 2)), TypeError, "a continuous action is three floats"),
        (["a", 0, 0], TypeError, "a continuous action is three floats"),
        (2, TypeError, "a continuous action is three floats (radius, angle, fire), got 2"),
        (None, TypeError, "a continuous action is three floats (radius, angle, fire), got None"),
    ],
)
def test_what_is_no_action_is_refused(action: Any, error: type[Exception], text: str) -> None:
    env = started(frameskip=(2, 5), continuous="0..3" not in text and not isinstance(action, Action))
    with unchanged(env), pytest.raises(error) as caught:
        env.step(action)
    assert text in str(caught.value)


@pytest.mark.parametrize("action", [2, np.int64(2), np.uint8(2), np.array(2)])
def test_an_action_is_any_kind_of_integer(action: Any) -> None:
    assert comparable(started().step(action)) == comparable(started().step(2))


@pytest.mark.parametrize(
    ("action", "number"),
    [
        ([0.0, 0.0, 0.0], Action.NOOP),
        ([0.0, 0.0, 1.0], Action.FIRE),
        ([1.0, 0.0, 0.0], Action.RIGHT),
        ([1.0, np.pi / 2, 0.0], Action.UP),
        ([1.0, np.pi, 0.0], Action.LEFT),
        ([1.0, -np.pi / 2, 0.0], Action.DOWN),
        ([1.0, np.pi / 4, 0.0], Action.UPRIGHT),
        ([1.0, -3 * np.pi / 4, 0.6], Action.DOWNLEFTFIRE),
        ([0.5, 0.0, 0.5], Action.NOOP),
        ([0.51, 0.0, 0.51], Action.RIGHTFIRE),
        ([0.7, np.pi / 4, 0.0], Action.NOOP),
    ],
)
def test_a_continuous_action_is_the_nearest_of_the_18(
    action: Any, number: Action, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The threshold is 0.5 for the horizontal, the vertical and the button."""
    env = started("breakout", continuous=True)
    played = spy(env, monkeypatch)
    env.step(np.array(action, np.float32))
    assert played == [(number, np.float32(action[0]))] * 4


def test_the_threshold_says_how_far_the_stick_must_go(monkeypatch: pytest.MonkeyPatch) -> None:
    env = started("breakout", continuous=True, continuous_action_threshold=0.1)
    played = spy(env, monkeypatch)
    env.step([0.2, 0.0, 0.2])
    assert [action for action, _ in played] == [Action.RIGHTFIRE] * 4


def spy(env: AtariEnv, monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, float]]:
    """Record the calls of the core instead of playing."""
    played: list[tuple[int, float]] = []

    def act(action: int, strength: float = 1.0) -> int:
        played.append((action, strength))
        return 0

    monkeypatch.setattr(env.core, "act", act)
    return played


# The order of calls.


def test_a_step_after_the_end_warns_once_and_does_nothing() -> None:
    env = over(started())
    frames = env.core.frame_number
    with pytest.warns(UserWarning, match=r"env\.step\(\) was called after the episode had ended") as warnings:
        results = [env.step(1) for _ in range(3)]
    assert len(warnings) == 1
    assert [(result[1], result[2], result[3]) for result in results] == [(0.0, True, False)] * 3
    assert env.core.frame_number == frames


def test_the_next_episode_warns_again() -> None:
    env = over(started())
    with pytest.warns(UserWarning, match="after the episode had ended"):
        env.step(0)
    env.reset()
    assert env.step(0)[2] is False
    over(env)
    with pytest.warns(UserWarning, match="after the episode had ended"):
        env.step(0)


def test_a_step_after_truncation_stays_truncated() -> None:
    env = started(max_num_frames_per_episode=4)
    env.step(0)
    with pytest.warns(UserWarning, match="after the episode had ended"):
        assert env.step(0)[1:4] == (0.0, False, True)


def test_closing_twice_is_fine_and_no_step_follows() -> None:
    env = started()
    env.close()
    env.close()
    with pytest.raises(RuntimeError, match="this core is closed; make a new one"):
        env.step(0)


@pytest.mark.parametrize(("sound", "cores"), [(False, ("native", "plain", "ale")), (True, ("native", "plain"))])
def test_a_reset_after_close_goes_on_as_in_ale_py(sound: bool, cores: tuple[str, ...]) -> None:
    """Generators and counters continue, as if nothing had been closed."""
    theirs = ale_py.env.AtariEnv("breakout", sound_obs=sound)
    envs = [*(AtariEnv("breakout", core=core, sound_obs=sound) for core in cores), theirs]

    def same(call: Callable[[Any], Any]) -> bool:
        *results, expected = (call(env) for env in envs)
        return all(data_equivalence(list(result), list(expected)) for result in results)

    for seed in (3, None, 4):
        assert same(lambda env, seed=seed: env.reset(seed=seed))
        for action in (1, 3, 2, 2) * 5:
            assert same(lambda env, action=action: env.step(action))
        for env in envs:
            env.close()
            env.close()


def test_the_seed_of_np_random_is_that_of_the_reset() -> None:
    ours, theirs = AtariEnv("pong"), ale_py.env.AtariEnv("pong")
    ours.reset(seed=42)
    theirs.reset(seed=42)
    assert ours.np_random_seed == theirs.np_random_seed == 42
    assert pickle.loads(pickle.dumps(ours)).np_random_seed == 42
    assert ours.np_random.random() == theirs.np_random.random()


def test_seed_game_and_load_game_are_those_of_ale_py() -> None:
    ours, theirs = AtariEnv("breakout", mode=4), ale_py.env.AtariEnv("breakout", mode=4)
    for env in (ours, theirs):
        env.reset(seed=1)
        env.step(1)
        env.ale.setMode(8)
    assert ours.seed_game(7) == theirs.seed_game(7)
    for env in (ours, theirs):
        env.load_game()
        env.ale.reset_game()
    for action in (1, 3, 2, 2) * 20:
        assert data_equivalence(ours.step(action), theirs.step(action))
    assert ours.ale.getFrameNumber() == theirs.ale.getFrameNumber()


def test_attributes_of_ale_pys_environment() -> None:
    ours, theirs = (kind("pong", continuous=True, sound_obs=True) for kind in (AtariEnv, ale_py.env.AtariEnv))
    for name in ("continuous", "continuous_action_threshold", "sound_obs", "render_mode"):
        assert getattr(ours, name) == getattr(theirs, name), name
    ours.reset(seed=1)
    theirs.reset(seed=1)
    assert data_equivalence(ours._get_obs(), theirs._get_obs())


def test_map_action_idx_is_that_of_ale_py() -> None:
    for stick in itertools.product((-1, 0, 1), (-1, 0, 1), (False, True)):
        ours, theirs = AtariEnv.map_action_idx(*stick), ale_py.env.AtariEnv.map_action_idx(*stick)
        assert (ours.name, ours.value) == (theirs.name, theirs.value)
    with pytest.raises(LookupError, match="positions are -1, 0 and 1, got 2, 0 and fire False"):
        AtariEnv.map_action_idx(2, 0, False)


_FRAMES: list[Any] = [0, 4.0, (5, 2), (0, 5), (1, 2, 3)]


@pytest.mark.parametrize(
    ("options", "error"),
    [
        *(({"frameskip": frames}, gymnasium.error.Error) for frames in _FRAMES),
        ({"obs_type": "pixels"}, gymnasium.error.Error),
        ({"render_mode": "text"}, gymnasium.error.Error),
        ({"mode": 99}, RuntimeError),
        ({"difficulty": 99}, RuntimeError),
    ],
)
def test_an_error_is_one_of_ale_pys_kind_too(options: dict[str, Any], error: type[Exception]) -> None:
    for kind, errors in ((AtariEnv, error), (ale_py.env.AtariEnv, error), (AtariEnv, (ValueError, TypeError))):
        with pytest.raises(errors):
            kind("pong", **options)
