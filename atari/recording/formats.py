"""The kinds of files that a recording can be, by the ending of their name, and how each is encoded.

The choices: what nearly every program plays (MP4), what loses nothing (MKV), what browsers take and no patents cover
(WebM), and two without sound, for pages (GIF) and for further work (PNG, a file a screen).

All are written early and in small portions. A process that is killed then leaves a file that plays, up to its last
second.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from types import MappingProxyType


@dataclass(frozen=True)
class Format:
    """One kind of file, in the names of FFmpeg.

    `codec` encodes pictures of the pixel format `pixels`, of sides up to `limit` that `multiple` divides; if it
    `enlarges`, FFmpeg scales them, on the way to its own colours, which saves a step. `sound` encodes the sound, at
    `sound_rate` samples a second; None is at the console's rate, unchanged. With `fades_in`, what the encoder puts
    before time 0 is left out, and the decoder's first 20 milliseconds fade in. `max_rate` is how many pictures a
    second there can be; of more, some are left out.
    """

    name: str
    container: str
    codec: str
    pixels: str
    limit: int
    multiple: int = 1
    enlarges: bool = False
    sound: str | None = None
    sound_rate: int | None = 48_000
    fades_in: bool = False
    max_rate: int | None = None
    container_options: Mapping[str, str] = field(default_factory=dict)
    codec_options: Mapping[str, str] = field(default_factory=dict)


_CLUSTERS = {"cluster_time_limit": "500", "flush_packets": "1"}  # of half a second each

FORMATS: Mapping[str, Format] = MappingProxyType(
    {
        ".mp4": Format(
            name="MP4 (H.264, AAC)",
            container="mp4",
            codec="libx264",
            pixels="yuv420p",
            limit=8192,  # that common decoders accept
            multiple=2,
            enlarges=True,
            sound="aac",
            fades_in=True,
            # Fragments of half a second while recording, an ordinary MP4 when it is closed, with an index that until
            # then is in memory (8 kB a second). The header comes before what it is about, and cannot say by how much
            # encoders delay; so there are no B-frames, and the sound fades in. (It can wait, but FFmpeg before 8.1
            # then writes files that do not play.)
            container_options={"movflags": "hybrid_fragmented", "frag_duration": "500000", "flush_packets": "1"},
            codec_options={"crf": "18", "preset": "superfast", "bf": "0"},
        ),
        ".mkv": Format(
            name="lossless MKV (FFV1, FLAC)",
            container="matroska",
            codec="ffv1",
            pixels="bgr0",
            limit=16_384,
            sound="flac",
            sound_rate=None,
            container_options=_CLUSTERS,
            codec_options={"level": "3"},
        ),
        ".webm": Format(
            name="WebM (VP9, Opus)",
            container="webm",
            codec="libvpx-vp9",
            pixels="yuv420p",
            limit=16_384,
            enlarges=True,
            sound="libopus",
            container_options=_CLUSTERS,
            codec_options={"deadline": "realtime", "cpu-used": "8", "row-mt": "1", "crf": "20", "b": "0"},
        ),
        ".gif": Format(
            name="GIF",
            container="gif",
            codec="gif",
            pixels="pal8",
            limit=16_384,
            max_rate=50,  # times are hundredths of a second, and programs take a 1 for a 10
            container_options={"flush_packets": "1"},
        ),
        ".png": Format(name="PNG", container="", codec="", pixels="", limit=16_384),
    }
)
"""Formats by the ending of the file's name."""


def has_sound(path: str | PathLike[str]) -> bool:
    """Whether a file of this name is of a format that has sound."""
    format = FORMATS.get(Path(path).suffix.lower())
    return format is not None and format.sound is not None
