"""Films of recorded games: pictures, facts and sound, which a page shows to readers who do not have the ROM.

A film is a zlib stream. Integers are little-endian:

    size  content
    4     magic, b"A26F"
    1     version, 1
    1     number of colours - 1
    2     rows of the screen
    4     frames of the film, n
    4     frames of the whole recording
    2     frames a second, times 100
    1     players
    1     0
    3     for each colour: red, green, blue
    ...   for each frame: a bit for each row, the first in the highest bit of the first byte, which says whether the
          frame has this row; then these rows, each with the number of a colour for each of its 160 pixels. Frame 0 and
          each 300th frame have all rows, the others those that differ from the frame before
    4 n   for each frame: the score of the first player, signed
    4 n   the score of the second player; 0 if there is none
    4 n   the lives of the first player
    512 n the sound of each frame, uint8
"""

import struct
import zlib
from collections.abc import Iterable, Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt

ByteArray = npt.NDArray[np.uint8]

MOST_BYTES = 1 << 26
"""The most bytes of the frames before their compression, 32 seconds in which all pixels change; a film ends before the
frame that would exceed them."""

FRAMES_PER_KEY_FRAME = 300
_HEADER = struct.Struct("<4sBBHIIHBB")
_FACTS_SIZE = 12
_MOST_COLOURS = 256


class FilmFrame(Protocol):
    """A recorded frame; `atari.recording.Replay.frames` yields such frames."""

    @property
    def screen(self) -> ByteArray:
        """The pixels, (height, 160, 3) RGB."""

    @property
    def audio(self) -> ByteArray:
        """The sound, (512,) samples."""

    @property
    def scores(self) -> Sequence[int]:
        """The score of each player."""

    @property
    def lives(self) -> int:
        """The lives of the first player."""


def film(frames: Iterable[FilmFrame], total: int, rate: float, players: int = 1) -> bytes:
    """A film of frames, as the text above describes it.

    Args:
        frames: the frames, at least one. The film has those that fit in `MOST_BYTES`.
        total: the number of frames of the whole recording.
        rate: frames a second.
        players: the number of players.

    Raises:
        ValueError: there is no frame, or the screens have more than 256 colours.
    """
    pictures = _Pictures()
    sound: list[bytes] = []
    facts: list[tuple[int, int, int]] = []
    size = 0
    for frame in frames:
        picture, samples = pictures.packed(frame.screen), frame.audio.tobytes()
        size += len(picture) + len(samples) + _FACTS_SIZE
        if size > MOST_BYTES:
            break
        pictures.parts.append(picture)
        sound.append(samples)
        scores = (*frame.scores, 0)
        facts.append((scores[0], scores[1], frame.lives))
    if not facts:
        raise ValueError("a film needs a frame")
    colours = pictures.colours
    numbers = (len(colours) - 1, pictures.rows, len(facts), total, round(100 * rate), players)
    packer = zlib.compressobj()
    parts = [_HEADER.pack(b"A26F", 1, *numbers, 0), colours.tobytes(), *pictures.parts]
    parts += [np.array(facts, "<i4").T.tobytes(), *sound]
    return b"".join([*map(packer.compress, parts), packer.flush()])


def frames_of(packed: bytes) -> int:
    """The number of frames of a film."""
    return int(_HEADER.unpack(zlib.decompressobj().decompress(packed, _HEADER.size))[4])


class _Pictures:
    """The pictures of a film.

    `parts` has the rows of each frame, and `colours`, (n, 3), the colours in the order in which they were first seen.
    """

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self.colours = np.zeros((0, 3), np.uint8)
        self.rows = 0
        self._number = np.zeros(1 << 24, np.uint16)  # of each colour, 1 for the first; 0 is not seen yet
        self._before: ByteArray | None = None

    def packed(self, screen: ByteArray) -> bytes:
        """The rows of the next frame."""
        if self._before is None or len(self.parts) % FRAMES_PER_KEY_FRAME == 0:
            changed = np.ones(len(screen), np.bool_)
        else:
            changed = (screen != self._before).reshape(len(screen), -1).any(axis=1)
        self._before, self.rows = screen, len(screen)
        return np.packbits(changed).tobytes() + self._numbers(screen[changed]).tobytes()

    def _numbers(self, pixels: ByteArray) -> ByteArray:
        """The numbers of the colours of pixels."""
        padded = np.zeros((*pixels.shape[:-1], 4), np.uint8)
        padded[..., :3] = pixels
        keys = padded.view("<u4")[..., 0]
        numbers = self._number[keys]
        if not numbers.all():
            new = np.unique(keys[numbers == 0])
            known = len(self.colours)
            if known + len(new) > _MOST_COLOURS:
                raise ValueError(f"a film has at most {_MOST_COLOURS} colours; these screens have more")
            self._number[new] = np.arange(known, known + len(new)) + 1
            self.colours = np.concatenate([self.colours, new.astype("<u4").view(np.uint8).reshape(-1, 4)[:, :3]])
            numbers = self._number[keys]
        return (numbers - 1).astype(np.uint8)
