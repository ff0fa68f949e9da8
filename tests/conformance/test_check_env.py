"""Gymnasium's own checker over every game and kind of observation; each of its warnings is a failure."""

import warnings
from typing import Any

import gymnasium
import pytest
from gymnasium.utils.env_checker import check_env

import atari
from atari.task import env_ids

GAMES = [game.id for game in atari.games.playable()]


@pytest.mark.parametrize("game", GAMES)
def test_pixels_and_all_render_modes(game: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    check(f"ALE/{env_ids.stem(game)}-v5")


@pytest.mark.parametrize("game", GAMES)
def test_ram(game: str) -> None:
    check(f"ALE/{env_ids.stem(game)}-ram-v5", render=False)


@pytest.mark.parametrize("game", GAMES)
def test_grayscale(game: str) -> None:
    check(f"ALE/{env_ids.stem(game)}-v5", render=False, obs_type="grayscale")


@pytest.mark.parametrize("obs_type", ["rgb", "grayscale", "ram"])
def test_sound_beside_each(obs_type: str) -> None:
    check("ALE/Seaquest-v5", render=False, obs_type=obs_type, sound_obs=True)


@pytest.mark.parametrize("game", ["Pong", "Seaquest"])
def test_continuous_actions(game: str) -> None:
    """Gymnasium would like actions within -1..1; this space has an angle, and is ale-py's."""
    check(f"ALE/{game}-v5", render=False, tolerated="symmetric and normalized space", continuous=True)


def check(env_id: str, *, render: bool = True, tolerated: str | None = None, **options: Any) -> None:
    env = gymnasium.make(env_id, **options).unwrapped
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        if tolerated is not None:
            warnings.filterwarnings("ignore", message=f".*{tolerated}")
        check_env(env, skip_render_check=not render, skip_close_check=not render)
