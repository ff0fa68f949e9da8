"""The same arrays as ale-py's vector environment, to the byte."""

from typing import Any

import pytest
from vector_peer import compare, option_sets

import atari
from atari.base.gymnasium_versions import AutoresetMode

GAMES = [game.id for game in atari.games.playable()]


@pytest.mark.parametrize("game", GAMES)
def test_every_game(game: str) -> None:
    number = GAMES.index(game)
    mode = (AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP)[number % 2]
    compare(game, 20, seed=number, num_envs=1, autoreset_mode=mode, max_num_frames_per_episode=41)


@pytest.mark.parametrize(("game", "options"), option_sets(20, seed=1))
def test_random_options(game: str, options: dict[str, Any]) -> None:
    compare(game, 60, seed=7, num_envs=1, **options)


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_whole_episodes(mode: AutoresetMode) -> None:
    assert compare("breakout", 400, seed=3, autoreset_mode=mode, frameskip=5) > 2


def test_lives_that_end_episodes() -> None:
    assert compare("breakout", 300, seed=11, episodic_life=True) > 8
    assert compare("ms_pacman", 300, seed=2, life_loss_info=True, autoreset_mode=AutoresetMode.SAME_STEP) > 0


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize(("frameskip", "maxpool", "stack"), [(4, True, 1), (5, True, 2), (1, True, 1), (3, False, 4)])
def test_rgb_at_the_size_of_the_screen(mode: AutoresetMode, frameskip: int, maxpool: bool, stack: int) -> None:
    """Frames of the screen's own size are not scaled. An episode ends inside a skip, and the next one follows."""
    options = {"frameskip": frameskip, "maxpool": maxpool, "stack_num": stack, "autoreset_mode": mode}
    screen = {"grayscale": False, "img_height": 210, "img_width": 160, "max_num_frames_per_episode": 42}
    for seed, game in enumerate(("breakout", "seaquest")):
        compare(game, 30, seed=seed, num_envs=1, **screen, **options)


def test_more_noops_than_an_episode_has_frames() -> None:
    compare("alien", 10, seed=6, noop_max=1000, num_envs=1)
