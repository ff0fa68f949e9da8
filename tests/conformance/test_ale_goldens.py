"""The game files, the native core and `AtariEnv` on it give what ale-py and its environment give in every game.

`ale_goldens.py` says what is played. Where a check sum differs, ale-py plays, too, and the error names what differs.
"""

import hashlib
import json

import pytest
from conformance import ale_facts, ale_goldens
from conformance.ale_goldens import GAMES, SCRIPTS, Play

import atari
from atari.cores.verify import verify

GOLDENS = json.loads(ale_goldens.FILE.read_text())
PLAYED_AGAIN = GAMES[5::26]
"""Games in which ale-py plays every script again: the check sums in the file are its own."""


def test_all_games_have_check_sums_of_all_scripts() -> None:
    assert list(GOLDENS) == GAMES
    assert all(list(sums) == list(SCRIPTS) for sums in GOLDENS.values())


@pytest.mark.filterwarnings("ignore:.*after the episode had ended")  # three modes of Demon Attack are over at once
@pytest.mark.parametrize("game", GAMES)
def test_check_sums(game: str) -> None:
    found = {name: play(game, "native") for name, play in SCRIPTS.items() if name != "modes"}
    wrong = [name for name in found if found[name] != GOLDENS[game][name]]
    assert not wrong, "; ".join(ale_goldens.difference(game, name) for name in wrong)


@pytest.mark.parametrize("game", GAMES)
def test_every_mode_and_difficulty(game: str) -> None:
    for run, golden in zip(ale_goldens.mode_runs(game), GOLDENS[game]["modes"], strict=True):
        assert ale_goldens.check_sum(run, "native") == golden, f"{verify(run) or run}"


@pytest.mark.parametrize(
    ("game", "side"), [*((game, "native") for game in GAMES), *((game, "ale") for game in PLAYED_AGAIN)]
)
def test_a_core_restored_in_mid_episode(game: str, side: str) -> None:
    core, actions = ale_goldens.cores_of_middle(game, side)
    restored = type(core)(game, seed=9, repeat_action_probability=0.25, sound=True)
    restored.restore(core.snapshot())
    assert ale_goldens.check_sum_of_middle(restored, actions) == GOLDENS[game]["middle"]


@pytest.mark.parametrize("game", list(atari.games))
def test_rom_hashes(game: str) -> None:
    rom = atari.games[game].rom
    image = (ale_facts.ROMS / f"{game}.bin").read_bytes()
    assert (len(image), hashlib.md5(image).hexdigest()) == (rom.size, rom.md5)
    assert hashlib.sha256(image).hexdigest() == rom.sha256


@pytest.mark.parametrize("game", PLAYED_AGAIN)
def test_ale_py_has_these_check_sums(game: str) -> None:
    assert {name: play(game, "ale") for name, play in SCRIPTS.items()} == GOLDENS[game]


def test_a_check_sum_has_every_result() -> None:
    """One other byte, number or type anywhere gives another check sum."""
    game = "pong"
    play = ale_goldens.started(ale_goldens.make_env(game, "native", **ale_goldens.ram_options(game)))
    play.reset(seed=0)
    same = Play(play.env)
    observation, info = play.env.reset(seed=0)
    same.add((observation, info))
    changed = observation.copy()
    changed[100] ^= 1
    for result in (
        (changed, info),
        (observation.astype("int16"), info),
        (observation, {**info, "lives": info["lives"] + 1}),
        (observation, {**info, "frame_number": float(info["frame_number"])}),
    ):
        other = Play(play.env)
        other.add(result)
        assert str(other.sum) != str(same.sum)
