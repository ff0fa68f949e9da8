"""Videos of given frames, and what the tests of `RecordVideo` share."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from video_reader import NTSC, Screen

from atari.recording import VideoWriter


def film(
    path: Path, screens: Iterable[Screen], fps: Any = NTSC, sound: Iterable[Any] | None = None, **given: Any
) -> Path:
    """The file of a video of some screens, and of as many blocks of samples."""
    written = list(screens)
    samples = [None] * len(written) if sound is None else list(sound)
    with VideoWriter(path, written[0].shape[:2], fps, sound=sound is not None, **given) as video:
        for screen, block in zip(written, samples, strict=True):
            video.write(screen, block)
    assert video.frames == len(written)
    return video.path


def always(number: int) -> bool:
    """A trigger of `RecordVideo`."""
    return True


def files(folder: Path) -> list[str]:
    """The files in the folder `videos` of a folder, and in its folders."""
    return sorted(str(path.relative_to(folder / "videos")) for path in (folder / "videos").rglob("*.*"))
