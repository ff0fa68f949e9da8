"""Facts for the pages that no data file has: names of media, modes to show, lives in play, names of keys, IDs."""

from functools import cache
from types import MappingProxyType

from atari.cores import NativeCore
from atari.games.actions import Action
from atari.games.game import Game
from atari.play.controls import ALL_KEYS
from atari.task.env_ids import FAMILIES, Family

VIDEO, FILM, SCREEN, MODES, VIEWS = "play.mp4", "play.film", "screen.png", "modes.png", "views.png"
"""The names of a game's media."""

_ARROWS = MappingProxyType({"up": "↑", "down": "↓", "left": "←", "right": "→"})


def shown_modes(game: Game) -> tuple[int, ...]:
    """The modes that a page shows: those for one player, or those for several if the game has no others."""
    if game.single_player or game.multiplayer is None:
        return game.modes
    return tuple(sorted(mode for modes in game.multiplayer.modes.values() for mode in modes))


def lives(game: Game) -> int | None:
    """Lives after the first half second, as `info` has them; None without rules for one player.

    Some games write their byte of lives only after the reset.
    """
    counts = lives_at_start(game)
    return counts[1] if counts else None


@cache
def lives_at_start(game: Game) -> tuple[int, int] | None:
    """Lives at the reset, and after the first half second; None without rules for one player."""
    if not game.single_player:
        return None
    core = NativeCore(game, repeat_action_probability=0.0)
    core.reset()
    at_reset = core.lives
    for _ in range(30):
        core.act(Action.NOOP)
    counts = at_reset, core.lives
    core.close()
    return counts


def families(game: Game) -> list[Family]:
    """The families of IDs that have the game."""
    return [family for family in FAMILIES if game.id in family.games()]


def most_players(game: Game) -> int:
    """The most players of a mode."""
    return game.multiplayer.most_players if game.multiplayer else 1


def keys(action: Action) -> str:
    """The keys of an action in `atari play`, such as "↑ → space"."""
    held = (
        ("up", action.vertical == 1),
        ("down", action.vertical == -1),
        ("left", action.horizontal == -1),
        ("right", action.horizontal == 1),
    )
    names = [_ARROWS[name] for name, on in held if on]
    return " + ".join([*names, *([ALL_KEYS["fire"][0]] if action.fire else [])]) or "none"
