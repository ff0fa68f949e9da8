"""The outputs of pygame: `GameWindow` shows a game's frames with lines of text, `Speaker` plays their samples."""

from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import gymnasium
import numpy as np

from atari.cores import ByteArray
from atari.env.rendering import import_pygame, open_display
from atari.games.game import Game

_TEXT_HEIGHT = 24

_SAMPLES = 512
_FRAMES_PER_BLOCK = 3  # 50 ms; pygame's channel holds one playing and one queued block
_BLOCKS_WAITING = 2
_LOUDNESS = 128  # factor from 8-bit to 16-bit samples, at half of full scale


def start_pygame() -> Any:
    """Import pygame, open its display and return the module.

    Raises:
        gymnasium.error.DependencyNotInstalled: pygame-ce is not installed.
        gymnasium.error.Error: there is no display.
    """
    pygame = import_pygame("playing", "`atari record` needs no window")
    with _needs_display(pygame):
        open_display(pygame)
    return pygame


@contextmanager
def _needs_display(pygame: Any) -> Iterator[None]:
    """Convert pygame's errors to an error: playing needs a display."""
    try:
        yield
    except pygame.error as error:
        pygame.display.quit()
        raise gymnasium.error.Error(
            f"playing needs a display, and there is none ({error}); on a machine without one, use `atari record`"
        ) from None


class GameWindow:
    """A resizable window. Frames keep their aspect ratio.

    Args:
        pygame: the module, see `start_pygame`.
        game: the shown game.
        scale: at the initial size, a pixel has `2 * scale` x `scale` pixels of the display.
        full_screen: fill the display.

    Raises:
        gymnasium.error.Error: the window cannot be opened.
    """

    def __init__(self, pygame: Any, game: Game, scale: int, *, full_screen: bool = False) -> None:
        self._pygame = pygame
        rows, columns = game.screen.shape
        self._size = (2 * scale * columns, scale * rows)
        with _needs_display(pygame):
            self._set_mode(full_screen)
        pygame.font.init()
        self._font = pygame.font.Font(None, _TEXT_HEIGHT)
        pygame.mouse.set_visible(False)

    def show(self, rgb: ByteArray, title: str, text: str = "") -> None:
        """Show a frame, (height, 160, 3) uint8, with lines of text over it."""
        pygame = self._pygame
        surface = pygame.display.get_surface()
        width, height = surface.get_size()
        zoom = min(width / self._size[0], height / self._size[1])
        size = (round(self._size[0] * zoom), round(self._size[1] * zoom))
        image = pygame.transform.scale(pygame.surfarray.make_surface(rgb.swapaxes(0, 1)), size)
        corner = ((width - size[0]) // 2, (height - size[1]) // 2)
        surface.fill((0, 0, 0))
        surface.blit(image, corner)
        bottom = corner[1] + size[1] - 8
        for words in reversed(text.splitlines()):
            line = self._font.render(words, True, (255, 255, 255), (0, 0, 0))
            bottom -= line.get_height()
            surface.blit(line, (corner[0] + 8, bottom))
        pygame.display.set_caption(title)
        pygame.display.flip()

    def toggle_full_screen(self) -> None:
        """Switch between full screen and a window."""
        self._set_mode(not self._full_screen)

    def _set_mode(self, full_screen: bool) -> None:
        pygame = self._pygame
        self._full_screen = full_screen
        if full_screen:
            pygame.display.set_mode((0, 0), pygame.FULLSCREEN)
        else:
            pygame.display.set_mode(self._size, pygame.RESIZABLE)

    def close(self) -> None:
        """Close the window."""
        self._pygame.font.quit()
        self._pygame.display.quit()


class Speaker:
    """An audio output with a short queue. Early samples are queued; a full queue drops its oldest block.

    Args:
        pygame: the module pygame.
        frames_per_second: the game's frame rate; a frame has 512 samples.
    """

    def __init__(self, pygame: Any, frames_per_second: float) -> None:
        self.muted = False
        self._mixer: Any = pygame.mixer
        self._frames: list[ByteArray] = []
        self._waiting: deque[Any] = deque(maxlen=_BLOCKS_WAITING)
        try:
            # With allowedchanges=0 SDL resamples to the device's rate.
            self._mixer.init(round(_SAMPLES * frames_per_second), -16, 1, _SAMPLES, allowedchanges=0)
        except pygame.error as error:
            self.error: str | None = str(error)
            return
        self.error = None
        self._channel: Any = self._mixer.Channel(0)

    def play(self, samples: ByteArray) -> None:
        """Queue the samples of a frame, (512,) uint8; without a working device, do nothing."""
        if self.error is not None:
            return
        self._frames.append(np.full_like(samples, 128) if self.muted else samples)
        if len(self._frames) == _FRAMES_PER_BLOCK:
            block = (np.concatenate(self._frames).astype(np.int16) - 128) * _LOUDNESS
            self._frames.clear()
            self._waiting.append(self._mixer.Sound(buffer=block.tobytes()))
        if self._waiting and not self._channel.get_busy():
            self._channel.play(self._waiting.popleft())
        elif self._waiting and self._channel.get_queue() is None:
            self._channel.queue(self._waiting.popleft())

    def close(self) -> None:
        """Close the mixer."""
        if self.error is None:
            self._mixer.quit()
