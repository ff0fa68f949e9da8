"""The names of a game's media, and the modes on its sheet."""

from atari.games.game import Game

VIDEO, SCREEN, MODES, VIEWS = "play.mp4", "screen.png", "modes.png", "views.png"


def modes(game: Game) -> tuple[int, ...]:
    """The modes that a page shows: those for one player, or those for several if the game has no others."""
    if game.single_player or game.multiplayer is None:
        return game.modes
    return tuple(sorted(mode for modes in game.multiplayer.modes.values() for mode in modes))
