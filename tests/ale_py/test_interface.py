"""`atari.ale_py`: its names, and `ALEInterface` before a load and with wrong arguments."""

from __future__ import annotations  # the classes of ale-py 0.8.1 have other names

import gzip
import inspect
import pickle
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import ale_py
import gymnasium
import numpy as np
import pytest
from env_tools import needs_new_ale_py

import atari
import atari.ale_py
from atari.ale_py import ALEInterface, ALEState, LoggerMode, roms

pytestmark = needs_new_ale_py


def loaded(game: str = "breakout") -> ALEInterface:
    ale = ALEInterface()
    ale.setInt("random_seed", 1)
    ale.loadROM(roms.get_rom_path(game))
    ale.reset_game()
    return ale


@pytest.fixture(scope="module")
def both() -> tuple[ALEInterface, Any]:
    """Breakout in our interface and in ale-py's, for calls that change neither."""
    theirs = ale_py.ALEInterface()
    theirs.loadROM(roms.get_rom_path("breakout"))
    return loaded(), theirs


def test_the_names_are_those_of_ale_py() -> None:
    assert {*ale_py.__all__} - {*dir(atari.ale_py)} == set()
    assert {name for name in dir(ale_py.ALEInterface) if name[0] != "_"} <= {*dir(ALEInterface)}
    assert {name for name in dir(ale_py.ALEState) if name[0] != "_"} <= {*dir(ALEState)}
    for name in ("get_rom_path", "get_all_rom_ids"):
        ours, theirs = (inspect.signature(getattr(module.roms, name)) for module in (atari.ale_py, ale_py))
        assert list(ours.parameters) == list(theirs.parameters)
    assert [(mode.name, mode.value) for mode in LoggerMode] == [(mode.name, mode.value) for mode in ale_py.LoggerMode]
    assert atari.ale_py.AtariEnv is atari.AtariEnv
    assert atari.ale_py.AtariVectorEnv is atari.AtariVectorEnv
    assert atari.ale_py.SDL_SUPPORT is False


@pytest.mark.parametrize("name", ["Action", "LoggerMode"])
def test_the_members_of_enumerations_are_those_of_ale_py(name: str) -> None:
    ours, theirs = getattr(atari.ale_py, name), getattr(ale_py, name)
    assert len(ours) == len(theirs)
    for own, member in zip(ours, theirs, strict=True):
        for seen in (repr, str, bool, hash, lambda one: one.name, lambda one: one.value, lambda one: one == one.value):
            assert seen(own) == seen(member), member
        assert ours(member.value) is ours[member.name] is own is pickle.loads(pickle.dumps(own))
    for wrong in (40, 18, -1, "FIRE"):
        with pytest.raises(ValueError, match="is not a valid"):
            ours(wrong)


def test_every_action_can_be_played() -> None:
    """Also ours by ale-py."""
    ale, core = loaded(), atari.cores.NativeCore("breakout")
    theirs = ale_py.ALEInterface()
    theirs.loadROM(ale_py.roms.get_rom_path("breakout"))
    core.reset()
    for action in atari.ale_py.Action:
        assert theirs.act(action) == ale.act(action) == core.act(atari.Action[action.name]) == 0
    assert [*atari.Action] == [*range(18)]


def test_the_actions_that_are_returned_are_members_of_action() -> None:
    env = atari.AtariEnv("breakout")
    names = ["NOOP", "FIRE", "RIGHT", "LEFT"]
    wanted = [atari.ale_py.Action[name] for name in names]
    assert env.ale.getMinimalActionSet() == loaded().getMinimalActionSet() == env._action_set == wanted
    assert env.ale.getLegalActionSet() == list(atari.ale_py.Action)
    assert env.map_action_idx(1, 0, False) is atari.ale_py.Action.RIGHT


def test_the_raw_vector_equals_ale_pys() -> None:
    path, options = ale_py.roms.get_rom_path("breakout"), {"max_episode_steps": 90, "noop_max": 5}
    ours, theirs = (module.ALEVectorInterface(path, 2, 3, 2, 60, **options) for module in (atari.ale_py, ale_py))
    signature = inspect.signature(atari.ale_py.ALEVectorInterface)
    assert [str(one).replace("'", "") for one in signature.parameters][2:] == re.findall(
        r"(\w+):", ale_py.ALEVectorInterface.__init__.__doc__
    )[2:]
    assert ours.get_num_envs() == theirs.get_num_envs() == 2
    assert ours.get_observation_shape() == theirs.get_observation_shape() == (2, 60, 84)
    assert (ours.handle().dtype, ours.handle().shape) == (theirs.handle().dtype, theirs.handle().shape)
    first, wanted = ours.reset([0, 1], [3, 4]), theirs.reset([0, 1], [3, 4])
    assert np.array_equal(first[0], wanted[0])
    for step in range(60):
        for envs in (ours, theirs):
            envs.send([step % 4, 1], [1.0, 1.0])
        for own, their in zip(ours.recv()[:4], theirs.recv()[:4], strict=True):
            assert own.dtype == their.dtype
            assert np.array_equal(own, their)
    with pytest.raises(RuntimeError, match="is the ROM of no game of ale-py"):
        atari.ale_py.ALEVectorInterface(__file__, 1)


def test_ids_are_registered_again() -> None:
    from atari.ale_py.registration import rom_id_to_name

    ids = ["ALE/Pong-v5", "Pong-ram-v4", "Pong-v0"]
    kept = {env_id: gymnasium.registry.pop(env_id) for env_id in ids}
    atari.ale_py.register_v5_envs()
    assert [env_id in gymnasium.registry for env_id in ids] == [True, False, False]
    atari.ale_py.register_v0_v4_envs()
    assert {env_id: gymnasium.registry[env_id] for env_id in ids} == kept
    for rom in ("ms_pacman", "tic_tac_toe_3d", "pong"):
        assert rom_id_to_name(rom) == ale_py.registration.rom_id_to_name(rom)


def test_the_table_of_actions_by_motion_is_ale_pys() -> None:
    ours, theirs = (kind("pong", 1) for kind in (atari.AtariVectorEnv, ale_py.AtariVectorEnv))
    assert np.array_equal(ours.map_action_idx, theirs.map_action_idx)
    assert ours.is_xla_registered is theirs.is_xla_registered is False


def test_roms_are_those_of_ale_py() -> None:
    assert sorted(roms.get_all_rom_ids()) == sorted(ale_py.roms.get_all_rom_ids())
    for game in ("breakout", "combat"):
        assert roms.get_rom_path(game).read_bytes() == ale_py.roms.get_rom_path(game).read_bytes()
    for module in (roms, ale_py.roms):
        for name in ("Pong", "nope", 3):
            with pytest.warns(UserWarning, match=str(name)):
                assert module.get_rom_path(name) is None
    for kind in (ALEInterface, ale_py.ALEInterface):
        assert kind.isSupportedROM(roms.get_rom_path("combat")) is None


GAME_METHODS = """lives game_over game_truncated getRAM getScreen getScreenRGB getScreenGrayscale getScreenDims getAudio
    getMinimalActionSet getLegalActionSet getAvailableModes getAvailableDifficulties getFrameNumber getEpisodeFrameNumber
    cloneState cloneSystemState reset_game""".split()


def test_before_a_load_every_method_of_the_game_raises() -> None:
    """ale-py raises RuntimeError for three of them, and ends the process for others."""
    calls: list[tuple[Any, ...]] = [(name,) for name in GAME_METHODS]
    calls += [("act", 0), ("setMode", 0), ("setDifficulty", 0), ("setRAM", 0, 0)]
    for name, *arguments in [*calls, ("restoreState", loaded().cloneState()), ("saveScreenPNG", "screen.png")]:
        with pytest.raises(RuntimeError, match="no game is loaded; call loadROM first"):
            getattr(ALEInterface(), name)(*arguments)


def test_sizes_and_settings_need_no_game() -> None:
    ale = ALEInterface()
    assert (ale.getRAMSize(), ale.getAudioSize()) == (128, 512)
    for get, name in (
        ("getInt", "random_seed"),
        ("getInt", "frame_skip"),
        ("getInt", "max_num_frames_per_episode"),
        ("getFloat", "repeat_action_probability"),
        ("getBool", "color_averaging"),
        ("getString", "record_screen_dir"),
    ):
        assert getattr(ale, get)(name) == getattr(ale_py.ALEInterface(), get)(name)


def test_files_that_are_no_rom_are_refused_and_the_game_plays_on(tmp_path: Path) -> None:
    (tmp_path / "other.bin").write_bytes(bytes(range(256)) * 16)
    ale = loaded()
    before = ale.getRAM()
    with pytest.raises(RuntimeError, match=r"there is no file nowhere\.bin"):
        ale.loadROM("nowhere.bin")
    for file in (tmp_path / "other.bin", roms.get_rom_path("combat")):
        with pytest.raises(
            RuntimeError, match=r"is the ROM of no game of ale-py; `atari roms identify` says what it is"
        ):
            ale.loadROM(file)
    with pytest.raises(TypeError):
        ale.loadROM(3)
    assert np.array_equal(ale.getRAM(), before)
    assert ale.act(1) == 0


def test_a_rom_is_known_by_its_content(tmp_path: Path) -> None:
    image = roms.get_rom_path("breakout").read_bytes()
    (tmp_path / "pong.bin").write_bytes(image)
    (tmp_path / "game.bin.gz").write_bytes(gzip.compress(image))
    for name in ("pong.bin", "game.bin.gz"):
        ale = ALEInterface()
        ale.loadROM(tmp_path / name)
        ale.reset_game()
        assert ale.lives() == 5


def test_without_a_seed_each_load_draws_one() -> None:
    seen = set()
    for _ in range(4):
        ale = ALEInterface()
        ale.loadROM(roms.get_rom_path("breakout"))
        ale.reset_game()
        seen.add(bytes(byte for action in (3, 4) * 40 for byte in (ale.act(action), *ale.getRAM())))
    assert len(seen) == 4


BUFFERS = {
    "int32": np.zeros(128, np.int32),
    "float": np.zeros(128),
    "int8": np.zeros(128, np.int8),
    "short": np.zeros(7, np.uint8),
    "long": np.zeros(129, np.uint8),
    "two dimensions": np.zeros((2, 64), np.uint8),
    "strided": np.zeros(256, np.uint8)[::2],
    "list": [0] * 128,
}
BUFFERS["constant"] = np.zeros(128, np.uint8)
BUFFERS["constant"].setflags(write=False)


@pytest.mark.parametrize("kind", BUFFERS)
def test_a_buffer_of_another_kind_raises_ale_pys_error(kind: str, both: tuple[ALEInterface, Any]) -> None:
    text = r"\(\): incompatible function arguments\. The following argument types"
    for ale in both:
        for method in (ale.getRAM, ale.getAudio) if kind == "int32" else (ale.getRAM,):
            with pytest.raises(TypeError, match=text):
                method(BUFFERS[kind])
    assert not np.any(BUFFERS[kind])


def test_the_error_names_the_buffer_and_what_is_taken() -> None:
    with pytest.raises(TypeError) as caught:
        loaded().getRAM(np.zeros(3, np.int32))
    assert "it must be a writable C-contiguous uint8 array of shape (128,), got int32 (3,)" in str(caught.value)


@pytest.mark.parametrize(
    ("use", "error"),
    [
        (lambda ale: ale.setRAM(1000, 1), RuntimeError),
        (lambda ale: ale.setRAM(1, 1000), TypeError),
        (lambda ale: ale.setRAM("x", 1), TypeError),
        (lambda ale: ale.setMode(99), RuntimeError),
        (lambda ale: ale.setDifficulty(9), RuntimeError),
        (lambda ale: ale.act("x"), TypeError),
        (lambda ale: ale.act(1.0), TypeError),
        (lambda ale: ale.setInt("nope", 1), RuntimeError),
        (lambda ale: ale.setInt("frame_skip", "x"), TypeError),
        (lambda ale: ale.setBool("sound_obs", 1), TypeError),
        (lambda ale: ale.setLoggerMode(3), TypeError),
        (lambda ale: ale.restoreState(3), TypeError),
        (lambda ale: ale.isSupportedROM("nowhere.bin"), RuntimeError),
        (lambda ale: ale.isSupportedROM(3), TypeError),
        *(
            (lambda ale, name=name, wrong=wrong: getattr(ale, name)(wrong), error)
            for name in ("getScreen", "getScreenRGB", "getScreenGrayscale")
            for wrong, error in (
                (np.zeros((3, 4, 5, 6), np.uint8), RuntimeError),
                (np.zeros((210, 160), np.int32), TypeError),
            )
        ),
    ],
)
def test_wrong_arguments_raise_the_kind_of_ale_pys_error(
    use: Callable[[Any], Any], error: type[Exception], both: tuple[ALEInterface, Any]
) -> None:
    for ale in both:
        with pytest.raises(error):
            use(ale)


def test_modes_raise_ale_pys_very_class(both: tuple[ALEInterface, Any]) -> None:
    """ale-py's own tests compare the class itself."""
    for use in (ALEInterface.setMode, ALEInterface.setDifficulty):
        with pytest.raises(RuntimeError) as caught:
            use(both[0], 99)
        assert caught.type is RuntimeError


def test_a_subclass_has_attributes_of_its_own() -> None:
    class Mine(ALEInterface):
        def lives(self) -> int:
            return 7

    ale = Mine()
    ale.note = 1
    ale.loadROM(roms.get_rom_path("breakout"))
    assert ale.lives() == 7
