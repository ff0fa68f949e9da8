"""Fixtures of the tests of videos."""

import sys
import types
from pathlib import Path
from typing import Any

import pytest
from video_reader import Screen


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
