"""Beside Multi-Agent-ALE itself: the methods of `ALEInterface`, called in both."""

from typing import Any

import ale_py.roms
import numpy as np
import pytest

multi_agent_ale_py = pytest.importorskip("multi_agent_ale_py")
from atari.multiplayer import ALEInterface, parallel_env  # noqa: E402

pytestmark = pytest.mark.peers

GAMES = {"pong": 6, "space_invaders": 33, "boxing": 2, "joust": 1}


def loaded(kind: Any, game: str, mode: int) -> Any:
    kind.setLoggerMode("error")
    ale = kind()
    ale.setInt(b"random_seed", 5)
    ale.setFloat(b"repeat_action_probability", 0.25)
    ale.loadROM(str(ale_py.roms.get_rom_path(game)))
    ale.setMode(mode)
    ale.reset_game()
    return ale


def seen(ale: Any) -> list[Any]:
    arrays = (ale.getScreen(), ale.getScreenRGB(), ale.getScreenGrayscale(), ale.getRAM(), ale.allLives())
    counters = (ale.lives(), ale.game_over(), ale.getFrameNumber(), ale.getEpisodeFrameNumber())
    return [*((array.dtype, array.shape, array.tobytes()) for array in arrays), *map(int, counters)]


@pytest.mark.parametrize("game", GAMES)
def test_the_same_play(game: str) -> None:
    ours, theirs = (loaded(kind, game, GAMES[game]) for kind in (ALEInterface, multi_agent_ale_py.ALEInterface))
    facts = ("getMinimalActionSet", "getLegalActionSet", "getAvailableDifficulties", "getScreenDims", "getRAMSize")
    for name in (*facts, "numPlayersActive", "isSupportedRom"):
        own, their = getattr(ours, name)(), getattr(theirs, name)()
        assert (type(own), np.asarray(own).dtype, np.asarray(own).tolist()) == (
            type(their),
            np.asarray(their).dtype,
            np.asarray(their).tolist(),
        ), name
    for players in (2, 3, 4):
        assert ours.getAvailableModes(players).tolist() == theirs.getAvailableModes(players).tolist()
    actions, rng = ours.getMinimalActionSet(), np.random.default_rng(0)
    for step in range(400):
        moves = actions[rng.integers(len(actions), size=ours.numPlayersActive())]
        own, their = ours.act(moves), theirs.act(moves)
        assert (own.dtype, own.tolist()) == (their.dtype, their.tolist())
        if step % 40 == 0:
            assert seen(ours) == seen(theirs)
        if step == 200:
            states = [ale.encodeState(ale.cloneSystemState()) for ale in (ours, theirs)]
    for ale, state in zip((ours, theirs), states, strict=True):
        assert state.dtype == np.uint8
        ale.restoreSystemState(ale.decodeState(state))
    assert ours.getFrameNumber() == theirs.getFrameNumber()
    # What follows is not compared: Multi-Agent-ALE does not go on from a state as it went on before.


def test_the_same_attributes() -> None:
    import importlib
    import warnings
    from pathlib import Path

    roms = str(Path(str(ale_py.roms.get_rom_path("pong"))).parent)
    for name, options in (
        ("pong_v3", {"num_players": 4}),
        ("boxing_v2", {"obs_type": "grayscale_image", "max_cycles": 9}),
    ):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            theirs = importlib.import_module(f"pettingzoo.atari.{name}").parallel_env(
                auto_rom_install_path=roms, **options
            )
            ours = parallel_env(name, **options)
            for env in (ours, theirs):
                env.reset(seed=3)
        for attribute in (
            "obs_type",
            "full_action_space",
            "num_players",
            "max_cycles",
            "mode",
            "terminations",
            "frame",
        ):
            assert getattr(ours.unwrapped, attribute) == getattr(theirs.unwrapped, attribute), attribute
        for kind in ("full_state",):  # a state without the generator is not complete in PettingZoo
            frames = []
            for env in (ours, theirs):
                inner = env.unwrapped
                state = getattr(inner, f"clone_{kind}")()
                assert (state.dtype, state.ndim) == (np.uint8, 1)
                env.step(dict.fromkeys(env.agents, 1))
                getattr(inner, f"restore_{kind}")(state)
                frames.append(inner.ale.getFrameNumber())
            assert frames[0] == frames[1]
