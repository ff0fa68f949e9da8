"""`Speaker`: plays the samples of frames as they come, through pygame's mixer."""

from collections import deque
from typing import Any

import numpy as np

from atari.cores import ByteArray

SAMPLES = 512
_FRAMES_PER_BLOCK = 3  # of 50 ms; pygame keeps one block that plays and one that waits
_BLOCKS_WAITING = 2
_LOUDNESS = 128  # a sample of 8 bits to one of 16, at half of full scale


class Speaker:
    """Sound as steady as the frames are. What comes too early waits, and what would wait too long is left out.

    Args:
        pygame: the module.
        frames_per_second: of the game; each has 512 samples.
    """

    def __init__(self, pygame: Any, frames_per_second: float) -> None:
        self.muted = False
        self._mixer: Any = pygame.mixer
        self._frames: list[ByteArray] = []
        self._waiting: deque[Any] = deque(maxlen=_BLOCKS_WAITING)
        try:
            # No changes allowed: SDL then resamples for the device, whose rate is another one.
            self._mixer.init(round(SAMPLES * frames_per_second), -16, 1, SAMPLES, allowedchanges=0)
        except pygame.error as error:
            self.trouble: str | None = str(error)
            return
        self.trouble = None
        self._channel: Any = self._mixer.Channel(0)

    def play(self, samples: ByteArray) -> None:
        """Play what was heard during a frame, (512,) uint8."""
        if self.trouble is not None:
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
        """Be silent."""
        if self.trouble is None:
            self._mixer.quit()
