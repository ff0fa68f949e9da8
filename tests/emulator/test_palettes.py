"""The palettes of the TV formats are the emulator's colours."""

import numpy as np
import pytest

import atari._emulator as _emulator
from atari import AtariEnv, games


@pytest.mark.parametrize("game", ["pitfall", "video_pinball", "solaris", "yars_revenge", "pacman", "turmoil"])
def test_palettes_are_the_emulators(game: str) -> None:
    env = AtariEnv(game)
    env.reset(seed=0)
    env.action_space.seed(0)
    palette, seen = _emulator.palette(games[game].screen.format), set()
    for _ in range(100):
        env.step(env.action_space.sample())
        screen = env.core.screen()
        seen.update(np.unique(screen).tolist())
        np.testing.assert_array_equal(palette[screen], env.core.screen_rgb())
    assert len(seen) >= 5


def test_every_format_of_a_game_has_a_palette() -> None:
    for tv_format in {game.screen.format for game in games.values()}:
        palette = _emulator.palette(tv_format)
        assert palette.shape == (256, 3)
        assert not palette[0].any()
