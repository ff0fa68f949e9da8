"""`fields_of`: the only way from a user's arguments to the fields of a `Task`."""

from collections.abc import Iterable, Mapping
from typing import Any

import gymnasium

from atari.base.frozen import FrozenDict
from atari.base.validation import check_known
from atari.games.catalog import games
from atari.games.game import Game
from atari.task import env_ids
from atari.task.checks import check_bool
from atari.task.data import TaskData
from atari.task.fields import DEFAULTS, FIELDS, ROWS, check_field
from atari.task.observation_kinds import kind_of
from atari.task.presets import Preset, find_preset
from atari.task.rules import default_ineffective

OPTIONS: tuple[str, ...] = tuple(name for name in FIELDS if name not in ("game", "rules", "rom_md5"))
"""The options of a task: its fields that a user may give beside the game."""

ALIASES: Mapping[str, str] = {"full_action_space": "actions", "clip_reward": "reward_clipping"}
"""Gymnasium's and ale-py's names of options, and ours."""


def fields_of(
    game: Game | TaskData,
    preset: str | None,
    options: Mapping[str, Any],
    base: Mapping[str, Any] = FrozenDict(),
    *,
    owner: str = "Task.of",
    others: Iterable[str] = ("preset",),
) -> dict[str, Any]:
    """The fields of the task of a game and options, see `Task.of`.

    Args:
        game: a game definition or a task.
        preset: name of a preset.
        options: the user's options.
        base: fields that a definition has instead of ALE's v5.
        owner: the function that the user called, for errors.
        others: names of the other options of `owner`, for the suggestion in an error.

    Raises:
        TypeError, ValueError: see `Task.of`.
    """
    given, names = translate(options, owner, others)
    fields = {**DEFAULTS, **base, "game": game}
    if isinstance(game, TaskData):
        fields |= {**{name: getattr(game, name) for name in FIELDS}, "game": game.definition}
        if given.get("players", game.players) != game.players:
            fields["mode"] = None  # each number of players has modes of its own
    ram_stack = None if kind_of(fields["obs_type"]).image else fields["stack_num"]
    if preset is not None:
        chosen = find_preset(preset)
        _require(preset, chosen, {"players": fields["players"], **given}, names, fields["game"])
        kept = {} if kind_of(fields["obs_type"]).image else {"obs_type": fields["obs_type"]}  # presets describe images
        fields |= {**chosen.fields, **kept}
    fields |= given
    if not kind_of(fields["obs_type"]).image:  # other stacks contain images
        fields["stack_num"] = given.get("stack_num", ram_stack)
    default_ineffective(fields, given)
    return fields


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


def is_id(game: str) -> bool:
    """Whether a string is an environment ID, not a game's name or a file."""
    return not game.endswith(".toml") and ("-v" in game or "/" in game or game.startswith(env_ids.MODULE_PREFIX))


def catalogue_name(game: Any) -> Any:
    """A game's name in the catalogue's form: "MsPacman" is "ms_pacman". Anything else is returned unchanged."""
    if not isinstance(game, str) or game in games or game.endswith(".toml"):
        return game
    wanted = game.replace("_", "").lower()
    return next((name for name in games if name.replace("_", "") == wanted), game)


def fields_of_id(env_id: str) -> tuple[str, dict[str, Any]]:
    """The game of a registered ID, by its name, and its other fields.

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
    name = options.pop("game")
    return name, translate(options, env_id)[0]


ENTRY_POINT = "atari.registry.making:make_AtariEnv"
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
    tasks = (TaskData(**fields_of(game, None, {"players": players, "actions": chosen})) for chosen in (actions, wanted))
    own, allowed = (task.action_set for task in tasks)
    return own == allowed or (not isinstance(actions, str) and {*own} <= {*allowed})
