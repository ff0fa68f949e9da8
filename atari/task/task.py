"""`Task`: everything that decides what an agent sees, may do and is paid, as one value, and the ways to make one."""

import inspect
import re
import textwrap
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from os import PathLike
from typing import Any

from typing_extensions import Unpack

from atari.base import notebook
from atari.base.frozen import FrozenDict
from atari.games.catalog import games
from atari.games.game import Game
from atari.games.pettingzoo import Environment, find_environment
from atari.games.players import pettingzoo_options
from atari.task import json_form
from atari.task.data import TaskData
from atari.task.description import describe, facts, summary
from atari.task.fields import DEFAULTS, GROUPS, ROWS, TaskOptions
from atari.task.presets import find_preset
from atari.task.resolution import OPTIONS, catalogue_name, fields_of, fields_of_id, is_id, translate


@dataclass(frozen=True, repr=False)
class Task(TaskData):
    """A game, and everything that decides what an agent sees, may do and is paid.

    `Task.of` makes one from an environment ID, the name of a game or a game file, with options. Every function, class
    and command of this package that plays a game takes a task, or the same options by the same names. The defaults are
    those of ALE's v5 environments. Fields without effect have their defaults, and tasks with equal fields are equal.
    Tasks can be hashed, pickled and stored as JSON. `docs/tasks.md` has a table of the fields.

    Raises:
        TypeError, ValueError: a field is of the wrong kind or out of range, has no effect beside the others, or
            contradicts one of them; the message says what to change.

    Example:
        >>> import atari
        >>> task = atari.Task.of("breakout", preset="dqn2015", frameskip=3)
        >>> task.frameskip, task.noops, task.episodic_life
        (3, (1, 30), True)
        >>> task == atari.Task.from_json(task.to_json())
        True
        >>> env = atari.make(task)
        >>> env.reset(seed=0)[0].shape
        (4, 84, 84)
        >>> task.differences(atari.Task.of("breakout", preset="dqn2015"))
        {'frameskip': (3, 4)}
    """

    @classmethod
    def of(
        cls, game: "str | PathLike[str] | Game | Task", *, preset: str | None = None, **options: Unpack[TaskOptions]
    ) -> "Task":
        """The task of a game and options.

        The preset overrides the fields of `game`, and the options override both.

        Args:
            game: an environment ID ("ALE/Pong-v5") with its options; a game's name ("pong", "MsPacman"), the path of a
                game file or a `Game`, with the options of ALE's v5; a name of PettingZoo's with its version
                ("pong_v3"), with its mode and its players; or a `Task`.
            preset: name of a preprocessing, one of `PRESETS`.
            **options: fields of `Task`. Gymnasium's and ale-py's names `full_action_space` and `clip_reward` are
                other names of `actions` and `reward_clipping`.

        Raises:
            gymnasium.error.NameNotFound: there is no such ID; the message suggests the right one.
            TypeError, ValueError: there is no such game, preset or option (the message suggests the nearest), or see
                `Task`.

        Example:
            >>> import atari
            >>> atari.Task.of("Pong-ram-v4").obs_type
            'ram'
        """
        return look_up(game).task(preset, options)

    def replace(self, **options: Unpack[TaskOptions]) -> "Task":
        """This task with other options; see `Task.of`.

        Raises:
            TypeError, ValueError: see `Task.of`.
        """
        return FoundGame(self).task(None, options)

    def to_json(self) -> str:
        """All fields as JSON, which `from_json` reads.

        Raises:
            ValueError: the game is a `Game` without a file.
        """
        return json_form.to_json(self)

    @staticmethod
    def from_json(text: str, game: Game | None = None) -> "Task":
        """The task of a text of `to_json`, from this or an older release.

        Args:
            text: the JSON.
            game: the game of the task; no file is read then. None: the text decides.

        Raises:
            TypeError: `text` is no string.
            ValueError: the text is no task, or one of another game: it is too long or too deep, has an unknown key or a
                value of the wrong kind, or has a newer format. The message names the key.
        """
        return json_form.from_json(Task, text, game)

    def __str__(self) -> str:
        return describe(self)

    def _repr_html_(self) -> str:
        return notebook.facts(summary(self), facts(self))


def _with_attributes(doc: str) -> str:
    """A docstring with the section "Attributes" before "Raises"."""
    wrapper = textwrap.TextWrapper(116, initial_indent="    ", subsequent_indent=" " * 8, break_on_hyphens=False)
    lines = [wrapper.fill(f"{name}: {row.says}.") for name, row in ROWS.items()]
    return inspect.cleandoc(doc).replace("Raises:", "\n".join(["Attributes:", *lines, "", "Raises:"]), 1)


Task.__doc__ = _with_attributes(Task.__doc__ or "Raises:")

GameLike = str | PathLike[str] | Game | Task
"""GAME, as users give it. Functions of users look it up, once; all other functions take what `look_up` returns."""


@dataclass(frozen=True)
class FoundGame:
    """The task or the game definition that GAME names.

    Attributes:
        game: the task or the definition.
        env_id: the ID, as the user wrote it, if GAME is one.
        fields: the fields that an ID decides beside its game.
        environment: PettingZoo's environment of a name with a version.
    """

    game: Game | Task
    env_id: str | None = None
    fields: Mapping[str, Any] = FrozenDict()
    environment: Environment | None = None

    @property
    def bare(self) -> bool:
        """Whether GAME says the game alone: it is neither a task nor an ID."""
        return isinstance(self.game, Game) and self.env_id is None

    @property
    def definition(self) -> Game:
        """The game definition."""
        return self.game if isinstance(self.game, Game) else self.game.definition

    def task(
        self,
        preset: str | None,
        options: Mapping[str, Any],
        base: Mapping[str, Any] = FrozenDict(),
        *,
        owner: str = "Task.of",
        others: Iterable[str] = ("preset",),
    ) -> Task:
        """The task of the game and options, see `Task.of`.

        Args:
            preset: name of a preset.
            options: the user's options.
            base: fields that a game alone has instead of ALE's v5, unless there is a preset.
            owner: the function that the user called, for errors.
            others: names of the other options of `owner`, for the suggestion in an error.

        Raises:
            TypeError, ValueError: see `Task.of`.
        """
        if self.environment is not None:
            options = pettingzoo_options(self.environment, options)
        own = {**(base if self.bare and preset is None else {}), **self.fields}
        return Task(**fields_of(self.game, preset, options, own, owner=owner, others=others))

    def task_for_agent(
        self, preset: str | None, options: Mapping[str, Any], *, default: str = "baselines", owner: str
    ) -> Task:
        """The task of an agent, which needs the preprocessing of a preset: `preset`, or else `default`.

        An ID decides the sticky actions, the actions and RAM. A `Task` is played unchanged unless a preset is named.

        Raises:
            TypeError, ValueError: see `task`; or the preset requires an option that the ID does not have.
        """
        if isinstance(self.game, Task) and preset is None:
            return self.task(None, options, owner=owner)
        name = preset or default
        if self.env_id is None:
            return self.task(name, options, owner=owner)
        given, _ = translate(options, owner)
        of_id = self.task(None, {}, owner=owner)
        kept = {one: getattr(of_id, one) for one in ("repeat_action_probability", "actions") if one not in given}
        chosen = find_preset(name)
        for one in chosen.required:
            if one in kept and of_id.differences(of_id.replace(**{one: chosen.fields[one]})):
                raise ValueError(
                    f"preset {name!r} needs {one}={chosen.fields[one]!r}, and {self.env_id} has {kept[one]!r}; "
                    f"use the game's name, {of_id.game!r}, or another preset"
                )
        return self.task(name, {**kept, **options}, owner=owner)


def look_up(game: GameLike) -> FoundGame:
    """The task or the game definition that GAME names. No other function looks a game up for a task.

    Raises:
        gymnasium.error.NameNotFound: there is no such ID; the message suggests the right one.
        TypeError, ValueError, FileNotFoundError: there is no such game; the message suggests the nearest.
    """
    if isinstance(game, Task):
        return FoundGame(game)
    environment = None
    if isinstance(game, str):
        if re.fullmatch(r"[a-z_]+_v\d+", game) and (environment := find_environment(game)) is not None:
            game = environment.game
        elif is_id(game):
            name, fields = fields_of_id(game)
            return FoundGame(games.find(name), game, fields)
    return FoundGame(games.resolve(catalogue_name(game)), environment=environment)


def resolve_frames(game: GameLike, mode: int | None, difficulty: int | None, *, owner: str) -> Task:
    """The task of a function that plays single frames with its own actions, without sticky actions and limits.

    The fields of `game` for observations, actions and rewards are left out.

    Args:
        game, owner: see `look_up` and `FoundGame.task`.
        mode, difficulty: None means the value of `game`.

    Raises:
        gymnasium.error.NameNotFound, TypeError, ValueError, FileNotFoundError: see `Task.of`; ValueError also if `game`
            has another field that such a function cannot honour.
    """
    given = {name: value for name, value in (("mode", mode), ("difficulty", difficulty)) if value is not None}
    fixed = {**BY_FRAME, **{name: DEFAULTS[name] for name in (*GROUPS["observation"], *GROUPS["reward"])}}
    return fix_fields(look_up(game).task(None, given, owner=owner), ("mode", "difficulty"), fixed, owner)[0]


BY_FRAME: Mapping[str, Any] = FrozenDict(
    {"frameskip": 1, "actions": "full", "repeat_action_probability": 0.0, "max_num_frames_per_episode": None}
)
"""The fields of play frame by frame, with all legal actions, none of them sticky, without a limit."""


def fix_fields(
    task: Task, obeyed: Collection[str], fixed: Mapping[str, Any], owner: str
) -> tuple[Task, dict[str, Any]]:
    """A task with the values of `fixed`, and its former values of the changed fields.

    Args:
        task: the whole task.
        obeyed: options that the caller obeys.
        fixed: options that do not matter for the caller, with the values that it plays.
        owner: the caller, for the error.

    Raises:
        ValueError: another option of the task differs from its default.
    """
    played = {name: {**DEFAULTS, **fixed}[name] for name in OPTIONS if name in fixed or name not in obeyed}
    fields = task.as_options()  # here the game's default mode is None
    changed = {name: fields[name] for name, value in played.items() if fields[name] != value}
    for name, value in changed.items():
        if name not in fixed:
            raise ValueError(
                f"{owner} has no place for {name}={value!r}; give the game alone, {task.game!r}, or a task without it"
            )
    return task.replace(**{name: played[name] for name in changed}) if changed else task, changed
