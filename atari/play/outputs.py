"""The outputs of pygame: `GameWindow` shows a game's frames with lines of text, `Speaker` plays their samples."""

import re
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import gymnasium
import numpy as np

from atari.cores import ByteArray
from atari.env.rendering import import_pygame, open_display
from atari.games.game import Game

_LINES_PER_WINDOW = 18  # of the largest text
_LEAST_TEXT = 12  # pixels
_BEHIND_TEXT = (0, 0, 0, 216)
_MARGIN = 8

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
        self._panel: Any = None
        self._panel_of: Any = None
        pygame.mouse.set_visible(False)

    def show(self, rgb: ByteArray, title: str, text: str = "") -> None:
        """Show a frame, (height, 160, 3) uint8, with lines of text over it. Two blanks are between columns."""
        pygame = self._pygame
        surface = pygame.display.get_surface()
        width, height = surface.get_size()
        zoom = min(width / self._size[0], height / self._size[1])
        size = (round(self._size[0] * zoom), round(self._size[1] * zoom))
        image = pygame.transform.scale(pygame.surfarray.make_surface(rgb.swapaxes(0, 1)), size)
        corner = ((width - size[0]) // 2, (height - size[1]) // 2)
        surface.fill((0, 0, 0))
        surface.blit(image, corner)
        if text:
            if self._panel_of != (text, size):
                self._panel, self._panel_of = _panel(pygame, text, size), (text, size)
            surface.blit(self._panel, (corner[0], corner[1] + size[1] - self._panel.get_height()))
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


def _panel(pygame: Any, text: str, size: tuple[int, int]) -> Any:
    """Lines of text on a dark ground, as large as `size` has room for."""
    rows = [re.split(r" {2,}", line) for line in text.splitlines()]
    most = size[1] // _LINES_PER_WINDOW
    for height in range(max(most, _LEAST_TEXT), _LEAST_TEXT - 1, -1):
        lines = _Lines(pygame.font.Font(None, round(1.4 * height)), rows, size[0] - 2 * _MARGIN)
        if lines.height <= size[1] - 2 * _MARGIN:
            break
    panel = pygame.Surface((lines.width + 2 * _MARGIN, lines.height + 2 * _MARGIN), pygame.SRCALPHA)
    panel.fill(_BEHIND_TEXT)
    for words, place in lines.placed:
        panel.blit(lines.font.render(words, True, (255, 255, 255)), place)
    return panel


class _Lines:
    """Rows of cells as words with their places: cells of a column begin at one place, and the last one is wrapped.

    Args:
        font: the font.
        rows: the cells of each row.
        width: the width that they may have, in pixels.
    """

    def __init__(self, font: Any, rows: list[list[str]], width: int) -> None:
        self.font = font
        self.placed: list[tuple[str, tuple[int, int]]] = []
        gap, step = font.size("  ")[0], font.get_linesize()
        widths: dict[int, int] = {}
        for row in rows:
            for column, cell in enumerate(row[:-1]):
                widths[column] = max(widths.get(column, 0), font.size(cell)[0] + gap)
        top, right = _MARGIN, 0
        for row in rows:
            left = _MARGIN
            for column, cell in enumerate(row):
                for line in self._wrapped(cell, width + _MARGIN - left) if column == len(row) - 1 else [cell]:
                    self.placed.append((line, (left, top)))
                    right = max(right, left + font.size(line)[0])
                    top += step * (column == len(row) - 1)
                left += widths.get(column, 0)
        self.width, self.height = min(right - _MARGIN, width), top - _MARGIN

    def _wrapped(self, text: str, width: int) -> list[str]:
        lines = [""]
        for word in text.split():
            longer = f"{lines[-1]} {word}".strip()
            if lines[-1] and self.font.size(longer)[0] > width:
                lines.append(word)
            else:
                lines[-1] = longer
        return lines


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
