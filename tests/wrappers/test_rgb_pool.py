"""The tables of `DqnPreprocessing(pool_rgb=True)` agree with the emulator's colours and with OpenCV."""

import cv2
import numpy as np
import pytest

from atari import games
from atari.wrappers._palettes import PALETTES
from atari.wrappers._rgb_pool import RgbPool


@pytest.mark.parametrize("game", ["pitfall", "video_pinball", "solaris", "yars_revenge", "pacman", "turmoil"])
def test_palettes_are_the_emulators(game_env, game):
    env = game_env(game)
    env.reset(seed=0)
    env.action_space.seed(0)
    seen = set()
    for _ in range(300):
        env.step(env.action_space.sample())
        screen = env.core.screen()
        seen.update(np.unique(screen).tolist())
        np.testing.assert_array_equal(PALETTES[games[game].screen.format][screen], env.core.screen_rgb())
    assert len(seen) >= 5


def test_every_format_of_a_game_has_a_palette():
    assert {game.screen.format for game in games.values()} <= set(PALETTES)
    assert all(palette.shape == (256, 3) and not palette[0].any() for palette in PALETTES.values())


@pytest.mark.parametrize("tv_format", ["NTSC", "PAL", "SECAM"])
def test_pools_as_rgb(tv_format):
    rng = np.random.default_rng(0)
    early, late, out = (rng.integers(0, 256, (210, 160), np.uint8) for _ in range(3))
    early[::2] = late[::2]
    colours = PALETTES[tv_format]
    pool = RgbPool(tv_format)
    expected = cv2.cvtColor(np.maximum(colours[early], colours[late]), cv2.COLOR_RGB2GRAY)
    np.testing.assert_array_equal(pool.pooled(early, late, out), expected)
    np.testing.assert_array_equal(pool.gray(late, out), cv2.cvtColor(colours[late], cv2.COLOR_RGB2GRAY))
