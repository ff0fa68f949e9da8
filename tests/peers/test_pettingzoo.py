"""Beside PettingZoo's Atari environments on Multi-Agent-ALE: all ways to make them, several games in each."""

import importlib
import warnings
from pathlib import Path
from typing import Any

import ale_py.roms
import pytest

pytest.importorskip("multi_agent_ale_py")
from multiplayer.cases import cases, digest

from atari.multiplayer import parallel_env

pytestmark = pytest.mark.peers

ROMS = str(Path(str(ale_py.roms.get_rom_path("pong"))).parent)


@pytest.mark.parametrize(("name", "arguments"), list(cases()), ids=lambda value: value if type(value) is str else "")
def test_a_game_equals_pettingzoos(name: str, arguments: dict[str, Any]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        module = importlib.import_module(f"pettingzoo.atari.{name}")
        theirs = module.parallel_env(auto_rom_install_path=ROMS, **arguments)
        ours = parallel_env(name, **arguments)
        for agent in theirs.possible_agents:
            assert ours.observation_space(agent) == theirs.observation_space(agent)
            assert ours.action_space(agent) == theirs.action_space(agent)
        assert ours.metadata == theirs.metadata
        assert digest(ours, 7, 400) == digest(theirs, 7, 400)
