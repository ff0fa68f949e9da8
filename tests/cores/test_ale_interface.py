"""`env.unwrapped.ale`: a core under the names of ale-py's `ALEInterface`, and the wrappers that rely on it."""

from __future__ import annotations  # the classes of ale-py 0.8.1 have other names

import copy
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import ale_py.env
import cv2
import gymnasium
import numpy as np
import pytest
from env_tools import needs_new_ale_py
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.wrappers import AtariPreprocessing

import atari.ale_py
from atari import Action, AtariEnv
from atari.cores.ale_interface import AleInterface

pytestmark = needs_new_ale_py


Pair = tuple[AtariEnv, Any]


def make_pair() -> Pair:
    """The same state of the same game, in our core and in ale-py."""
    ours, theirs = AtariEnv("seaquest", sound_obs=True), ale_py.env.AtariEnv("seaquest", sound_obs=True)
    for env in (ours, theirs):
        env.reset(seed=1)
        for action in (1, 2, 3, 4) * 5:
            env.step(action)
    return ours, theirs


@pytest.fixture(scope="module")
def pair() -> Pair:
    return make_pair()


FACTS = "lives game_over game_truncated getFrameNumber getEpisodeFrameNumber getRAMSize getScreenDims".split()


@pytest.mark.parametrize("method", [*FACTS, "getAvailableModes", "getAvailableDifficulties"])
def test_facts_are_those_of_ale_py(pair: Pair, method: str) -> None:
    ours, theirs = (getattr(env.ale, method)() for env in pair)
    assert ours == theirs
    assert type(ours) is type(theirs)


@pytest.mark.parametrize("method", ["getRAM", "getScreen", "getScreenRGB", "getScreenGrayscale", "getAudio"])
def test_arrays_are_those_of_ale_py(pair: Pair, method: str) -> None:
    ours, theirs = (getattr(env.ale, method)() for env in pair)
    assert np.array_equal(ours, theirs)
    buffer = np.zeros_like(ours)
    getattr(pair[0].ale, method)(buffer)
    assert np.array_equal(buffer, theirs)


@pytest.mark.parametrize("method", ["getMinimalActionSet", "getLegalActionSet"])
def test_action_sets_are_those_of_ale_py(pair: Pair, method: str) -> None:
    ours, theirs = (getattr(env.ale, method)() for env in pair)
    assert [(action.name, action.value) for action in ours] == [(action.name, action.value) for action in theirs]
    assert {type(action) for action in ours} == {atari.ale_py.Action}


def test_every_public_method_of_ale_py_is_there() -> None:
    names = {name for name in dir(ale_py.ALEInterface) if not name.startswith("_")}
    assert names - set(dir(AleInterface)) == set()


def test_ale_pys_actions_are_taken() -> None:
    for core in ("native", "ale"):
        env = AtariEnv("breakout", core=core)
        env.reset(seed=0)
        assert env.ale.act(ale_py.Action.FIRE) == 0
        assert env.ale.act(Action.FIRE, paddle_strength=0.5) == 0


def test_settings_are_those_of_ale_py(pair: Pair) -> None:
    for get, names in {
        "getInt": ("random_seed", "frame_skip", "max_num_frames_per_episode"),
        "getFloat": ("repeat_action_probability",),
        "getBool": ("color_averaging", "sound_obs", "sound", "display_screen"),
        "getString": ("record_screen_dir", "record_sound_filename"),
    }.items():
        for name in names:
            ours, theirs = (getattr(env.ale, get)(name) for env in pair)
            assert (ours, type(ours)) == (theirs, type(theirs)), name


def test_settings_apply_when_the_game_is_loaded() -> None:
    """With the seed of the reset, or by `load_game`; pickling keeps both what applies and what waits."""
    ours, _ = pair = make_pair()

    def same(*envs: Any) -> bool:
        steps = [[env.step(action) for action in (1, 2, 5) * 5] for env in envs]
        return all(data_equivalence(steps[0], others) for others in steps[1:])

    for env in pair:
        env.ale.setFloat("repeat_action_probability", 0.75)
        env.ale.setInt("frame_skip", 2)
        env.ale.setInt("max_num_frames_per_episode", 100)
        env.ale.setBool("color_averaging", True)
        env.reset()
    assert same(*pair, pickle.loads(pickle.dumps(ours)))
    assert ours.core.episode_frame_number == 60
    for env in pair:
        env.reset(seed=5)
    assert same(*pair, pickle.loads(pickle.dumps(ours)))
    assert ours.core.truncated
    for env in pair:
        env.ale.setInt("random_seed", 77)
        env.ale.loadROM(ale_py.roms.get_rom_path("seaquest"))
        env.ale.reset_game()
    assert same(*pair)


def test_modes_and_difficulties_are_set_as_in_ale_py() -> None:
    cores = ("native", "ale")
    envs = [*(AtariEnv("breakout", core=core) for core in cores), ale_py.env.AtariEnv("breakout")]
    for env in envs:
        env.reset(seed=1)
        env.step(1)
        env.ale.setMode(8)
        env.ale.setDifficulty(1)
    saved = [env.snapshot() for env in envs[:-1]]
    for reset in ({}, {}, {"seed": 3}):  # the seeded one loads the game, with the mode of the options
        for action in (1, 2, 3) * 10:
            *results, expected = (env.step(action) for env in envs)
            assert all(data_equivalence(result, expected) for result in results)
        *results, expected = (env.reset(**reset) for env in envs)
        assert all(data_equivalence(result, expected) for result in results)
    for core, data in zip(cores, saved, strict=True):
        with pytest.raises(ValueError, match="with mode = 8, but this environment has 0; difficulty = 1, not 0"):
            AtariEnv("breakout", core=core).restore(data)
        again = AtariEnv("breakout", mode=8, difficulty=1, core=core)
        again.restore(data)
        state = again.clone_state()
        assert (state.getDifficulty(), state.getCurrentMode()) == (1, 8)


@pytest.mark.parametrize(
    ("use", "error", "text"),
    [
        (lambda ale: ale.setMode(99), RuntimeError, "breakout has no mode 99; it has 0, 4"),
        (lambda ale: ale.setDifficulty(7), RuntimeError, "breakout has no difficulty 7; it has 0, 1"),
        (
            lambda ale: ale.setInt("nope", 1),
            RuntimeError,
            "there is no int setting 'nope'; there are random_seed, frame",
        ),
        (lambda ale: ale.setFloat("frame_skip", 1.0), RuntimeError, "there is no float setting 'frame_skip'"),
        (lambda ale: ale.getInt("nope"), RuntimeError, "there is no int setting 'nope'"),
        (lambda ale: ale.setInt("frame_skip", 0), ValueError, "frame_skip must be within 1..10000, got 0"),
        (lambda ale: ale.setInt("frame_skip", 2**40), ValueError, "frame_skip must be within"),
        (lambda ale: ale.setFloat("repeat_action_probability", 2.0), ValueError, "must be within 0..1, got 2.0"),
        (lambda ale: ale.setBool("sound_obs", 1), TypeError, "sound_obs must be a bool, got 1"),
        (lambda ale: ale.setBool("display_screen", True), RuntimeError, "use render_mode='human' instead"),
        (lambda ale: ale.setString("record_screen_dir", "x"), RuntimeError, "use atari.recording instead"),
        (lambda ale: ale.loadROM("nowhere.bin"), RuntimeError, "there is no file nowhere.bin"),
        (lambda ale: ale.loadROM(ale_py.roms.get_rom_path("pong")), RuntimeError, "is not a ROM file of breakout"),
        (lambda ale: ale.isSupportedROM("nowhere.bin"), RuntimeError, "there is no file nowhere.bin"),
        (lambda ale: ale.saveScreenPNG("nowhere/screen.png"), OSError, "nowhere"),
        (lambda ale: ale.restoreState(b""), TypeError, "restore_state takes what clone_state returned, got bytes"),
    ],
)
def test_wrong_values_raise_and_change_nothing(use: Callable[[Any], Any], error: type[Exception], text: str) -> None:
    env = AtariEnv("breakout")
    env.reset(seed=0)
    before = env.snapshot()
    with pytest.raises(error) as caught:
        use(env.ale)
    assert text in str(caught.value)
    assert env.snapshot() == before
    assert not env.ale_settings.stale


def test_settings_that_are_not_supported_can_be_set_to_their_default() -> None:
    ale = AtariEnv("pong").ale
    ale.setBool("display_screen", False)
    ale.setBool("sound", False)
    ale.setString("record_screen_dir", "")
    ale.setLoggerMode(ale_py.LoggerMode.Error)


def test_roms_are_recognised(tmp_path: Path) -> None:
    other = tmp_path / "other.bin"
    other.write_bytes(b"x" * 4096)
    for kind in (AleInterface, ale_py.ALEInterface):
        assert kind.isSupportedROM(ale_py.roms.get_rom_path("pong")) == "pong"
        assert kind.isSupportedROM(str(other)) is None


def test_the_screen_is_written_as_ale_py_writes_it(pair: Pair, tmp_path: Path) -> None:
    for env, name in zip(pair, ("ours.png", "theirs.png"), strict=True):
        env.ale.saveScreenPNG(str(tmp_path / name))
    ours, theirs = (cv2.imread(str(tmp_path / name)) for name in ("ours.png", "theirs.png"))
    assert np.array_equal(ours, theirs)


@pytest.mark.parametrize("core", ["native", "plain", "ale"])
@pytest.mark.parametrize(
    ("clone", "restore"), [("cloneState", "restoreState"), ("cloneSystemState", "restoreSystemState")]
)
def test_states_compare_are_copied_and_pickled(core: str, clone: str, restore: str) -> None:
    env = AtariEnv("breakout", core=core)
    env.reset(seed=1)
    env.step(1)
    state = getattr(env.ale, clone)()
    for name in ("getFrameNumber", "getEpisodeFrameNumber", "getCurrentMode", "getDifficulty"):
        assert getattr(state, name)() == (4 if "Frame" in name else 0)
    ram = env.core.ram()
    for _ in range(40):
        env.step(3)
    assert getattr(env.ale, clone)() != state
    copies = [state, copy.copy(state), copy.deepcopy(state), pickle.loads(pickle.dumps(state))]
    for copied in (*copies, type(state)(state.serialize())):
        assert copied == state
        assert copied.equals(state)
        assert copied.getFrameNumber() == 4
        env.step(2)
        getattr(env.ale, restore)(copied)
        assert np.array_equal(env.core.ram(), ram)
        assert getattr(env.ale, clone)() == state
    assert state != 3
    with pytest.raises(TypeError, match="unhashable"):
        hash(state)


@pytest.mark.parametrize("core", ["native", "plain"])
def test_a_pickled_state_has_the_generator_only_if_it_was_included(core: str) -> None:
    env = AtariEnv("breakout", core=core, repeat_action_probability=0.5)
    env.reset(seed=1)

    def play() -> list[bytes]:
        return [env.core.ram().tobytes() for action in (1, 2, 3) * 20 if env.step(action)]

    without, including = (pickle.loads(pickle.dumps(env.clone_state(include_rng=include))) for include in (False, True))
    assert without != including
    first = play()
    env.restore_state(without)
    assert play() != first
    env.restore_state(including)
    assert play() == first


def test_bytes_that_are_no_state_are_refused() -> None:
    env = AtariEnv("breakout")
    env.reset(seed=1)
    kind, good = type(env.clone_state()), env.clone_state().serialize()
    for bad, text in (
        (b"", "truncated"),
        (bytes(len(good)), "are not a state"),
        (good[:8] + b"\xff" + good[9:], "version"),
    ):
        with pytest.raises(ValueError, match=text):
            kind(bad)
    before = env.snapshot()
    for bad in (good[:-1], good[:24] + b"\xff" * (len(good) - 24), good[:16] + bytes(8) + good[24:]):
        with pytest.raises(ValueError, match="of another game than this core"):
            env.restore_state(kind(bad))
    with pytest.raises(ValueError, match="of another game than this core"):
        AtariEnv("pong").restore_state(kind(good))
    assert env.snapshot() == before


def test_after_a_reset_through_ale_the_game_goes_on_without_a_warning(recwarn: pytest.WarningsRecorder) -> None:
    env = AtariEnv("pong", max_num_frames_per_episode=8)
    env.reset(seed=0)
    for _ in range(5):
        env.step(0)
        if env.ale.game_over():
            env.ale.reset_game()
    assert not recwarn.list
    assert env.ale.getFrameNumber() == 20


def test_acts_and_pokes_reach_the_core() -> None:
    env = AtariEnv("breakout", repeat_action_probability=0.0)
    env.reset(seed=0)
    env.ale.setRAM(0x4D, 0x07)
    assert env.ale.act(0) == 7
    assert env.core.frame_number == 1
    env.ale.reset_game()
    assert env.core.episode_frame_number == 0


def test_game_over_counts_truncation_unless_disabled() -> None:
    env = AtariEnv("pong", max_num_frames_per_episode=4)
    env.reset(seed=0)
    env.step(0)
    assert env.ale.game_over() is True
    assert env.ale.game_over(with_truncation=False) is False


def test_wrong_calls_raise_as_on_the_core() -> None:
    env = AtariEnv("pong")
    with pytest.raises(ValueError, match=r"an ALE action number is within 0\.\.17, got 99"):
        env.ale.act(99)
    with pytest.raises(ValueError, match=r"index must be within 0\.\.127, got 128"):
        env.ale.setRAM(128, 0)


@pytest.mark.parametrize("game", ["pong", "breakout", "space_invaders"])
def test_gymnasiums_preprocessing_gives_what_it_gives_on_ale_py(game: str) -> None:
    ours, theirs = AtariEnv(game, frameskip=1), ale_py.env.AtariEnv(game, frameskip=1)
    first, second = (AtariPreprocessing(env, terminal_on_life_loss=True) for env in (ours, theirs))
    assert np.array_equal(first.reset(seed=2)[0], second.reset(seed=2)[0])
    rng = np.random.default_rng(0)
    for _ in range(100):
        action = int(rng.integers(len(ours.get_action_meanings())))
        mine, other = first.step(action), second.step(action)
        assert np.array_equal(mine[0], other[0])
        assert mine[1:] == other[1:]
        if mine[2] or mine[3]:
            assert np.array_equal(first.reset()[0], second.reset()[0])


def test_gymnasiums_preprocessing_still_refuses_a_double_frame_skip() -> None:
    with pytest.raises(ValueError, match="Disable frame-skipping in the original env"):
        AtariPreprocessing(gymnasium.make("ALE/Pong-v5"))
