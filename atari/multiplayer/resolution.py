"""`resolve_several`: the task of a game and options, with PettingZoo's names."""

from collections.abc import Iterable, Mapping
from typing import Any

from atari.games.pettingzoo import ENVIRONMENTS, Environment, find_environment, split_name
from atari.games.players import choose_mode, pettingzoo_options, rules_of
from atari.task import Task
from atari.task.resolution import catalogue_name, is_id
from atari.task.task import FoundGame, GameLike, look_up

_NONE_IS_NOT_GIVEN = ("mode", "players", "difficulty")


def resolve_several(
    game: GameLike,
    preset: str | None,
    options: Mapping[str, Any],
    base: Mapping[str, Any],
    owner: str,
    others: Iterable[str],
    ale_numbers: bool = False,
) -> tuple[Task, str]:
    """The task of a game for several players, and the name of its environment in PettingZoo.

    Args:
        game: GAME; or a name of PettingZoo's with or without its version.
        preset, base, owner, others: see `FoundGame.task`.
        options: fields of a task, and parameters of PettingZoo's environment.
        ale_numbers: whether `mode` has ale-py's numbers.

    Raises:
        gymnasium.error.NameNotFound, TypeError, ValueError, FileNotFoundError: see `look_up`; or the game has no
            rules for several players.
    """
    options = {name: value for name, value in options.items() if value is not None or name not in _NONE_IS_NOT_GIVEN}
    environment = _environment(game)
    found = look_up(game if environment is None else environment.game)
    offset = rules_of(found.definition).mode_offset if ale_numbers else 0
    if environment is not None:
        options = pettingzoo_options(environment, options, offset)
    else:
        options = {**options, **_mode_and_players(found, options, offset)}
    name = f"custom_{found.definition.id}" if environment is None else environment.id
    return found.task(preset, options, base, owner=owner, others=("preset", *others)), name


def _environment(game: GameLike) -> Environment | None:
    """PettingZoo's environment with a name; IDs and files have none."""
    if not isinstance(game, str) or game.endswith(".toml"):
        return None
    if is_id(game) and split_name(game)[0] not in ENVIRONMENTS:
        return None
    return find_environment(catalogue_name(game))


def _mode_and_players(found: FoundGame, options: Mapping[str, Any], offset: int) -> dict[str, int]:
    mode, players, definition = options.get("mode"), options.get("players"), found.definition
    if isinstance(task := found.game, Task):
        if players is None and task.players == 1:
            raise ValueError(
                f"the task of {task.game} is for one player; add players={min(rules_of(definition).modes)}"
            )
        players = task.players if players is None else players
        if mode is None and players == task.players:
            mode, offset = task.mode, 0
    mode, players = choose_mode(definition, mode, players, offset)
    return {"mode": mode, "players": players}
