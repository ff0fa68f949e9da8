"""`Viewer`: the window of `render(mode="human")`, through pygame-ce (extra `play`)."""

import os
import sys
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from atari.classic import logger

_LEAST_ROWS = 400  # smaller images are enlarged

_KEYS = {
    "BACKSPACE": 0xFF08,
    "TAB": 0xFF09,
    "RETURN": 0xFF0D,
    "ESCAPE": 0xFF1B,
    "LEFT": 0xFF51,
    "UP": 0xFF52,
    "RIGHT": 0xFF53,
    "DOWN": 0xFF54,
}
"""Numbers of keys in pyglet, Gym's library for windows, by their names in pygame. Other keys have their character's."""

KeyHandler = Callable[[int, int], Any]


class Window:
    """The handlers of keys that a script assigned: functions of the key's number in pyglet and of the modifiers."""

    on_key_press: KeyHandler | None = None
    on_key_release: KeyHandler | None = None


class Viewer:
    """A window that shows images at a given rate. Without a display it prints a warning and shows nothing.

    `isopen` says whether the user has not closed the window. `window` has the handlers of keys; `imshow` calls them.

    Args:
        title: the title of the window.
        frames_per_second: the most images a second; 0 means no limit.
        pixel_aspect: columns and rows of the window for a pixel of an image, such as (2, 1) on an Atari.

    Raises:
        gymnasium.error.DependencyNotInstalled: pygame is not installed.
    """

    def __init__(self, title: str, frames_per_second: float, pixel_aspect: tuple[int, int] = (1, 1)) -> None:
        self.isopen = True
        self.window = Window()
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

    def imshow(self, rgb: npt.NDArray[np.uint8]) -> None:
        """Show one image, (rows, columns, 3) uint8, and wait until it is time for the next.

        Raises:
            gymnasium.error.Error: the display does not work.
        """
        if self._blind or not self.isopen:
            return
        pygame = self._pygame
        # pygame has one display: another environment may have replaced or closed it.
        if self._surface is None or self._surface is not pygame.display.get_surface():
            self._surface = self._open(rgb.shape[0], rgb.shape[1])
        if not self._take_events():
            return
        image = pygame.surfarray.make_surface(rgb.swapaxes(0, 1))
        self._surface.blit(pygame.transform.scale(image, self._surface.get_size()), (0, 0))
        pygame.display.flip()
        if pygame.display.get_driver() != "dummy":  # the dummy driver shows nothing, so no wait
            self._clock.tick(self._rate)

    def close(self) -> None:
        """Close the window."""
        self.isopen = False
        if not self._blind and self._surface is not None:
            self._surface = None
            self._pygame.display.quit()

    def _take_events(self) -> bool:
        """Take the window's events, and key events if the script has a handler; False if the user closed it."""
        pygame, window = self._pygame, self.window
        handlers = {pygame.KEYDOWN: window.on_key_press, pygame.KEYUP: window.on_key_release}
        for event in pygame.event.get([pygame.QUIT, *(kind for kind, handler in handlers.items() if handler)]):
            if event.type == pygame.QUIT:
                self.close()
                return False
            numbers = {getattr(pygame, f"K_{name}"): number for name, number in _KEYS.items()}
            handlers[event.type](numbers.get(event.key, event.key), event.mod)  # type: ignore[misc]
        return True

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
            "env.render() needs pygame-ce: pip install pygame-ce; env.render(mode='rgb_array') needs nothing"
        ) from None
    return pygame


def _has_display() -> bool:
    """Whether there is a display, or `SDL_VIDEODRIVER` is set; without both, SDL would draw off screen."""
    return sys.platform != "linux" or any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")))
