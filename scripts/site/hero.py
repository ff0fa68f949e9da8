"""The picture of the first page: twelve games that play at once."""

from collections.abc import Iterator
from itertools import islice

import numpy as np
from documents import ROOT
from page import Page
from pictures import Image, mosaic, mp4, png

import atari
from atari.recording import Replay

GAMES = (
    "breakout", "ms_pacman", "space_invaders", "pong", "seaquest", "qbert",
    "enduro", "montezuma_revenge", "asterix", "pitfall", "freeway", "riverraid",
)  # fmt: skip
FRAMES = 300  # frames of the video: every second frame of the console


def pages() -> Iterator[Page]:
    """A video of the games and its first picture."""
    frames = [mosaic(screens, 4).repeat(2, axis=1) for screens in zip(*map(_screens, GAMES), strict=True)]
    yield Page("assets/hero.mp4", mp4(frames, 30, crf=30))
    yield Page("assets/hero.png", png(frames[60]))


def html() -> str:
    """The video for the first page; without motion for readers who prefer that."""
    return (
        '<div class="hero"><video autoplay muted loop playsinline poster="assets/hero.png" width="1280" height="630">'
        '<source src="assets/hero.mp4" type="video/mp4"></video>'
        '<img src="assets/hero.png" width="1280" height="630" alt="Twelve games at once"></div>'
    )


def _screens(game: str) -> list[Image]:
    """Screens of a game, (210, 160, 3): of its recorded play, or of random actions."""
    replay = ROOT / "docs" / "games" / "replays" / f"{game}.a26r"
    if replay.exists():
        frames = Replay.load(replay).frames()
        return [_crop(frame.screen) for frame in islice(frames, 60, 60 + 2 * FRAMES, 2)]
    env = atari.AtariEnv(game, frameskip=2, repeat_action_probability=0.5)
    env.reset(seed=3)
    env.action_space.seed(3)
    screens: list[Image] = []
    for step in range(60 + FRAMES):
        observation, _, ended, _, _ = env.step(env.action_space.sample())
        if ended:
            observation, _ = env.reset()
        if step >= 60:
            screens.append(_crop(observation))
    env.close()
    return screens


def _crop(screen: Image) -> Image:
    """The first 210 lines, black below shorter screens."""
    return np.pad(screen, ((0, max(0, 210 - len(screen))), (0, 0), (0, 0)))[:210]
