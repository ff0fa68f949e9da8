"""Reading video files with PyAV."""

from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import av
import numpy as np
import numpy.typing as npt

NTSC = Fraction(1_640_625, 27_379)
PAL = Fraction(3_546_895, 71_136)

Screen = npt.NDArray[np.uint8]


def video_frames(path: Path) -> list[Screen]:
    """Return all frames of a video file, (height, width, 3)."""
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


def frame_times(path: Path) -> list[float]:
    """Return the presentation time of each frame in seconds."""
    with av.open(str(path)) as container:
        return [float(frame.pts * frame.time_base) for frame in container.decode(video=0)]


def sound(path: Path) -> tuple[npt.NDArray[Any], int]:
    """Return all samples of a file, from time 0 on, and their rate."""
    with av.open(str(path)) as container:
        frames = list(container.decode(audio=0))
    assert frames[0].pts * frames[0].time_base == 0
    return np.concatenate([frame.to_ndarray()[0] for frame in frames]), frames[0].sample_rate


def loudness(samples: npt.NDArray[Any], rate: float, frames: int, fps: float) -> npt.NDArray[np.float64]:
    """Return the peak-to-peak amplitude of the sound during each frame."""
    edges = (np.arange(frames + 1) * rate / fps).round().astype(int)
    return np.array([np.ptp(samples[a:b].astype(float)) for a, b in pairwise(edges)])
