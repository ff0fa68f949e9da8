"""Sound: from the samples of emulated frames to a sound track that stays with the picture.

After every frame ALE runs the console's sound generator for 512 clocks, and `core.audio()` has them: one sample a
clock, unsigned, 128 is silence. On the console the generator runs twice a line, 524 clocks a frame with NTSC, 31,400 a
second. So 512 samples are not what a frame lasts, and one of two things must give: played at 31,400 Hz the sound would
end 1.4 minutes before an hour of picture does. Here each frame's 512 samples fill that frame, exactly: the sound is
taken to have 512 * frame rate samples a second (30,680.4 with NTSC). It never drifts, and all its pitches are 2.3 %
lower than the console's, two fifths of a semitone, alike for all tones. (With PAL's 624 clocks a frame it is 18 %.)

That rate is no integer, and FFmpeg's are. But a resampler only looks at the ratio of two rates, and the ratio to
48,000 Hz is a fraction of small numbers (27379/17500 with NTSC): the samples are resampled between these two, which is
exact, and then called what they are.
"""

from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.cores import ByteArray

SAMPLES_PER_FRAME = 512
_SILENCE = np.full(SAMPLES_PER_FRAME, 128, np.uint8)
_GAIN = 128
"""From bytes to 16 bits: half of full scale, as the encoders overshoot."""


class SoundTrack:
    """The sound of a movie: takes a frame's samples at a time and gives encoded packets.

    Args:
        av: the module.
        stream: of the container, for sound.
        frame_rate: emulated frames a second.
        resampled: to the stream's rate; else the samples are kept as they are.
    """

    def __init__(self, av: Any, stream: Any, frame_rate: Fraction) -> None:
        self._av, self._stream = av, stream
        self._rate: int = stream.codec_context.sample_rate
        ratio = self._rate / (SAMPLES_PER_FRAME * frame_rate)
        self._ratio = ratio.limit_denominator(1_000_000)
        self._resampler = av.AudioResampler(format="fltp", layout="mono", rate=self._ratio.numerator)
        self._written = 0

    def write(self, samples: ByteArray | None) -> list[Any]:
        """Append a frame's (512,) samples; None is silence. Returns packets for the container."""
        signed = to_16_bit(_SILENCE if samples is None else samples)
        frame = self._av.AudioFrame.from_ndarray(signed[np.newaxis], format="s16", layout="mono")
        frame.sample_rate = self._ratio.denominator
        return self._encode(self._resampler.resample(frame))

    def finish(self) -> list[Any]:
        """The last packets."""
        return self._encode(self._resampler.resample(None)) + list(self._stream.encode(None))

    def _encode(self, frames: list[Any]) -> list[Any]:
        packets: list[Any] = []
        for frame in frames:
            frame.sample_rate = self._rate
            frame.time_base = Fraction(1, self._rate)
            frame.pts = self._written
            self._written += frame.samples
            packets += self._stream.encode(frame)
        return packets


def to_16_bit(samples: ByteArray) -> npt.NDArray[np.int16]:
    """The samples as signed 16 bits around 0: `(samples - 128) * 128`, which nothing is lost in."""
    return (samples.astype(np.int16) - 128) * np.int16(_GAIN)
