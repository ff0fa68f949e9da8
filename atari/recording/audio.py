"""Sound: from the samples of emulated frames to a sound track that stays with the picture.

After every frame ALE runs the console's sound generator for 512 clocks, and `core.audio()` has them: one sample a
clock, unsigned, 128 is silence. On the console the generator runs twice a line, 524 clocks a frame with NTSC, 31,400 a
second. So 512 samples are too few for a frame, and one of two things must give: played at 31,400 Hz the sound of an
hour would be over 82 seconds before the picture. Here each frame's 512 samples fill that frame, exactly: they are
taken for 512 * frame rate samples a second (30,680.4 with NTSC). The sound never drifts, and all its pitches are 2.3 %
lower than the console's, two fifths of a semitone, alike for all tones (18 % with PAL, whose frames have 624 clocks).

FFmpeg's rates are integers, and that one is not. But a resampler only looks at the ratio of two rates, and the ratio
to 48,000 Hz is a fraction of small numbers (27379/17500 with NTSC): the samples are resampled between these two, which
is exact, and then called what they are. FLAC needs no resampling: its samples carry exact times.
"""

from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.cores import ByteArray
from atari.recording.formats import Format

SAMPLES_PER_FRAME = 512
_SILENCE = np.full(SAMPLES_PER_FRAME, 128, np.uint8)


class SoundTrack:
    """The sound of a movie: takes the samples of a frame at a time and gives encoded packets.

    Args:
        av: the module.
        container: to which to add a stream.
        format: whose sound it is.
        frame_rate: emulated frames a second.
    """

    def __init__(self, av: Any, container: Any, format: Format, frame_rate: Fraction) -> None:
        self._av, self._fades_in = av, format.fades_in
        rate = format.sound_rate
        exact = SAMPLES_PER_FRAME * frame_rate
        self._rate = round(exact) if rate is None else rate
        self._tick = 1 / exact if rate is None else Fraction(1, rate)
        self._ratio = Fraction(1) if rate is None else (rate / exact).limit_denominator(1_000_000)
        self._stream = container.add_stream(format.sound, rate=self._rate, layout="mono")
        kind = "s16" if rate is None else "fltp"
        self._resampler = av.AudioResampler(format=kind, layout="mono", rate=self._ratio.numerator)
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
            frame.sample_rate, frame.time_base, frame.pts = self._rate, self._tick, self._written
            self._written += frame.samples
            packets += self._stream.encode(frame)
        return [packet for packet in packets if packet.pts >= 0] if self._fades_in else packets


def to_16_bit(samples: ByteArray) -> npt.NDArray[np.int16]:
    """Samples around 128 as signed 16 bits around 0, `(samples - 128) * 128`.

    Nothing is lost, and there is room for the encoders, which overshoot.
    """
    signed = samples.astype(np.int16)
    signed -= 128
    signed *= 128
    return signed
