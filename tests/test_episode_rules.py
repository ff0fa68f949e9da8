"""The rules of an episode stand in `Episode` and in the wrappers: no other module reads the fields that they play."""

import ast
from pathlib import Path

import atari
import atari.wrappers
from atari.task.fields import GROUPS

RULES = frozenset((*GROUPS["begin"], *GROUPS["lives"])) - {"seeding"}
"""The fields of no-ops, FIRE and lives."""

HOMES = ("atari/task/", "atari/wrappers/")
"""The modules that check and print the fields, and the wrappers. The C++ `Episode` gets all fields by name, in `make_episode`."""

OTHERS = {
    "atari/env/episode_env.py": "whether a reset takes the options noops and fire, and what wrappers around it must know",
    "atari/learning/evaluation/protocols.py": "evaluation protocols prescribe them",
    "atari/integrations/envpool/spec.py": "EnvPool's names of them",
    "atari/learning/memory/options.py": "refuses, by name, what a replay memory does not serve",
    "atari/integrations/ray/rollout_worker.py": "refuses, by name, what its learner does not serve",
    "atari/cli/policies.py": "whether a termination is a report (`life_loss_info`)",
    "atari/play/session.py": "whether a termination is a report (`life_loss_info`)",
}
"""By module, why it reads some of them."""

ACTIONS = ("atari/games/actions.py", "atari/env/env.py", "atari/play/")
"""Modules in which `fire` is the button of an action."""


def readers() -> dict[str, set[str]]:
    """By module, the fields of `RULES` that it reads as attributes."""
    found: dict[str, set[str]] = {}
    for package, folder in (("atari", atari), ("atari/wrappers", atari.wrappers)):
        root = Path(str(folder.__file__)).parent
        for file in root.rglob("*.py"):
            name = f"{package}/{file.relative_to(root).as_posix()}"
            tree = ast.parse(file.read_text())
            reads = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)} & RULES
            if name.startswith(ACTIONS):
                reads -= {"fire"}
            if reads and not name.startswith(HOMES):
                found[name] = reads
    return found


def test_the_fields_of_no_ops_fire_and_lives_are_read_where_their_rules_stand() -> None:
    found = readers()
    assert found.keys() == OTHERS.keys()
    reports = {name: found[name] for name in ("atari/cli/policies.py", "atari/play/session.py")}
    assert all(reads == {"life_loss_info"} for reads in reports.values())


def test_the_rules_are_found_where_they_are_played() -> None:
    text = (Path(str(atari.wrappers.__file__)).parent / "layers.py").read_text()
    reads = {node.attr for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Attribute)}
    assert reads >= RULES
