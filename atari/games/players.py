"""The rules and the mode of a game of two to four players."""

from collections.abc import Mapping
from typing import Any

from atari.base.validation import check_integer
from atari.games.catalog import games
from atari.games.game import Game
from atari.games.multiplayer import Multiplayer
from atari.games.pettingzoo import ENVIRONMENTS, Environment


def rules_of(game: Game) -> Multiplayer:
    """The game's rules for several players.

    Raises:
        ValueError: it has none; the message names games with such rules.
    """
    if game.multiplayer is None:
        having = ", ".join(sorted(other.id for other in games.values() if other.multiplayer is not None))
        raise ValueError(f"{game.id} has no rules for several players; these games have: {having}")
    return game.multiplayer


def choose_mode(game: Game, mode: int | None, players: int | None, offset: int = 0) -> tuple[int, int]:
    """The mode in Multi-Agent-ALE's numbering, and its number of players.

    The default is the mode of PettingZoo's environment with the game's name, else the first for `players`.

    Args:
        game: the game.
        mode: its number; None means the default.
        players: 2, 3 or 4; None means the number of the mode.
        offset: the difference between the numbers of modes.

    Raises:
        TypeError, ValueError: the game has no such mode, or none for this number of players.
    """
    rules = rules_of(game)
    if players is not None and check_integer("players", players, 1, 4) not in rules.modes:
        raise ValueError(f"{game.id} is for {' or '.join(map(str, rules.modes))} players, got players={players!r}")
    if mode is None:
        mode, offset = _default_mode(game, rules, players), 0
    number = check_integer("mode", mode, -(2**31), 2**31 - 1) - offset
    allowed = {m: n for n, modes in rules.modes.items() if players in (None, n) for m in modes}
    if number not in allowed:
        listed = ", ".join(str(m + offset) for m in sorted(allowed))
        of = f" for {players} players" if players else ""
        raise ValueError(f"mode of {game.id}{of} must be one of {listed}, got {mode!r}")
    return number, allowed[number]


def _default_mode(game: Game, rules: Multiplayer, players: int | None) -> int:
    environment = ENVIRONMENTS.get(game.id)
    if environment is not None:
        mode = environment.choose({"num_players": players} if players and "num_players" in environment.defaults else {})
        if any(mode in modes for count, modes in rules.modes.items() if players in (None, count)):
            return mode
    return rules.modes[players or min(rules.modes)][0]


def pettingzoo_options(environment: Environment, options: Mapping[str, Any], offset: int = 0) -> dict[str, Any]:
    """Options with the mode and the number of players in place of the parameters of a PettingZoo environment.

    Args:
        environment: the environment.
        options: its parameters, and options of a task.
        offset: the difference of the mode's number in `options`.

    Raises:
        TypeError, ValueError: a parameter is wrong, or contradicts another option.
    """
    own = {name: value for name, value in options.items() if name in environment.defaults}
    others = {name: value for name, value in options.items() if name not in own}
    mode, players = others.get("mode"), others.get("players")
    if mode is not None and own:
        raise ValueError(f"give mode or {next(iter(own))}, not both")
    if mode is None and (own or environment.name != environment.game):
        if players not in (None, *environment.players):
            listed = " or ".join(map(str, environment.players))
            raise ValueError(f"{environment.id} is for {listed} players, got players={players!r}")
        several = {"num_players": players} if players and "num_players" in environment.defaults else {}
        mode, offset = environment.choose({**several, **own}), 0
    mode, players = choose_mode(games[environment.game], mode, players, offset)
    return {**others, "mode": mode, "players": players}


def choices(game: Game, players: int) -> dict[str, tuple[int, ...]]:
    """The modes and difficulties of a game for a number of players."""
    if players == 1:
        return {"mode": game.modes, "difficulty": game.difficulties}
    rules = rules_of(game)
    return {"mode": rules.modes[players], "difficulty": rules.difficulties}
