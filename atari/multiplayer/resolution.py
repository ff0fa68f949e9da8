"""`resolve_several`: the task of a game and options, with PettingZoo's names."""

from collections.abc import Iterable, Mapping
from typing import Any

from atari.games.catalog import games
from atari.games.game import Game
from atari.games.pettingzoo import ENVIRONMENTS, Environment, find_environment, split_name
from atari.games.players import choose_mode, options_of, rules_of
from atari.task import Task
from atari.task.resolution import is_id, spelled
from atari.task.task import GameLike, resolve_task

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
        game: see `resolve_task`; or a name of PettingZoo's with or without its version.
        preset, base, owner, others: see `resolve_task`.
        options: fields of a task, and parameters of PettingZoo's environment.
        ale_numbers: whether `mode` has ale-py's numbers.

    Raises:
        gymnasium.error.NameNotFound, TypeError, ValueError, FileNotFoundError: see `resolve_task`; or the game has no
            rules for several players.
    """
    options = {name: value for name, value in options.items() if value is not None or name not in _NONE_IS_NOT_GIVEN}
    environment = _environment(game)
    if environment is not None:
        name, game = environment.id, games[environment.game]
        options = options_of(environment, options, _offset(game, ale_numbers))
    else:
        definition = _definition(game)
        name = f"custom_{definition.id}"
        options = {**options, **_mode_and_players(game, definition, options, _offset(definition, ale_numbers))}
    return resolve_task(game, preset, options, base=base, owner=owner, others=("preset", *others)), name


def _environment(game: GameLike) -> Environment | None:
    """PettingZoo's environment with a name; IDs and files have none."""
    if not isinstance(game, str) or game.endswith(".toml"):
        return None
    if is_id(game) and split_name(game)[0] not in ENVIRONMENTS:
        return None
    return find_environment(spelled(game))


def _definition(game: GameLike) -> Game:
    if isinstance(game, Task):
        return game.definition
    return resolve_task(game, None, {}).definition if isinstance(game, str) and is_id(game) else games.resolve(game)


def _mode_and_players(game: GameLike, definition: Game, options: Mapping[str, Any], offset: int) -> dict[str, int]:
    mode, players = options.get("mode"), options.get("players")
    if isinstance(game, Task) and players is None:
        if game.players == 1:
            raise ValueError(
                f"the task of {game.game} is for one player; add players={min(rules_of(definition).modes)}"
            )
        players = game.players
    if isinstance(game, Task) and mode is None and players == game.players:
        mode, offset = game.mode, 0
    mode, players = choose_mode(definition, mode, players, offset)
    return {"mode": mode, "players": players}


def _offset(game: Game, ale_numbers: bool) -> int:
    return rules_of(game).mode_offset if ale_numbers else 0
