"""The rules and the mode of a game of two to four players."""

from atari.games.catalog import games
from atari.games.game import Game
from atari.games.multiplayer import Multiplayer
from atari.validation import check_integer


def rules_of(game: Game) -> Multiplayer:
    """The game's rules for several players.

    Raises:
        ValueError: it has none; the message names games that have.
    """
    if game.multiplayer is None:
        having = ", ".join(sorted(other.id for other in games.values() if other.multiplayer is not None))
        raise ValueError(f"{game.id} has no rules for several players; these games have: {having}")
    return game.multiplayer


def choose_mode(
    rules: Multiplayer, game: Game, mode: int | None, players: int | None, offset: int = 0
) -> tuple[int, int]:
    """The mode in Multi-Agent-ALE's numbering, and its number of players.

    Raises:
        TypeError, ValueError: the game has no such mode, or none for so many players.
    """
    if players is not None and check_integer("players", players, 1, 4) not in rules.modes:
        raise ValueError(f"{game.id} is for {' or '.join(map(str, rules.modes))} players, got players={players!r}")
    if mode is None:
        players = players or min(rules.modes)
        return rules.modes[players][0], players
    number = check_integer("mode", mode, -(2**31), 2**31 - 1) - offset
    allowed = {m: n for n, modes in rules.modes.items() if players in (None, n) for m in modes}
    if number not in allowed:
        listed = ", ".join(str(m + offset) for m in sorted(allowed))
        of = f" for {players} players" if players else ""
        raise ValueError(f"mode of {game.id}{of} must be one of {listed}, got {mode!r}")
    return number, allowed[number]


def choices(game: Game, players: int) -> dict[str, tuple[int, ...]]:
    """The modes and difficulties of a game for so many players."""
    if players == 1:
        return {"mode": game.modes, "difficulty": game.difficulties}
    rules = rules_of(game)
    return {"mode": rules.modes[players], "difficulty": rules.difficulties}
