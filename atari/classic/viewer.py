"""`Viewer`: the window of `render(mode="human")`, through pygame-ce (extra `play`)."""

import os
import sys
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from atari.classic import logger

_LEAST_ROWS = 400  # smaller images are enlarged


class Viewer:
    """A window that shows images at a given rate. Without a display it prints a warning and shows nothing.

    Args:
        title: the title of the window.
        frames_per_second: the most images a second.
        pixel_aspect: columns and rows of the window for a pixel of an image, such as (2, 1) on an Atari.

    Raises:
        gymnasium.error.DependencyNotInstalled: pygame is not installed.
    """

    def __init__(self, title: str, frames_per_second: float, pixel_aspect: tuple[int, int] = (1, 1)) -> None:
        self._blind = not _has_display()
        if self._blind:
            logger.warn_once(
                "there is no display, so env.render() shows nothing; env.render(mode='rgb_array') returns the image"
            )
            return
        self._pygame = pygame = _import_pygame()
        self._title, self._rate, self._aspect = title, frames_per_second, pixel_aspect
        self._clock = pygame.time.Clock()
        self._surface: Any = None

    def show(self, rgb: npt.NDArray[np.uint8]) -> None:
        """Show one image, (rows, columns, 3) uint8, and wait until it is time for the next.

        Raises:
            gymnasium.error.Error: the display does not work.
        """
        if self._blind:
            return
        pygame = self._pygame
        # pygame has one display: another environment may have replaced or closed it.
        if self._surface is None or self._surface is not pygame.display.get_surface():
            self._surface = self._open(rgb.shape[0], rgb.shape[1])
        pygame.event.pump()
        image = pygame.surfarray.make_surface(rgb.swapaxes(0, 1))
        self._surface.blit(pygame.transform.scale(image, self._surface.get_size()), (0, 0))
        pygame.display.flip()
        if pygame.display.get_driver() != "dummy":  # the dummy driver shows nothing, so no wait
            self._clock.tick(self._rate)

    def close(self) -> None:
        """Close the window."""
        if not self._blind and self._surface is not None:
            self._surface = None
            self._pygame.display.quit()

    def _open(self, rows: int, columns: int) -> Any:
        pygame = self._pygame
        scale = max(1, -(-_LEAST_ROWS // rows))
        try:
            pygame.display.init()
            surface = pygame.display.set_mode((scale * columns * self._aspect[0], scale * rows * self._aspect[1]))
        except pygame.error as error:
            raise gymnasium.error.Error(
                f"env.render() needs a display, and the one here does not work ({error}); set the environment variable "
                "SDL_VIDEODRIVER=dummy to go without, or call env.render(mode='rgb_array') for an array"
            ) from None
        pygame.display.set_caption(self._title)
        return surface


def _import_pygame() -> Any:
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    try:
        import pygame
    except ImportError:
        raise gymnasium.error.DependencyNotInstalled(
            "env.render() needs pygame-ce: pip install 'atari-envs[play]'; env.render(mode='rgb_array') needs nothing"
        ) from None
    return pygame


def _has_display() -> bool:
    """Whether there is a display, or `SDL_VIDEODRIVER` is set; without both, SDL would draw off screen."""
    return sys.platform != "linux" or any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")))
