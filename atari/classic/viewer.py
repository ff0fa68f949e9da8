"""`Viewer`: the window of `render(mode="human")`, through pygame-ce (extra `play`)."""

import os
import sys
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

_BLIND = ("dummy", "offscreen")  # SDL's drivers that draw where nobody sees it
_LEAST_ROWS = 400  # smaller pictures are shown larger


class Viewer:
    """A window that shows pictures at a rate; where there is no display, it says so once and shows nothing.

    Args:
        title: of the window.
        frames_per_second: how many pictures to show a second, at most.
        pixel_aspect: how many columns and rows of the window make a pixel of a picture, such as (2, 1) on an Atari.

    Raises:
        gymnasium.error.DependencyNotInstalled: pygame is not installed.
    """

    def __init__(self, title: str, frames_per_second: float, pixel_aspect: tuple[int, int] = (1, 1)) -> None:
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
        try:
            import pygame
        except ImportError:
            raise gymnasium.error.DependencyNotInstalled(
                "env.render() needs pygame-ce: pip install 'atari-envs[play]'"
            ) from None
        self._pygame: Any = pygame
        self._title, self._rate, self._aspect = title, frames_per_second, pixel_aspect
        self._clock = pygame.time.Clock()
        self._surface: Any = None

    def show(self, rgb: npt.NDArray[np.uint8]) -> None:
        """Show one picture, (rows, columns, 3) uint8, and wait until it is time for the next."""
        pygame = self._pygame
        # pygame has one display: another environment may have taken or closed it.
        if self._surface is None or (self._surface and self._surface is not pygame.display.get_surface()):
            self._surface = self._open(rgb.shape[0], rgb.shape[1])
        if self._surface is False:
            return
        pygame.event.pump()
        image = pygame.surfarray.make_surface(rgb.swapaxes(0, 1))
        self._surface.blit(pygame.transform.scale(image, self._surface.get_size()), (0, 0))
        pygame.display.flip()
        if pygame.display.get_driver() not in _BLIND:  # where nobody watches, nobody needs the time to
            self._clock.tick(self._rate)

    def close(self) -> None:
        """Close the window."""
        surface, self._surface = self._surface, None
        if surface:
            self._pygame.display.quit()

    def _open(self, rows: int, columns: int) -> Any:
        """The window's surface; False if there is no display."""
        pygame = self._pygame
        scale = max(1, -(-_LEAST_ROWS // rows))
        try:
            pygame.display.init()
            surface = pygame.display.set_mode((scale * columns * self._aspect[0], scale * rows * self._aspect[1]))
        except pygame.error:
            surface = False
        blind = not surface or pygame.display.get_driver() in _BLIND
        if blind and "SDL_VIDEODRIVER" not in os.environ:  # else it was asked for
            print(
                "atari.classic: there is no display, so env.render() shows nothing; "
                "env.render(mode='rgb_array') returns the picture",
                file=sys.stderr,
            )
        if surface:
            pygame.display.set_caption(self._title)
        return surface
