"""The video formats by file suffix, and how each is encoded.

MP4 plays in nearly every program. MKV is lossless. WebM is for browsers and free of patents. GIF and PNG (one file a
frame, or a single picture) have no sound.

All formats are written in small portions. If the process is killed, the file plays up to its last second.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path

from atari.base.frozen import FrozenDict


@dataclass(frozen=True)
class Format:
    """A video format, with FFmpeg's names of container, codecs and options.

    `codec` encodes images of the pixel format `pixels`. Their sides are multiples of `multiple`, up to `limit`. With
    `enlarges`, FFmpeg scales the frames while it converts their colours, which saves a pass. `sound` is the audio
    codec and `sound_rate` its sample rate; None keeps the console's samples unchanged. With `fades_in`, packets before
    time 0 are dropped, and the first 20 milliseconds of sound fade in. `max_rate` is the greatest frame rate; from a
    higher one frames are dropped.
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


_CLUSTERS = {"cluster_time_limit": "500", "flush_packets": "1"}  # half a second each

FORMATS: Mapping[str, Format] = FrozenDict(
    {
        ".mp4": Format(
            name="MP4 (H.264, AAC)",
            container="mp4",
            codec="libx264",
            pixels="yuv420p",
            limit=8192,  # common decoders' limit
            multiple=2,
            enlarges=True,
            sound="aac",
            fades_in=True,
            # Fragments of half a second while recording, an ordinary MP4 after closing. Until then the index is in
            # memory (8 kB a second). The header is written before the encoders' delays are known, so there are no
            # B-frames and the sound fades in. (A delayed header makes FFmpeg before 8.1 write files that do not play.)
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
            max_rate=50,  # times are hundredths of a second, and programs show a delay of 1 as 10
            container_options={"flush_packets": "1"},
        ),
        ".png": Format(name="PNG", container="", codec="", pixels="", limit=16_384),
    }
)
"""The formats by file suffix."""


def has_sound(path: str | PathLike[str]) -> bool:
    """Return whether the format of this file name has sound."""
    format = FORMATS.get(Path(path).suffix.lower())
    return format is not None and format.sound is not None


def is_picture(path: str | PathLike[str]) -> bool:
    """Return whether this is the name of a single picture: a PNG without a placeholder for a number."""
    path = Path(path)
    return path.suffix.lower() == ".png" and "%" not in path.name
