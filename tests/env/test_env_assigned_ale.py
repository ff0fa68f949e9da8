"""`env.ale = an object`: reset, step and render play and read through it, as those of ale-py's environment."""

import copy
import pickle
from pathlib import Path
from typing import Any
from unittest import mock

import ale_py.env
import numpy as np
import pytest
from env_tools import AroundAle, data_equivalence, needs_new_ale_py
from gymnasium.wrappers import AtariPreprocessing

import atari
from atari import AtariEnv
from atari.cores import NativeCore
from atari.recording import RecordReplay, Replay

pytestmark = needs_new_ale_py


class Painted(AroundAle):
    """An `ale` in the form of HackAtari's: some methods are its own, and the interface in it has the others."""

    def getScreenRGB(self, *buffer: Any) -> Any:
        screen = self.inner.getScreenRGB(*buffer)
        screen[:50] = 255
        return screen

    def getScreenGrayscale(self, *buffer: Any) -> Any:
        screen = self.inner.getScreenGrayscale(*buffer)
        (buffer[0] if buffer else screen)[:50] = 255
        return screen

    def getRAM(self) -> Any:
        return self.inner.getRAM()[::-1]

    def getAudio(self) -> Any:
        return self.inner.getAudio() // 2

    def act(self, action: Any, strength: float = 1.0) -> int:
        return 10 * self.inner.act(action, strength)

    def lives(self) -> int:
        return 7

    def game_over(self, **arguments: Any) -> bool:
        return self.inner.getEpisodeFrameNumber() > 90 or self.inner.game_over(**arguments)

    def getFrameNumber(self) -> int:
        return 1_000 + self.inner.getFrameNumber()


class Calls(AroundAle):
    """An `ale` that notes which methods are called."""

    def __init__(self, ale: Any) -> None:
        super().__init__(ale)
        self.names: list[str] = []

    def __getattr__(self, name: str) -> Any:
        self.names.append(name)
        return super().__getattr__(name)


OPTIONS: list[dict[str, Any]] = [
    {},
    {"obs_type": "grayscale", "render_mode": "rgb_array"},
    {"obs_type": "ram", "frameskip": (2, 5)},
    {"sound_obs": True, "frameskip": 2},
    {"continuous": True, "full_action_space": True},
]


def pair(game: str = "seaquest", **options: Any) -> list[Any]:
    return [kind(game, **options) for kind in (AtariEnv, ale_py.env.AtariEnv)]


@pytest.mark.parametrize("options", OPTIONS)
def test_everything_is_read_through_it_as_in_ale_py(options: dict[str, Any]) -> None:
    ours, theirs = pair(**options)
    for env in (ours, theirs):
        env.ale = Painted(env.ale)
        env.action_space.seed(1)
    assert data_equivalence(ours.reset(seed=3), theirs.reset(seed=3))
    ends = 0
    for _ in range(80):
        mine = ours.step(ours.action_space.sample())
        assert data_equivalence(mine, theirs.step(theirs.action_space.sample()))
        if "render_mode" in options:
            assert np.array_equal(ours.render(), theirs.render())
        if mine[2]:
            ends += 1
            assert data_equivalence(ours.reset(), theirs.reset())
    assert ends


@pytest.mark.parametrize("options", OPTIONS)
def test_the_methods_that_are_called_are_those_that_ale_py_calls(options: dict[str, Any]) -> None:
    called = []
    for env in pair(**options):
        env.reset(seed=1)
        env.ale = calls = Calls(env.ale)
        env.reset()
        env.reset(seed=2)
        env.action_space.seed(1)
        env.step(env.action_space.sample())
        called.append(calls.names)
    assert called[0] == called[1]


def test_gymnasiums_preprocessing_reads_through_it() -> None:
    results = []
    for env in pair(frameskip=1):
        env.ale = Painted(env.ale)
        preprocessed = AtariPreprocessing(env, noop_max=0)
        results.append([preprocessed.reset(seed=1), *(preprocessed.step(action) for action in (1, 2, 3) * 5)])
    assert data_equivalence(*results)


def test_ours_refuses_what_it_would_not_show() -> None:
    env = atari.make("pong", preset="machado2018")
    env.unwrapped.ale = Painted(env.unwrapped.ale)
    with pytest.raises(ValueError, match=r"use gymnasium\.wrappers\.AtariPreprocessing, which reads through env\.ale"):
        env.reset(seed=0)


def test_a_mock_plays() -> None:
    env = AtariEnv("pong")
    env.reset(seed=0)
    env.ale = mock.MagicMock(wraps=env.ale)
    env.ale.getScreenRGB.return_value = np.full((210, 160, 3), 9, np.uint8)
    env.ale.lives.return_value = 2
    observation, _, _, _, info = env.step(0)
    assert (observation == 9).all()
    assert info == {"lives": 2, "episode_frame_number": 4, "frame_number": 4}
    assert env.ale.act.call_count == 4


def test_without_an_assignment_nothing_stands_before_the_core() -> None:
    env = AtariEnv("pong")
    assert type(env.core) is NativeCore
    env.ale = Painted(env.ale)
    assert type(env.core) is not NativeCore
    assert type(env.driver.emulated) is NativeCore


def test_an_attribute_that_would_have_no_effect_cannot_be_set() -> None:
    for env in pair():
        with pytest.raises(AttributeError):
            env.ale.getScreenRGB = None


def test_it_is_one_object() -> None:
    for env in pair():
        assert env.ale is env.ale
        painted = env.ale = Painted(env.ale)
        assert env.ale is painted


@pytest.mark.parametrize("core", ["native", "plain", "ale"])
def test_the_first_object_ends_it(core: str) -> None:
    env, plain = AtariEnv("seaquest", core=core), AtariEnv("seaquest", core=core)
    own = env.ale
    env.ale = Painted(own)
    for each in (env, plain):
        each.reset(seed=2)
        each.step(1)
    env.ale = own
    assert data_equivalence(env.step(2), plain.step(2))
    assert type(env.core) is type(plain.core)


def test_it_stays_over_loads_and_closing() -> None:
    env, plain = AtariEnv("seaquest", frameskip=1), AtariEnv("seaquest", frameskip=1)
    env.ale = Painted(env.ale)
    for each in (env, plain):
        each.reset(seed=2)
        each.ale.setFloat("repeat_action_probability", 0.5)
        each.reset(seed=4)
        each.close()
        each.reset()
    for action in (1, 2, 3) * 10:
        painted, shown = env.step(action)[0], plain.step(action)[0]
        assert (painted[:50] == 255).all()
        assert np.array_equal(painted[50:], shown[50:])


def test_snapshots_are_those_of_the_emulator() -> None:
    env, plain = AtariEnv("seaquest"), AtariEnv("seaquest")
    env.ale = Painted(env.ale)
    for each in (env, plain):
        each.reset(seed=2)
        each.step(1)
    saved = env.core.snapshot()
    assert saved == plain.core.snapshot()
    env.step(3)
    env.core.restore(saved)
    assert np.array_equal(env.ale.inner.getRAM(), plain.core.ram())
    state = env.clone_state()
    env.step(3)
    env.restore_state(state)
    assert np.array_equal(env.ale.inner.getRAM(), plain.core.ram())


@pytest.mark.parametrize("first", ["assigned", "recorded"])
def test_a_replay_records_the_emulator(first: str, tmp_path: Path) -> None:
    env = AtariEnv("seaquest", frameskip=1)
    own = env.ale
    if first == "assigned":
        env.ale = Painted(own)
    recorder = RecordReplay(env, tmp_path / "game.a26r")
    if first == "recorded":
        env.ale = Painted(own)
    recorder.reset(seed=1)
    for action in (1, 2, 3) * 20:
        recorder.step(action)
    own.setRAM(30, 5)
    recorder.step(0)
    recorder.stop()
    assert (env.step(0)[0][:50] == 255).all()
    replay = Replay.load(tmp_path / "game.a26r")
    assert replay.verify()
    assert replay.frames_total == 61


@pytest.mark.parametrize("duplicate", [copy.deepcopy, pickle.dumps])
def test_copies_are_refused(duplicate: Any) -> None:
    env = AtariEnv("pong")
    own = env.ale
    env.ale = Painted(own)
    with pytest.raises(TypeError, match=r"env\.ale was assigned"):
        duplicate(env)
    env.ale = own
    duplicate(env)


def test_a_game_reset_through_ale_plays_on() -> None:
    results = []
    for env in pair():
        env.ale.setInt("random_seed", 5)
        env.load_game()
        env.ale.reset_game()
        results.append([env.step(action) for action in (1, 2, 3) * 10])
        env.close()
    assert data_equivalence(*results)


def test_the_score_begins_anew_when_the_game_is_reset_through_ale() -> None:
    env = AtariEnv("breakout", repeat_action_probability=0.0)
    env.reset(seed=0)
    env.ale.setRAM(0x4D, 0x07)
    assert env.step(0)[1] == 7
    env.ale.reset_game()
    assert env.driver.played.score == 0


@pytest.mark.parametrize("ale", [5, {"act": 1}, object()])
def test_an_object_that_cannot_play_is_refused(ale: Any) -> None:
    env = AtariEnv("pong")
    env.reset(seed=0)
    own = env.ale
    with pytest.raises(TypeError, match="has no method act; wrap the former env"):
        env.ale = ale
    assert env.ale is own
    env.step(0)
