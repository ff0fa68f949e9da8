"""Gymnasium's own checker over every game and kind of observation; each of its warnings is a failure."""

import warnings
from typing import Any

import gymnasium
import pytest
from gymnasium.utils.env_checker import check_env

import atari

GAMES = [game.id for game in atari.games.playable()]


@pytest.mark.parametrize("game", GAMES)
def test_pixels_and_all_render_modes(game: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    check(f"ALE/{atari.registration.stem(game)}-v5")


@pytest.mark.parametrize("game", GAMES)
def test_ram(game: str) -> None:
    check(f"ALE/{atari.registration.stem(game)}-ram-v5", render=False)


@pytest.mark.parametrize("game", GAMES)
def test_grayscale_and_sound(game: str) -> None:
    check(f"ALE/{atari.registration.stem(game)}-v5", render=False, obs_type="grayscale", sound_obs=True)


def check(env_id: str, *, render: bool = True, **options: Any) -> None:
    env = gymnasium.make(env_id, **options).unwrapped
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env, skip_render_check=not render, skip_close_check=not render)
