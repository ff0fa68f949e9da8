"""What vector environments of games of two to four players accept, and how they differ from those of one player."""

from collections.abc import Sequence
from typing import Any

from atari.games.game import Game
from atari.games.multiplayer import Multiplayer
from atari.multiplayer.core import choose_mode, rules_of
from atari.validation import check_integer

_ONE_PLAYER = ("continuous", "episodic_life", "life_loss_info", "use_fire_reset")
"""Options that have no meaning for several players."""


def fill_defaults(given: dict[str, Any]) -> dict[str, Any]:
    """The options of `AtariVectorEnv`, with the defaults that depend on the number of players.

    Raises:
        ValueError: an option is for one player alone, or for several.
    """
    several = given["players"] is not None
    if not several and given["agent_indicator"]:
        raise ValueError("agent_indicator is for several players; give players=2, or leave it out")
    for name in _ONE_PLAYER:
        if several and given[name]:
            raise ValueError(f"{name} is for games of one player; leave {name}={given[name]!r} or players out")
    if several and given["preset"] not in (None, "dqn"):
        raise ValueError(f"preset of several players must be 'dqn' or None, got {given['preset']!r}")
    coloured = given["obs_type"] == "rgb" or (given["obs_type"] != "ram" and not given["grayscale"])
    if given["agent_indicator"] and coloured and not given["channels_last"]:
        raise ValueError("agent_indicator adds channels, which RGB images have last; add channels_last=True")
    filled = {"noop_max": 0, "use_fire_reset": False} if several else {"noop_max": 30, "use_fire_reset": True}
    missing = {name: value for name, value in filled.items() if given[name] is None}
    if several and given["reward_clipping"] is None and given["clip_reward"] is None:
        missing["reward_clipping"] = False
    return {**given, **missing}


def check_players(players: Any, games: Sequence[Game]) -> int:
    """The number of players, 1 if it is None.

    Raises:
        TypeError, ValueError: it is no such number, or a game is not for so many.
    """
    if players is None:
        return 1
    number = check_integer("players", players, 2, 4)
    for game in set(games):
        choose_mode(rules_of(game), game, None, number, 0)
    return number


def check_modes(
    games: Sequence[Game], modes: Sequence[int | None], difficulties: Sequence[int | None], players: int
) -> tuple[int, ...]:
    """The mode of each environment, in Multi-Agent-ALE's numbering; None is the first for so many players.

    Raises:
        TypeError, ValueError: a game has no such mode or difficulty for so many players.
    """
    for game, difficulty in set(zip(games, difficulties, strict=True)):
        rules = rules_of(game)
        if difficulty is not None and difficulty not in rules.difficulties:
            raise ValueError(f"difficulty of {game.id} must be one of {rules.difficulties}, got {difficulty}")
    return tuple(
        choose_mode(rules_of(game), game, mode, players, 0)[0] for game, mode in zip(games, modes, strict=True)
    )


def choices(game: Game, players: int) -> dict[str, tuple[int, ...]]:
    """The modes and difficulties of a game for so many players."""
    if players == 1:
        return {"mode": game.modes, "difficulty": game.difficulties}
    rules: Multiplayer = rules_of(game)
    return {"mode": rules.modes[players], "difficulty": rules.difficulties}
