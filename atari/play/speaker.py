"""`Speaker`: plays the samples of each frame through pygame's mixer."""

from collections import deque
from typing import Any

import numpy as np

from atari.cores import ByteArray

SAMPLES = 512
_FRAMES_PER_BLOCK = 3  # 50 ms; pygame's channel holds one playing and one queued block
_BLOCKS_WAITING = 2
_LOUDNESS = 128  # factor from 8-bit to 16-bit samples, at half of full scale


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
            self._mixer.init(round(SAMPLES * frames_per_second), -16, 1, SAMPLES, allowedchanges=0)
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
