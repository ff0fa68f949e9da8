"""The window of `render_mode="human"`, through pygame-ce (extra `play`), and mosaics of many screens."""

import math
import os
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np

from atari.base.extras import import_extra, install_extra
from atari.cores.core import ByteArray
from atari.games.game import Game

_SCALE = 3


def tile(screens: Sequence[ByteArray], columns: int) -> ByteArray:
    """A mosaic of screens, (height, 160, 3) uint8, row by row; the rest of lower screens and of the last row is black.

    Returns:
        (rows * the greatest height, columns * 160, 3) uint8.
    """
    height, width = max(screen.shape[0] for screen in screens), screens[0].shape[1]
    rows = math.ceil(len(screens) / columns)
    mosaic = np.zeros((rows, height, columns, width, 3), np.uint8)
    for index, screen in enumerate(screens):
        mosaic[index // columns, : len(screen), index % columns] = screen
    return mosaic.reshape(rows * height, columns * width, 3)


def import_pygame(use: str, instead: str) -> Any:
    """The module pygame.

    Args:
        use: the feature that needs it, for the error.
        instead: what to use without it, for the error.

    Raises:
        gymnasium.error.DependencyNotInstalled: it is not installed; the message names the extra.
    """
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    return import_extra("pygame", f"{use} needs pygame-ce: {install_extra('play')}; {instead}")


def open_display(pygame: Any) -> None:
    """Start pygame's display.

    Raises:
        pygame.error: there is no display. A display off screen counts only if `SDL_VIDEODRIVER` requests it; SDL
            uses one if it finds no other.
    """
    pygame.display.init()
    if pygame.display.get_driver() == "offscreen" and os.environ.get("SDL_VIDEODRIVER") != "offscreen":
        pygame.display.quit()
        raise pygame.error("SDL found none and would draw off screen")


def draw(pygame: Any, surface: Any, rgb: ByteArray) -> None:
    """Draw an image, (rows, columns, 3) uint8, over the surface of a window, and show it."""
    pygame.event.pump()
    image = pygame.surfarray.make_surface(rgb.swapaxes(0, 1))
    surface.blit(pygame.transform.scale(image, surface.get_size()), (0, 0))
    pygame.display.flip()


class Window:
    """A window that shows the screen of a game at its own speed, with the console's 2:1 pixels.

    Raises:
        gymnasium.error.DependencyNotInstalled: pygame-ce is not installed.
        gymnasium.error.Error: there is no display.
    """

    def __init__(self, game: Game, frames_per_second: float) -> None:
        self._pygame = pygame = import_pygame("render_mode='human'", "render_mode='rgb_array' needs nothing")
        size = (2 * game.screen.width * _SCALE // 2, game.screen.height * _SCALE // 2)
        try:
            open_display(pygame)
            self._surface = pygame.display.set_mode(size)
        except pygame.error as error:
            raise gymnasium.error.Error(
                f"render_mode='human' needs a display and found none ({error}); "
                "use render_mode='rgb_array' to get the screen as an array"
            ) from None
        pygame.display.set_caption(game.title)
        self._clock = pygame.time.Clock()
        self._rate = frames_per_second

    def show(self, rgb: ByteArray) -> None:
        """Show one screen, (height, 160, 3) uint8, and wait until it is time for the next."""
        draw(self._pygame, self._surface, rgb)
        self._clock.tick(self._rate)

    def close(self) -> None:
        """Close the window."""
        self._pygame.display.quit()
