#!/usr/bin/env python
"""Draws the moving picture of the README: a recorded game, and beside it what an agent sees of it.

    scripts/generate/readme_picture.py    # docs/assets/qbert.gif

The left side shows the frames of `examples/qbert.a26r`, the right side the observations of the preset `dqn2015`, four
images of 84x84. It needs Pillow.
"""

import argparse
from pathlib import Path

import numpy as np
import numpy.typing as npt

import atari
import atari._emulator as _emulator
from atari.env.settings import observation_settings
from atari.recording import Replay

TOP = Path(__file__).resolve().parents[2]
FIRST, STEPS, SKIP = 180, 150, 4
"""The first frame, the steps of the agent, and the frames of each."""


def pictures() -> list[npt.NDArray[np.uint8]]:
    """The pictures of the steps, (420, 676, 3): the screen, and the last four images in two rows."""
    replay = Replay.load(TOP / "examples" / "qbert.a26r")
    task = atari.Task.of("qbert", preset="dqn2015")
    screen = task.definition.screen
    seen = _emulator.ObservationStack(observation_settings(task), screen.height, screen.format)
    seen.begin(replay.seek(FIRST))
    made = []
    for step in range(STEPS):
        for frame in range(1, SKIP + 1):
            core = replay.seek(FIRST + step * SKIP + frame)
            seen.frame_played(core, SKIP - frame, False)
        seen.skip_ended(core, 0, False)
        images = np.pad(seen.observation(), ((0, 0), (2, 2), (2, 2)), constant_values=96)
        four = np.block([[images[0], images[1]], [images[2], images[3]]])
        right = np.zeros((210, 178, 3), np.uint8)
        right[17:193, 2:] = four[:, :, None]
        made.append(np.concatenate([core.screen_rgb(), right], 1).repeat(2, 0).repeat(2, 1))
    return made


def main() -> None:
    """Write the picture."""
    argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0]).parse_args()
    from PIL import Image  # --help does not need it

    images = [Image.fromarray(picture).quantize(64, dither=Image.Dither.NONE) for picture in pictures()]
    milliseconds = round(1000 * SKIP / 60)
    path = TOP / "docs" / "assets" / "qbert.gif"
    images[0].save(path, save_all=True, append_images=images[1:], duration=milliseconds, loop=0, optimize=True)
    print(path, f"{path.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
