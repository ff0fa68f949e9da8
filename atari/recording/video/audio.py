"""Encoding the samples of emulated frames as a sound track that stays synchronous with the video.

After each frame ALE runs the console's sound generator for 512 clocks. `core.audio()` returns one unsigned sample per
clock, 128 is silence. On the console the generator runs twice a line: 524 clocks a frame with NTSC, 31,400 a second.
Played at 31,400 Hz, the sound of one hour would end 82 seconds before the video. Here the 512 samples fill their frame
exactly: the sample rate is 512 * frame rate (30,680.4 Hz with NTSC). The sound never drifts. All pitches are 2.3 %
lower than the console's, two fifths of a semitone (18 % with PAL, whose frames have 624 clocks).

FFmpeg's sample rates are integers, but this rate is a fraction. A resampler uses only the ratio of two rates, and the
ratio to 48,000 Hz is a fraction of small integers (27379/17500 with NTSC). So the resampler gets these two integers,
and its output is labelled with the format's rate. FLAC needs no resampling, because its samples carry exact times.

At another speed a frame lasts longer or shorter, and so does its sound: it is lower in slow motion, and higher in a
fast video.
"""

from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.cores import ByteArray
from atari.recording.video.formats import Format

SAMPLES_PER_FRAME = 512
_EXACT_RATES = 65_535  # FLAC's greatest sample rate in Hz that is no multiple of 10
_SILENCE = np.full(SAMPLES_PER_FRAME, 128, np.uint8)


class AudioEncoder:
    """The audio stream of a container of `av`: encodes the samples of one emulated frame at a time to packets."""

    def __init__(self, av: Any, container: Any, format: Format, frame_rate: Fraction) -> None:
        self._av, self._fades_in = av, format.fades_in
        rate = format.sound_rate
        exact = SAMPLES_PER_FRAME * frame_rate
        self._rate = rate or int(round(exact, -1 if exact > _EXACT_RATES else 0))
        self._tick = Fraction(1, rate) if rate else (1 / exact).limit_denominator(2**31 - 1)  # FFmpeg has 32 bits
        self._ratio = Fraction(1) if rate is None else (rate / exact).limit_denominator(1_000_000)
        self._stream = container.add_stream(format.sound, rate=self._rate, layout="mono")
        kind = "s16" if rate is None else "fltp"
        self._resampler = av.AudioResampler(format=kind, layout="mono", rate=self._ratio.numerator)
        self._written = 0

    def write(self, samples: ByteArray | None) -> list[Any]:
        """Encode a frame's (512,) samples, None is silence, and return packets for the container."""
        signed = to_16_bit(_SILENCE if samples is None else samples)
        frame = self._av.AudioFrame.from_ndarray(signed[np.newaxis], format="s16", layout="mono")
        frame.sample_rate = self._ratio.denominator
        return self._encode(self._resampler.resample(frame))

    def finish(self) -> list[Any]:
        """Flush the encoder and return the last packets."""
        return self._encode(self._resampler.resample(None)) + list(self._stream.encode(None))

    def _encode(self, frames: list[Any]) -> list[Any]:
        packets: list[Any] = []
        for frame in frames:
            frame.sample_rate, frame.time_base, frame.pts = self._rate, self._tick, self._written
            self._written += frame.samples
            packets += self._stream.encode(frame)
        return [packet for packet in packets if packet.pts >= 0] if self._fades_in else packets


def to_16_bit(samples: ByteArray) -> npt.NDArray[np.int16]:
    """Return unsigned samples around 128 as signed 16-bit samples, `(samples - 128) * 128`.

    The conversion is lossless and uses half of full scale, because lossy encoders overshoot.
    """
    return (samples.astype(np.int16) - 128) * 128
