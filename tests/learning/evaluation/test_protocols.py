"""Protocols and sets of games: their numbers, and that two protocols cannot have one name."""

import json
import re
from dataclasses import asdict, replace
from pathlib import Path

import pytest

import atari
from atari.learning import GAME_SETS, PROTOCOLS, EvaluationProtocol, Published
from atari.learning.evaluation.played import resolve_games
from atari.learning.evaluation.protocols import differences, find_protocol, refusal
from atari.task import Task


@pytest.mark.parametrize(
    ("name", "numbers"),
    {
        # sticky, all actions, no-ops, frames, epsilon, games
        "dqn2015": (0.0, False, (1, 30), 18_000, 0.05, 30),
        "noop_starts": (0.0, False, (1, 30), 108_000, 0.001, 100),
        "machado2018": (0.25, True, (0, 0), 108_000, 0.0, 100),
        "dreamerv3": (0.25, True, (0, 30), 108_000, 0.0, 100),
        "atari100k_noops": (0.0, False, (0, 30), 108_000, 0.0, 100),
        "dopamine_nets": (0.25, False, (0, 0), 100_000, 0.001, 100),
        "atari100k": (0.0, False, (0, 0), 108_000, 0.001, 100),
        "dopamine": (0.25, False, (0, 0), 108_000, 0.001, 100),
        "baselines": (0.0, False, (1, 30), 108_000, 0.0, 100),
    }.items(),
)
def test_numbers(name, numbers):
    one = PROTOCOLS[name]
    assert one.name == name
    noops, rest = (one.noop_min, one.noop_max), (one.max_frames, one.epsilon, one.episodes)
    assert numbers == (one.repeat_action_probability, one.full_action_space, noops, *rest)


@pytest.mark.parametrize("name", PROTOCOLS)
def test_numbers_are_those_of_the_preset(name):
    """An evaluation differs in episodic life, clipping, epsilon, limits, and the no-ops of DreamerV3's protocols."""
    mine = PROTOCOLS[name]
    fields = atari.PRESETS[mine.preset].fields
    assert fields["repeat_action_probability"] == mine.repeat_action_probability
    assert (fields.get("actions") == "full") == mine.full_action_space
    noops = (0, 30) if name in ("dreamerv3", "atari100k_noops") else fields.get("noops", (0, 0))
    assert noops == (mine.noop_min, mine.noop_max)


ROW = re.compile(r'^\| `"(\w+)"` \| (.*) \|$|^\| (no protocol) \| (.*) \|$', re.MULTILINE)


def in_table(names):
    """The published agents of a protocol as docs/evaluation.md names them: by name, or a whole source as its number."""
    cells = []
    for source in dict.fromkeys(name.split("/")[0] for name in names):
        mine = [name for name in names if name.startswith(f"{source}/")]
        every = len(Published.names(f"{source}/"))
        number = f"all {every} of `{source}`" if len(mine) == every else f"{len(mine)} of {every} of `{source}`"
        cells.append(number if len(mine) > 3 and source != "pfrl" else ", ".join(f"`{name}`" for name in mine))
    return ", ".join(cells) or "none"


def test_the_table_of_protocols_and_publications_is_that_of_the_data():
    text = (Path(__file__).parents[3] / "docs" / "evaluation.md").read_text(encoding="utf-8")
    table = text.split("### Protocols and publications")[1].split("\n- ")[0]
    rows = [(name or none, one or other) for name, one, none, other in ROW.findall(table)]
    comparable = {name: protocol.comparable for name, protocol in PROTOCOLS.items()}
    every = [agent for names in comparable.values() for agent in names]
    left = tuple(sorted(set(Published.names()) - set(every)))
    assert rows == [(name, in_table(names)) for name, names in {**comparable, "no protocol": left}.items()]
    assert len(every) == len(set(every))  # an agent has one protocol


@pytest.mark.parametrize(
    ("protocol", "agent", "text"),
    [
        ("dopamine", "dopamine/rainbow", ""),
        ("dopamine", "dopamine_nets/dqn_cnn", "max_frames is 100000, and 108000 in dopamine; protocol 'dopamine_nets'"),
        ("baselines", "pfrl/rainbow", "lives is continue, and fire in baselines; protocol 'noop_starts' has its env"),
        ("atari100k", "dreamerv3/atari100k/ppo", "noop_max is 30, and 0 in atari100k; protocol 'atari100k_noops' has"),
        ("machado2018", "dreamerv3/atari57/ppo", "noop_max is 30, and 0 in machado2018; protocol 'dreamerv3' has its"),
        ("dopamine", "dreamerv3/muzero", "its source does not state its environments, so no protocol has them"),
        ("baselines", "cleanrl/ppo_rnd_envpool", "the nearest is 'baselines', where repeat_action_probability is 0.25"),
    ],
)
def test_a_refusal_names_the_fields_and_the_protocol_that_would_do(protocol, agent, text):
    found = refusal(PROTOCOLS[protocol], Published(agent))
    assert text in found
    assert bool(text) == bool(found)


def test_protocols_of_tasks_and_presets_press_fire_after_lost_lives_as_they_do():
    agents = (Published("cleanrl/ppo"), Published("pfrl/rainbow"))
    lives = Task.of("pong", preset="baselines"), Task.of("pong", preset="baselines", episodic_life=False)
    assert [not of_task(task).faults(agent) for task in lives for agent in agents] == [True, False, False, True]
    baselines = replace(PROTOCOLS["baselines"], name="mine", lives="preset")
    assert [not baselines.faults(agent) for agent in agents] == [True, False]
    starts = replace(PROTOCOLS["noop_starts"], name="mine", lives="preset")
    assert [not starts.faults(agent) for agent in agents] == [False, True]


def test_other_numbers_need_another_name():
    with pytest.raises(ValueError, match="needs another name"):
        replace(PROTOCOLS["dopamine"], epsilon=0.0)
    assert replace(PROTOCOLS["dopamine"], epsilon=0.0, name="greedy").epsilon == 0.0
    assert replace(PROTOCOLS["dopamine"], episodes=5).episodes == 5  # more games are the same protocol


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("repeat_action_probability", 1.5), ("epsilon", "much"), ("full_action_space", 1), ("noop_min", 31),
        ("noop_max", -1), ("max_frames", 0), ("episodes", 0), ("preset", "dqn15"), ("preset", ""), ("lives", "episodic"),
        ("lives", "task"), ("frame_skip", 0), ("frame_skip", (5, 2)), ("task", "pong"), ("name", None),
    ],
)  # fmt: skip
def test_wrong_numbers(field, value):
    with pytest.raises((TypeError, ValueError)):
        type(PROTOCOLS["dqn2015"])(**{**asdict(PROTOCOLS["dqn2015"]), "name": "mine", field: value})


def of_task(task, **facts):
    return EvaluationProtocol.of_task(task, **{"name": "mine", "source": "", "epsilon": 0.0, "episodes": 1, **facts})


def test_the_protocol_of_a_task():
    task = Task.of("pong", preset="envpool", frameskip=(2, 5), repeat_action_probability=0.1)
    protocol = of_task(task)
    assert (protocol.noop_min, protocol.noop_max, protocol.max_frames) == (1, 30, 108_000)
    assert (protocol.frame_skip, protocol.repeat_action_probability, protocol.lives) == ((2, 5), 0.1, "task")
    content = json.loads(json.dumps(protocol.to_json()))
    assert EvaluationProtocol.from_json(content) == protocol
    without = {name: value for name, value in PROTOCOLS["dopamine"].to_json().items() if name != "task"}
    assert EvaluationProtocol.from_json(without) == PROTOCOLS["dopamine"]
    assert "2 to 4 frames an action" in str(protocol)
    assert "games and lives begin as in its task (pong: Pong, as 'pong' with preset='envpool'" in str(protocol)
    with pytest.raises(ValueError, match=r"noop_max must be 30, as the protocol's task has it, got 3"):
        replace(protocol, noop_max=3)
    with pytest.raises(ValueError, match=r"has lives='task' and preset='', got 'fire' and ''"):
        replace(protocol, lives="fire")


def test_protocols_of_tasks_differ_in_what_is_no_choice_of_the_policy():
    task = Task.of("pong", preset="baselines")
    assert differences(of_task(task), of_task(task.replace(img_height=42, img_width=42, reward_clipping=False))) == []
    assert differences(of_task(task), of_task(Task.of("breakout", preset="baselines"))) == []
    assert differences(of_task(task), of_task(task.replace(lives_unit="frame"))) == [
        "lives_unit of the task skip and frame"
    ]


def test_sets():
    sizes = {name: len(set(games)) for name, games in GAME_SETS.items()}
    assert sizes == {"atari5": 5, "atari26": 26, "atari49": 49, "atari55": 55, "atari57": 57, "atari60": 60}
    assert all(atari.games[game].single_player for games in GAME_SETS.values() for game in games)
    assert set(GAME_SETS["atari26"]) < set(GAME_SETS["atari57"])
    games = resolve_games(["pong", "atari26", "atari5", "ALE/Surround-v5"])
    assert games[0].id == "pong"
    assert len(games) == len({"pong", *GAME_SETS["atari26"], *GAME_SETS["atari5"]}) + 1
    assert (games[0].env_id, games[-1].env_id) == (None, "ALE/Surround-v5")


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
