"""Protocols and sets of games: their numbers, and that two protocols cannot have one name."""

import re
from dataclasses import asdict, replace

import pytest

import atari
from atari.learning import GAME_SETS, PROTOCOLS
from atari.learning.evaluation.protocols import find_games, find_protocol


@pytest.mark.parametrize(
    ("name", "numbers"),
    {
        # sticky, all actions, no-ops, frames, epsilon, games
        "dqn2015": (0.0, False, (1, 30), 18_000, 0.05, 30),
        "machado2018": (0.25, True, (0, 0), 108_000, 0.0, 100),
        "atari100k": (0.0, False, (0, 0), 108_000, 0.001, 100),
        "dopamine": (0.25, False, (0, 0), 108_000, 0.001, 100),
        "baselines": (0.0, False, (1, 30), 108_000, 0.0, 100),
    }.items(),
)
def test_numbers(name, numbers):
    one = PROTOCOLS[name]
    assert one.name == name
    assert numbers == (
        one.repeat_action_probability,
        one.full_action_space,
        (one.noop_min, one.noop_max),
        one.max_frames,
        one.epsilon,
        one.episodes,
    )


@pytest.mark.parametrize("name", PROTOCOLS)
def test_numbers_are_those_of_the_preset(name):
    """But for what evaluation has of its own: episodic life, clipping, epsilon, and five minutes of dqn2015."""
    of_preset, mine = atari.wrappers.PRESETS[name], PROTOCOLS[name]
    options = of_preset.options
    assert options["repeat_action_probability"] == mine.repeat_action_probability
    assert options.get("full_action_space", False) == mine.full_action_space
    assert of_preset.protocol.noops == (mine.noop_min, mine.noop_max)


def test_other_numbers_need_another_name():
    with pytest.raises(ValueError, match="needs another name"):
        replace(PROTOCOLS["dopamine"], epsilon=0.0)
    assert replace(PROTOCOLS["dopamine"], epsilon=0.0, name="greedy").epsilon == 0.0
    assert replace(PROTOCOLS["dopamine"], episodes=5).episodes == 5  # more games are the same protocol


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("repeat_action_probability", 1.5),
        ("epsilon", "much"),
        ("full_action_space", 1),
        ("noop_min", 31),
        ("noop_max", -1),
        ("max_frames", 0),
        ("episodes", 0),
        ("preset", "dqn15"),
        ("lives", "episodic"),
        ("frame_skip", 0),
        ("name", None),
    ],
)
def test_wrong_numbers(field, value):
    with pytest.raises((TypeError, ValueError)):
        type(PROTOCOLS["dqn2015"])(**{**asdict(PROTOCOLS["dqn2015"]), "name": "mine", field: value})


def test_sets():
    sizes = {name: len(set(games)) for name, games in GAME_SETS.items()}
    assert sizes == {"atari5": 5, "atari26": 26, "atari49": 49, "atari55": 55, "atari57": 57, "atari60": 60}
    assert all(atari.games[game].single_player for games in GAME_SETS.values() for game in games)
    assert set(GAME_SETS["atari26"]) < set(GAME_SETS["atari57"])
    games = find_games(["pong", "atari26", "atari5"])
    assert games[0].id == "pong"
    assert len(games) == len({"pong", *GAME_SETS["atari26"], *GAME_SETS["atari5"]})


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("nature", "dqn2015"), ("Nature-DQN", "dqn2015"), ("mnih2015", "dqn2015"), ("dqn", "dqn2015"),
        ("dqn2013", "dqn2015"), ("sticky", "machado2018"), ("Machado", "machado2018"), ("rainbow", "dopamine"),
        ("dopamin", "dopamine"), ("100k", "atari100k"), ("atari-100k", "atari100k"), ("sb3", "baselines"),
        ("cleanrl", "baselines"), ("openai", "baselines"),
        ("agent57", None), ("hessel2018", None), ("foo", None), ("", None), ("ale", None),
    ],
)  # fmt: skip
def test_a_wrong_name_suggests_what_it_means_or_nothing(name, near):
    with pytest.raises(ValueError, match=r"known are dqn2015, .*baselines$") as caught:
        find_protocol(name)
    suggested = re.findall("did you mean '(.*?)'", str(caught.value))
    assert suggested == ([near] if near else [])
