"""`resolve_task`: the only way from a user's arguments to a `Task`."""

import re
from collections.abc import Collection, Iterable, Mapping
from os import PathLike
from typing import Any

import gymnasium

from atari import env_ids
from atari.games.catalog import games
from atari.games.frozen import FrozenDict
from atari.games.game import Game
from atari.games.pettingzoo import find_environment
from atari.games.players import options_of
from atari.task.checks import check_bool
from atari.task.fields import DEFAULTS, FIELDS, GROUPS, ROWS, check_field
from atari.task.kinds import kind_of
from atari.task.presets import Preset, find_preset
from atari.task.rules import settle
from atari.task.task import Task
from atari.validation import check_known

OPTIONS: tuple[str, ...] = tuple(name for name in FIELDS if name not in ("game", "rules", "rom_md5"))
"""The options of a task: its fields that a user may give beside the game."""

ALIASES: Mapping[str, str] = {"full_action_space": "actions", "clip_reward": "reward_clipping"}
"""Gymnasium's and ale-py's names of options, and ours."""

GameLike = str | PathLike[str] | Game | Task


def resolve_task(
    game: GameLike,
    preset: str | None,
    options: Mapping[str, Any],
    *,
    base: Mapping[str, Any] | None = None,
    owner: str = "Task.of",
    others: Iterable[str] = ("preset",),
) -> Task:
    """The task of a game and options, see `Task.of`.

    Args:
        game: an ID, a game or a task.
        preset: name of a preset.
        options: the user's options.
        base: fields that a bare name, a file or a `Game` has instead of ALE's v5, unless there is a preset.
        owner: the function that the user called, for errors.
        others: names of the other options of `owner`, for the suggestion in an error.

    Raises:
        gymnasium.error.NameNotFound, TypeError, ValueError, FileNotFoundError: see `Task.of`.
    """
    if isinstance(game, str) and is_versioned(game) and (environment := find_environment(game)) is not None:
        game, options = games[environment.game], options_of(environment, options)
    given, names = translate(options, owner, others)
    fields = {**DEFAULTS, **_start(game, {} if preset is not None or base is None else base, given)}
    ram_stack = None if kind_of(fields["obs_type"]).image else fields["stack_num"]
    if preset is not None:
        chosen = find_preset(preset)
        _require(preset, chosen, {"players": fields["players"], **given}, names, fields["game"])
        fields |= _fitting(chosen, fields)
    fields |= given
    if not kind_of(fields["obs_type"]).image:  # other stacks contain images
        fields["stack_num"] = given.get("stack_num", ram_stack)
    settle(fields, given)
    return Task(**fields)


def resolve_for_agent(
    game: GameLike, preset: str | None, options: Mapping[str, Any], *, default: str = "baselines", owner: str
) -> Task:
    """The task of an agent, which needs preprocessing: like `resolve_task`, but an ID decides only part of it.

    An ID decides the sticky actions, the actions and RAM; the preset decides the rest. A `Task` is played unchanged
    unless a preset is named.

    Args:
        game, options, owner: see `resolve_task`.
        preset: name of a preset; None means `default`.
        default: the preset of a game or an ID.

    Raises:
        gymnasium.error.NameNotFound, TypeError, ValueError, FileNotFoundError: see `Task.of`; ValueError also if the
            preset requires an option that the ID does not have.
    """
    if isinstance(game, Task) and preset is None:
        return resolve_task(game, None, options, owner=owner)
    name = preset or default
    if not (isinstance(game, str) and is_id(game)):
        return resolve_task(game, name, options, owner=owner)
    given, _ = translate(options, owner)
    of_id = resolve_task(game, None, {}, owner=owner)
    kept = {field: getattr(of_id, field) for field in ("repeat_action_probability", "actions") if field not in given}
    chosen = find_preset(name)
    for field in chosen.required:
        if field in kept and of_id.differences(of_id.replace(**{field: chosen.fields[field]})):
            raise ValueError(
                f"preset {name!r} needs {field}={chosen.fields[field]!r}, and {game} has {kept[field]!r}; "
                f"use the game's name, {of_id.game!r}, or another preset"
            )
    return resolve_task(game, name, {**kept, **options}, owner=owner)


def resolve_frames(game: GameLike, mode: int | None, difficulty: int | None, *, owner: str) -> Task:
    """The task of a function that plays single frames with its own actions, without sticky actions and limits.

    The fields of `game` for observations, actions and rewards are left out.

    Args:
        game, owner: see `resolve_task`.
        mode, difficulty: None means the value of `game`.

    Raises:
        gymnasium.error.NameNotFound, TypeError, ValueError, FileNotFoundError: see `Task.of`; ValueError also if `game`
            has another field that such a function cannot honour.
    """
    given = {name: value for name, value in (("mode", mode), ("difficulty", difficulty)) if value is not None}
    fixed = {**BY_FRAME, **{name: DEFAULTS[name] for name in (*GROUPS["observation"], *GROUPS["reward"])}}
    return leave_out(resolve_task(game, None, given, owner=owner), ("mode", "difficulty"), fixed, owner)[0]


BY_FRAME: Mapping[str, Any] = FrozenDict(
    {"frameskip": 1, "actions": "full", "repeat_action_probability": 0.0, "max_num_frames_per_episode": None}
)
"""The fields of play frame by frame, with all legal actions, none of them sticky, without a limit."""


def leave_out(task: Task, obeyed: Collection[str], fixed: Mapping[str, Any], owner: str) -> tuple[Task, dict[str, Any]]:
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
    fields = task.plain()  # here the game's default mode is None
    changed = {name: fields[name] for name, value in played.items() if fields[name] != value}
    for name, value in changed.items():
        if name not in fixed:
            raise ValueError(
                f"{owner} has no place for {name}={value!r}; give the game alone, {task.game!r}, or a task without it"
            )
    return Task.of(task, **{name: played[name] for name in changed}) if changed else task, changed


def translate(
    options: Mapping[str, Any], owner: str, others: Iterable[str] = ()
) -> tuple[dict[str, Any], dict[str, str]]:
    """The checked fields of options, and the name under which a user gave each of them.

    Raises:
        TypeError, ValueError: there is no such option (the message suggests the nearest), its value is wrong, or it is
            given under two names.
    """
    known = (*OPTIONS, *ALIASES)
    check_known(owner, [name for name in options if name not in known], (*known, *others))
    fields: dict[str, Any] = {}
    names: dict[str, str] = {}
    for name, value in options.items():
        field = ALIASES.get(name, name)
        if value is None and ROWS[field].accepts:  # not given, as in ale-py
            continue
        if field in names:
            raise TypeError(f"{names[field]} and {name} are two names of one option; give one of them")
        if name == "full_action_space":
            value = "full" if check_bool(name, value) else "minimal"
        fields[field], names[field] = check_field(field, value), name
    return fields, names


def _start(game: GameLike, base: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """The fields that the game decides."""
    if isinstance(game, Task):
        fields = {name: getattr(game, name) for name in FIELDS}
        if given.get("players", game.players) != game.players:
            fields["mode"] = None  # each number of players has modes of its own
        return {**fields, "game": game.definition}
    if isinstance(game, str) and is_id(game):
        return _of_id(game)
    several = given.get("players", 1) > 1
    return {**base, "game": games.resolve(spelled(game)) if several else games.find(spelled(game))}


def is_versioned(game: Any) -> bool:
    """Whether a game has a name of PettingZoo's with a version, such as "pong_v3"."""
    return isinstance(game, str) and re.fullmatch(r"[a-z_]+_v\d+", game) is not None


def is_id(game: str) -> bool:
    """Whether a string is an environment ID, not a game's name or a file."""
    return not game.endswith(".toml") and ("-v" in game or "/" in game or game.startswith(env_ids.MODULE_PREFIX))


def spelled(game: Any) -> Any:
    """A game's name in the catalogue's form: "MsPacman" is "ms_pacman". Anything else is returned unchanged."""
    if not isinstance(game, str) or game in games or game.endswith(".toml"):
        return game
    wanted = game.replace("_", "").lower()
    return next((name for name in games if name.replace("_", "") == wanted), game)


def _of_id(env_id: str) -> dict[str, Any]:
    """The fields of a registered ID.

    Raises:
        gymnasium.error.NameNotFound: there is no such ID, or its environment is no Atari game.
    """
    known = env_id.removeprefix(env_ids.MODULE_PREFIX)
    if known in env_ids.ids():
        family, game = env_ids.ids()[known]
        options = family.options(game)
    else:
        spec = gymnasium.registry.get(known)
        if spec is None or not is_ours(spec.entry_point):
            raise env_ids.not_found(env_id, known_ids())
        options = {name: value for name, value in spec.kwargs.items() if name not in ("rom", "base")}
    game = options.pop("game")
    return {**translate(options, env_id)[0], "game": games.find(game)}


ENTRY_POINT = "atari.making:make_AtariEnv"
"""The function that `gymnasium.make` calls for an Atari game. Other programs find Atari games by the word AtariEnv."""


def is_ours(entry_point: Any) -> bool:
    """Whether an entry point in Gymnasium's registry belongs to this package's Atari games."""
    return bool(entry_point == ENTRY_POINT)


def known_ids() -> tuple[str, ...]:
    """Every ID that `atari.make` accepts: `ids`, the algorithmic tasks, and registered games."""
    others = (env_id for env_id, spec in gymnasium.registry.items() if str(spec.entry_point).startswith("atari."))
    return tuple(dict.fromkeys([*env_ids.ids(), *others]))


def _require(name: str, preset: Preset, given: Mapping[str, Any], names: Mapping[str, str], game: Game) -> None:
    """Refuse an option that contradicts what a preset requires."""
    players = given["players"]
    if players > 1 and (preset.fields["episodic_life"] or preset.fields.get("fire", "never") != "never"):
        raise ValueError(f"preset {name!r} is for one player; use 'multiplayer_dqn', or leave players={players} out")
    for field in preset.required:
        wanted = preset.fields[field]
        if field not in given or given[field] == wanted:
            continue
        if field == "actions" and _within(game, players, given[field], wanted):
            continue
        shown, value = wanted, given[field]
        if names[field] == "full_action_space":
            shown, value = wanted == "full", given[field] == "full"
        raise ValueError(f"preset {name!r} needs {names[field]}={shown!r}, got {value!r}; leave it out")


def _within(game: Game, players: int, actions: Any, wanted: str) -> bool:
    """Whether an agent that has these actions plays the game of a preset that requires a set of them."""
    tasks = (resolve_task(game, None, {"players": players, "actions": chosen}) for chosen in (actions, wanted))
    own, allowed = (task.action_set for task in tasks)
    return own == allowed or (not isinstance(actions, str) and {*own} <= {*allowed})


def _fitting(preset: Preset, fields: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a preset for a game or task. RAM observations stay, because a preset only describes images."""
    chosen = dict(preset.fields)
    if not kind_of(fields["obs_type"]).image:
        del chosen["obs_type"]
    return chosen
