"""The rules of an episode stand in `Episode` and in the wrappers: no other module reads the fields that they play."""

import ast
from pathlib import Path

from package_modules import SOURCES

from atari.task.fields import GROUPS

RULES = frozenset((*GROUPS["begin"], *GROUPS["lives"])) - {"seeding"}
"""The fields of no-ops, FIRE and lives."""

HOMES = ("atari.task", "atari.wrappers")
"""The modules that check and print the fields, and the wrappers. The C++ `Episode` gets all fields by name, in `make_episode`."""

OTHERS = {
    "atari.env.episode_env": "whether a reset takes the options noops and fire, and what wrappers around it must know",
    "atari.learning.evaluation.protocols": "evaluation protocols prescribe them",
    "atari.integrations.envpool.spec": "EnvPool's names of them",
    "atari.learning.memory.options": "refuses, by name, what a replay memory does not serve",
    "atari.learning.memory.datasets": "refuses, by name, what a data set does not say to a replay memory",
    "atari.recording.replay.observations": "finds in a recording the no-ops and frame skips that an environment drew",
    "atari.integrations.ray.rollout_worker": "refuses, by name, what its learner does not serve",
    "atari.cli.policies": "whether a termination is a report (`life_loss_info`)",
    "atari.play.session": "whether a termination is a report (`life_loss_info`)",
}
"""By module, why it reads some of them."""

ACTIONS = ("atari.games.actions", "atari.env.env", "atari.learning.diagnosis.reach", "atari.play.")
"""Modules in which `fire` is the button of an action."""


def reads(file: Path) -> set[str]:
    """The fields of `RULES` that a file reads as attributes."""
    return {node.attr for node in ast.walk(ast.parse(file.read_text())) if isinstance(node, ast.Attribute)} & RULES


def test_the_fields_of_no_ops_fire_and_lives_are_read_where_their_rules_stand() -> None:
    others = {name: reads(file) for name, file in SOURCES.items() if not name.startswith(HOMES)}
    found = {name: read - ({"fire"} if name.startswith(ACTIONS) else set()) for name, read in others.items()}
    assert {name for name, read in found.items() if read} == OTHERS.keys()
    assert found["atari.cli.policies"] == found["atari.play.session"] == {"life_loss_info"}


def test_the_rules_are_found_where_they_are_played() -> None:
    assert reads(SOURCES["atari.wrappers.layers"]) == RULES
