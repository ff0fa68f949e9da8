"""PettingZoo's names of the environments' attributes and states, and Multi-Agent-ALE's of the core."""

import copy
import importlib
import inspect
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pettingzoo")
import atari.multiplayer
from atari.ale_py import roms
from atari.multiplayer import ALEInterface, parallel_env, raw_env
from atari.multiplayer.base_atari_env import BaseAtariEnv, ParallelAtariEnv, base_env_wrapper_fn
from atari.recording import RecordReplay, Replay


def inner(name: str = "pong_v3", **options: Any) -> Any:
    env = parallel_env(name, **options).unwrapped
    env.reset(seed=1)
    return env


def play(env: Any, steps: int = 60, seed: int = 0) -> list[Any]:
    rng = np.random.default_rng(seed)
    results = []
    for _ in range(steps):
        _, rewards, ends, _, _ = env.step({agent: int(rng.integers(6)) for agent in env.agents})
        results.append((env.core.ram().tobytes(), {agent: int(paid) for agent, paid in rewards.items()}, ends))
    return results


@pytest.mark.parametrize("kind", ["state", "full_state"])
@pytest.mark.parametrize("game", ["pong_v3", "warlords_v3", "space_invaders_v2"])
def test_play_goes_on_equally_from_a_cloned_state(game: str, kind: str) -> None:
    env = inner(game)
    play(env)
    state = getattr(env, f"clone_{kind}")()
    assert state.dtype == np.uint8
    first = play(env, seed=2)
    assert play(env, seed=2) != first
    getattr(env, f"restore_{kind}")(state.copy())
    assert play(env, seed=2) == first


def test_only_a_full_state_has_the_generator_of_sticky_actions() -> None:
    env = inner(repeat_action_probability=0.5)
    state, full = env.clone_state(), env.clone_full_state()
    first = play(env, 200)
    for kind, data, equal in (("full_state", full, True), ("state", state, False)):
        getattr(env, f"restore_{kind}")(data)
        assert (play(env, 200) == first) is equal


def test_a_state_that_is_none_changes_nothing() -> None:
    env = inner()
    before = env.core.snapshot()
    for wrong in (np.zeros(9, np.uint8), inner("boxing_v2").clone_state()):
        with pytest.raises(ValueError, match="state"):
            env.restore_state(wrong)
    assert env.core.snapshot() == before


def test_attributes_are_pettingzoos() -> None:
    env = inner("pong_v3", num_players=4, obs_type="ram", max_cycles=7, full_action_space=True)
    assert (env.num_players, env.max_cycles, env.obs_type, env.full_action_space, env.mode) == (4, 7, "ram", True, 6)
    assert env.rom_path == str(roms.get_rom_path("pong"))
    assert env.terminations == dict.fromkeys(env.possible_agents, False)
    assert (inner().obs_type, inner(obs_type="grayscale_image").obs_type) == ("rgb_image", "grayscale_image")
    assert inner().full_action_space is False


def test_the_limit_and_the_mode_can_be_set() -> None:
    env = inner()
    env.max_cycles, env.mode = 2, 10
    env.reset(seed=1)
    assert [env.step({})[3]["first_0"] for _ in range(2)] == [False, True]
    assert (env.task.max_episode_steps, env.task.mode) == (2, 10)
    other = inner(mode=10)
    other.reset(seed=1)
    env.reset(seed=1)
    assert play(env, 1) == play(other, 1)
    for name, wrong in (("max_cycles", 0), ("mode", 6)):
        with pytest.raises(ValueError, match=f"^{name}"):
            setattr(env, name, wrong)
    with pytest.raises(AttributeError):
        env.obs_type = "ram"


def test_the_core_has_multi_agent_ales_names() -> None:
    env = inner("space_invaders_v2")
    ale = env.ale
    assert ale.act([1, 1]).tolist() == [0, 0]
    assert (ale.numPlayersActive(), ale.lives(), ale.allLives().tolist()) == (2, 2, [2, 2])
    assert ale.getScreenDims() == (160, 210)
    assert (ale.getScreen().shape, ale.getScreenGrayscale().shape) == ((33600,), (210, 160, 1))
    buffer = np.zeros((210, 160), np.uint8)
    assert ale.getScreen(buffer) is buffer
    assert np.array_equal(buffer.reshape(-1), ale.getScreen())
    assert ale.getMinimalActionSet().tolist() == [0, 1, 3, 4, 11, 12]
    assert (ale.getInt(b"random_seed"), ale.getFloat("repeat_action_probability")) == (1, 0.0)
    assert ale.getString(b"record_screen_dir") == b""
    assert ale.isSupportedRom() is True
    assert env.ale is ale
    ale.setRAM(3, 7)
    assert ale.getRAM()[3] == env.core.ram()[3] == 7
    state, frame = ale.cloneState(), ale.getFrameNumber()
    assert ale.encodeStateLen(state) == len(ale.encodeState(state))
    ale.saveState()
    ale.act([0, 0])
    ale.saveState()
    ale.act([0, 0])
    frames = []
    for _ in range(2):
        ale.loadState()
        frames.append(ale.getFrameNumber())
    assert frames == [frame + 1, frame]
    ale.deleteState(state)
    with pytest.raises(RuntimeError, match="no state is saved"):
        ale.loadState()
    with pytest.raises(AttributeError):
        env.ale = ale


def test_settings_apply_with_the_next_seed() -> None:
    env = inner(obs_type="ram")
    env.ale.setFloat(b"repeat_action_probability", 0.25)
    assert env.task.repeat_action_probability == 0.0
    env.reset(seed=5)
    assert env.task.repeat_action_probability == 0.25
    other = inner(obs_type="ram", repeat_action_probability=0.25)
    other.reset(seed=5)
    assert play(env) == play(other)
    env.ale.setInt("random_seed", 9)
    env.ale.loadROM(env.rom_path.encode())
    other.reset(seed=9)
    env.reset()
    assert play(env) == play(other)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda env: env.ale.setInt("frame_skip", 4), "make the environment with frameskip"),
        (lambda env: env.ale.setBool("color_averaging", True), "have no colour averaging"),
        (lambda env: env.ale.setBool("sound_obs", True), "with sound=True"),
    ],
)
def test_a_setting_without_effect_is_an_error(change: Callable[[Any], None], message: str) -> None:
    env = inner()
    change(env)
    with pytest.raises(RuntimeError, match=message):
        env.reset(seed=1)


def test_a_recorded_core_has_the_names_too(tmp_path: Any) -> None:
    env = parallel_env("pong_v3", obs_type="ram").unwrapped
    env.core = RecordReplay(env.core, tmp_path / "x.a26r")
    env.reset(seed=1)
    state = env.clone_full_state()
    first = play(env, 20)
    env.restore_full_state(state)
    assert play(env, 20) == first
    env.ale.setFloat("repeat_action_probability", 0.5)
    with pytest.raises(RuntimeError, match="set it before RecordReplay begins"):
        env.reset(seed=1)
    env.core.close()
    assert Replay.load(tmp_path / "x.a26r").verify()


def test_a_copy_has_a_core_of_its_own() -> None:
    env = inner()
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        frame = env.ale.getFrameNumber()
        other.ale.act([0, 0])
        assert (env.ale.getFrameNumber(), other.ale.getFrameNumber()) == (frame, frame + 1)


def test_each_environment_has_a_module() -> None:
    for environment in atari.multiplayer.ENVIRONMENTS.values():
        module = importlib.import_module(f"atari.multiplayer.{environment.id}")
        assert getattr(atari.multiplayer, environment.id) is module
        parameters = inspect.signature(module.raw_env).parameters.values()
        assert {one.name: one.default for one in parameters if one.name != "options"} == environment.defaults
        for function in (module.raw_env, module.env, module.parallel_env):
            assert function().unwrapped.metadata["name"] == environment.id
    from atari.multiplayer import pong_v3

    assert pong_v3.parallel_env(4, obs_type="ram").unwrapped.num_players == 4
    with pytest.raises(TypeError, match=r"no (parameter|option) 'has_maze'"):
        pong_v3.env(has_maze=True)


def test_the_base_environment_has_pettingzoos_arguments() -> None:
    env = ParallelAtariEnv("pong", 2, 10, 3, "ram")
    same = raw_env("pong", mode=10, obs_type="ram", seed=3).unwrapped
    assert (env.mode, env.metadata["name"], env.max_cycles) == (10, "custom_pong", 100_000)
    env.reset()
    same.reset()
    assert play(env) == play(same)
    assert ParallelAtariEnv("pong", 4).mode == 5
    game = base_env_wrapper_fn(BaseAtariEnv)(game="boxing", num_players=2, env_name="mine")
    assert game.metadata["name"] == "mine"
    with pytest.raises(ValueError, match="players"):
        ParallelAtariEnv("boxing", 3)


def test_a_rom_can_be_loaded() -> None:
    ale = ALEInterface()
    with pytest.raises(RuntimeError, match="no game is loaded"):
        ale.reset_game()
    ale.setInt(b"random_seed", 4)
    ale.loadROM(str(roms.get_rom_path("pong")))
    ale.setMode(6)
    ale.reset_game()
    core = atari.multiplayer.MultiplayerCore("pong", players=4, mode=6, seed=4, repeat_action_probability=0.25)
    core.reset()
    for step in range(100):
        assert ale.act([step % 6] * 4).tolist() == core.act_players([step % 6] * 4)
    assert np.array_equal(ale.getRAM(), core.ram())
    with pytest.raises(RuntimeError, match="mode of pong must be one of"):
        ale.setMode(99)
    with pytest.raises(RuntimeError, match="the ROM of no game of several players"):
        ale.loadROM(roms.get_rom_path("seaquest"))
    with pytest.raises(TypeError, match="setLoggerMode takes"):
        ale.setLoggerMode("loud")
