"""Screens for people: the window of `render_mode="human"`, through pygame-ce (extra `play`), and mosaics of many."""

import math
import os
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np

from atari.cores.protocol import ByteArray
from atari.game import Game

_SCALE = 3


def tile(screens: Sequence[ByteArray], columns: int) -> ByteArray:
    """Screens (height, 160, 3) uint8 as one picture, row by row; lower ones and places left over are filled with black.

    Returns:
        (rows * the greatest height, columns * 160, 3) uint8.
    """
    height, width = max(screen.shape[0] for screen in screens), screens[0].shape[1]
    rows = math.ceil(len(screens) / columns)
    picture = np.zeros((rows, height, columns, width, 3), np.uint8)
    for index, screen in enumerate(screens):
        picture[index // columns, : len(screen), index % columns] = screen
    return picture.reshape(rows * height, columns * width, 3)


def import_pygame(use: str, instead: str) -> Any:
    """The module pygame.

    Args:
        use: what needs it.
        instead: what to do without it.

    Raises:
        gymnasium.error.DependencyNotInstalled: it is not installed; the text names the extra.
    """
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    try:
        import pygame
    except ImportError:
        raise gymnasium.error.DependencyNotInstalled(
            f"{use} needs pygame-ce: pip install 'atari-envs[play]'; {instead}"
        ) from None
    return pygame


def open_display(pygame: Any) -> None:
    """Start pygame's display.

    Raises:
        pygame.error: there is none. SDL then falls back to drawing where nobody sees it, unless that is asked for.
    """
    pygame.display.init()
    if pygame.display.get_driver() == "offscreen" and os.environ.get("SDL_VIDEODRIVER") != "offscreen":
        pygame.display.quit()
        raise pygame.error("SDL found none and would draw where nobody sees it")


def draw(pygame: Any, surface: Any, rgb: ByteArray) -> None:
    """Fill the surface of a window with a picture, (rows, columns, 3) uint8, and show it."""
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
