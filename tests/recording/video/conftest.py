"""Fixtures of the tests of videos."""

import sys
import types
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from video_reader import Screen

from atari.recording.video import writer
from atari.recording.video.options import VideoOptions


@pytest.fixture
def moviepy(monkeypatch: pytest.MonkeyPatch) -> dict[str, int]:
    """A stand-in for Gymnasium's encoder, which stores the number of frames of each video by name."""
    made: dict[str, int] = {}

    class ImageSequenceClip:
        def __init__(self, frames: list[Screen], fps: float) -> None:
            self.frames = frames

        def write_videofile(self, path: str, logger: Any) -> None:
            made[Path(path).name] = len(self.frames)

    module: Any = types.ModuleType("moviepy.video.io.ImageSequenceClip")
    module.ImageSequenceClip = ImageSequenceClip
    for name in ("moviepy", "moviepy.video", "moviepy.video.io"):
        monkeypatch.setitem(sys.modules, name, types.ModuleType(name))
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.delitem(sys.modules, "gymnasium.utils.save_video", raising=False)
    return made


@dataclass
class Video:
    """The frames and the sound that an encoder got."""

    images: list[Screen] = field(default_factory=list)
    samples: list[Any] = field(default_factory=list)


@pytest.fixture
def videos(monkeypatch: pytest.MonkeyPatch) -> dict[str, Video]:
    """A stand-in for our encoder, which keeps the frames of each video by name; its files have no content.

    The tests of formats and of the writer decode files.
    """
    made: dict[str, Video] = {}

    class Encoder:
        def __init__(self, options: VideoOptions, comment: str = "") -> None:
            self.path, self.video = options.path, Video()
            made[options.path.name] = self.video

        def write(self, image: Screen, samples: Any) -> None:
            self.video.images.append(image.copy())
            self.video.samples.append(samples)

        def close(self, *, broken: bool = False) -> None:
            if self.video.images:
                self.path.touch()
            else:
                del made[self.path.name]

    monkeypatch.setattr(writer, "FFmpegEncoder", Encoder)
    return made
