"""Scripts for Gym, rewritten for Gymnasium and run there, where no module is called `gym`."""

import sys
import types
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

from atari.classic.rewrite import modernized


def rewritten(old: str) -> str:
    """The script for Gymnasium, which a second rewriting leaves as it is."""
    new = modernized(old).result()
    assert modernized(new).result() == new
    return new


def run(old: str) -> dict[str, Any]:
    """The variables of a script after the run of its rewritten form."""
    new = rewritten(old)
    names: dict[str, Any] = {"__name__": "__main__"}
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "gym", None)  # an import of it fails
        exec(compile(new, "script.py", "exec"), names)
    return names


def marks(old: str) -> list[str]:
    """What the rewritten script says must be checked."""
    rows = [row.strip() for row in rewritten(old).splitlines()]
    return [row.removeprefix("# atari.classic: ") for row in rows if row.startswith("# atari.classic: ")]


class _Clip:
    """`moviepy`'s clip of frames, written by PyAV."""

    def __init__(self, frames: list[np.ndarray[Any, Any]], fps: float) -> None:
        self._frames, self._fps = frames, fps

    def write_videofile(self, path: str, **_: Any) -> None:
        with av.open(path, "w") as container:
            stream = container.add_stream("mpeg4", rate=int(self._fps))
            stream.height, stream.width = self._frames[0].shape[:2]
            for frame in self._frames:
                container.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="rgb24")))
            container.mux(stream.encode())


@contextmanager
def moviepy() -> Iterator[None]:
    """Let Gymnasium's RecordVideo write videos, for which it imports MoviePy, a heavy package."""
    module: Any = types.ModuleType("moviepy.video.io.ImageSequenceClip")
    module.ImageSequenceClip = _Clip
    with pytest.MonkeyPatch.context() as patch:
        for name in ("moviepy", "moviepy.video", "moviepy.video.io"):
            patch.setitem(sys.modules, name, types.ModuleType(name))
        patch.setitem(sys.modules, module.__name__, module)
        yield


def videos(folder: Path) -> dict[str, int]:
    """The number of frames of each video in a folder, by its name."""
    found = {}
    for path in sorted(folder.glob("*.mp4")):
        with av.open(str(path)) as container:
            found[path.name] = sum(1 for _ in container.decode(video=0))
    return found
