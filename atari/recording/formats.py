"""The kinds of files that a recording can be, by the ending of their name, and how each is encoded.

The choices: what nearly every program plays (MP4), what loses nothing (MKV), what browsers and encyclopedias take
without patents (WebM), and two without sound, for pages (GIF) and for further work (PNG, a file a screen).

All containers are told to write early. A process that is killed then leaves a file that plays, up to its last second.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from types import MappingProxyType


@dataclass(frozen=True)
class Format:
    """One kind of file, in the names of FFmpeg.

    `codec` encodes pictures of the pixel format `pixels`, of sides that are multiples of `multiple` up to `limit`;
    `sound` encodes the sound (None: silent), at `sound_rate` samples a second (None: at the console's).
    `tick` is the unit of time where the format has one.
    """

    name: str
    container: str
    codec: str
    pixels: str
    limit: int
    multiple: int = 1
    sound: str | None = None
    sound_rate: int | None = 48_000
    container_options: Mapping[str, str] = field(default_factory=dict)
    codec_options: Mapping[str, str] = field(default_factory=dict)
    tick: Fraction | None = None


_CLUSTERS = {"cluster_time_limit": "500", "flush_packets": "1"}  # milliseconds

FORMATS: Mapping[str, Format] = MappingProxyType(
    {
        ".mp4": Format(
            name="MP4 (H.264, AAC)",
            container="mp4",
            codec="libx264",
            pixels="yuv420p",
            limit=8192,  # that common decoders accept
            multiple=2,
            sound="aac",
            # Fragments of half a second while recording, an ordinary MP4 when it is closed.
            container_options={"movflags": "hybrid_fragmented", "frag_duration": "500000", "flush_packets": "1"},
            codec_options={"crf": "18", "preset": "veryfast"},
        ),
    }
)
"""Formats by the ending of the file's name."""
