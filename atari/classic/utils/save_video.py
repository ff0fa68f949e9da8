"""`save_video`: frames that a script collected, as a video."""

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from atari.classic.monitor_files import capped_cubic_video_schedule
from atari.classic.video_recorder import ImageEncoder

Trigger = Callable[[int], bool]


def save_video(
    frames: Sequence[Any],
    video_folder: str | os.PathLike[str],
    episode_trigger: Trigger | None = None,
    step_trigger: Trigger | None = None,
    video_length: int | None = None,
    name_prefix: str = "rl-video",
    episode_index: int = 0,
    step_starting_index: int = 0,
    **kwargs: Any,
) -> None:
    """Write the frames of an episode, if its number is chosen, or from each step that is chosen.

    Args:
        frames: images, (rows, columns, 3) uint8.
        video_folder: the folder; it is made if necessary.
        episode_trigger: whether the video of an episode is written; None means 0, 1, 8, 27, ..., 1000, 2000, ...
        step_trigger: whether a video begins at a step, instead.
        video_length: the most frames of a video; None means all.
        name_prefix: the beginning of the name, before "-episode-0.mp4" or "-step-0.mp4".
        episode_index: the number of the episode.
        step_starting_index: the number of the first frame's step.
        **kwargs: `fps`, the frames a second, 30 if it is not given; others have no effect.

    Raises:
        TypeError: `frames` is no list of images.
        gymnasium.error.DependencyNotInstalled: PyAV is not installed (extra `video`).
    """
    if not isinstance(frames, (list, tuple)):
        raise TypeError(f"frames is a list of images, got a {type(frames).__name__}")
    folder = Path(video_folder).absolute()
    folder.mkdir(parents=True, exist_ok=True)
    fps = kwargs.get("fps") or 30
    if step_trigger is None and (episode_trigger or capped_cubic_video_schedule)(episode_index):
        _write(folder / f"{name_prefix}-episode-{episode_index}.mp4", frames[:video_length], fps)
    elif step_trigger is not None:
        for place, step in enumerate(range(step_starting_index, step_starting_index + len(frames))):
            if step_trigger(step):
                end = None if video_length is None else place + video_length
                _write(folder / f"{name_prefix}-step-{step}.mp4", frames[place:end], fps)


def _write(path: Path, frames: Sequence[Any], fps: float) -> None:
    if not frames:
        return
    encoder = ImageEncoder(path, np.shape(frames[0]), fps)
    try:
        for frame in frames:
            encoder.capture_frame(frame)
    finally:
        encoder.close()
