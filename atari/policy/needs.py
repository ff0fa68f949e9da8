"""`Needs`: the environments that a policy needs, according to its attributes `task` and `environment`."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from inspect import signature
from typing import Any

from atari.base.validation import check_known
from atari.games.game import Game
from atari.games.players import rules_of
from atari.task import Task
from atari.task.fields import DEFAULTS, FIELDS, GROUPS
from atari.task.resolution import ALIASES, OPTIONS
from atari.task.rules import default_ineffective
from atari.task.task import FoundGame
from atari.vector import AtariVectorEnv
from atari.vector.ale_names import NAMES
from atari.vector.layout import Layout
from atari.vector.options import task_of_lane

_LAYOUT = ("channels_last", "dtype", "rom")
"""Options of a policy that are not fields of a task."""


@dataclass(frozen=True)
class Needs:
    """The environments that a policy needs.

    Attributes:
        task: the task with the policy's observations and actions; None if the policy has no `task` and `environment`.
        options: `channels_last`, `dtype` and `rom`, if the policy gives them, as options of `AtariVectorEnv`.
    """

    task: Task | None = None
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def actions(self) -> tuple[str, ...] | None:
        """The names of the policy's actions by index."""
        return None if self.task is None else tuple(action.name for action in self.task.action_set)

    def layout(self, task: Task) -> Layout:
        """The axes and the dtype of observations of a task."""
        return Layout.check(task, self.options.get("channels_last", False), self.options.get("dtype", "uint8"))


def needs_of(policy: Any, game: Game) -> Needs:
    """The environments that a policy needs according to its `task` and `environment`, see `atari.learning.Policy`.

    Args:
        policy: a policy.
        game: the game. `AtariVectorEnv` plays `environment` in this game.

    Raises:
        ValueError: an option is wrong, or no option of policies.
    """
    environment = getattr(policy, "environment", None)
    try:
        options = _checked({} if environment is None else environment)
        layout = {name: options.pop(name) for name in _LAYOUT if name in options}
        stored = options.pop("task", None)
        task = _task(getattr(policy, "task", None) or stored)
        if task is not None and options:
            raise ValueError(f"it has a task, which decides {', '.join(options)}, too; leave them out")
        if task is None and environment:
            if not game.single_player:
                options.setdefault("players", min(rules_of(game).modes))
            task = task_of_lane(FoundGame(game), options.pop("preset", None), options)
        needs = Needs(task, layout)
        if task is not None:
            needs.layout(task)
    except (TypeError, ValueError) as error:
        raise ValueError(f"the environment of the policy: {error}") from error
    return needs


def _checked(environment: Any) -> dict[str, Any]:
    if not isinstance(environment, Mapping):
        raise TypeError(f"it must be a mapping of options, got {environment!r}")
    known = (*OPTIONS, *ALIASES, *NAMES, *_LAYOUT, "preset", "task")
    vectors = {*signature(AtariVectorEnv.__init__).parameters} - {*known, "self", "game", "options"}
    for name in environment:
        if name in vectors:
            raise ValueError(f"{name} is an option of what plays the policy, not of the policy; leave it out")
    check_known("it", [name for name in environment if name not in known], known)
    return {name: value for name, value in environment.items() if value is not None or name in OPTIONS}


def _task(task: Any) -> Task | None:
    """A task from a task or from a JSON object, as in files of networks."""
    if task is None or isinstance(task, Task):
        return task
    if isinstance(task, Mapping):
        return Task.from_json(json.dumps(task))
    raise TypeError(f"task must be an atari.Task, got {task!r}")


def in_game(task: Task, game: Task) -> Task:
    """A task with the game, mode, difficulty, players and interventions of `game`, and with all else of `task`."""
    fields = {name: getattr(task, name) for name in FIELDS if name not in (*GROUPS["game"], "interventions")}
    return task_with_fields(game, **fields)


def task_with_fields(game: Task, **fields: Any) -> Task:
    """A task with the game, mode, difficulty, players and interventions of `game`, and with these fields.

    Fields that have no effect beside the others take their defaults.
    """
    kept = ("rules", "rom_md5", "mode", "difficulty", "players", "interventions")
    every = {**DEFAULTS, **{name: getattr(game, name) for name in kept}, **fields, "game": game.definition}
    default_ineffective(every, given=())
    return Task(**every)
