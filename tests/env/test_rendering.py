"""The render modes. Windows are opened on SDL's dummy display, whose surface can be read back."""

import os
import subprocess
import sys
import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest

from atari import AtariEnv


@pytest.fixture
def display(monkeypatch: pytest.MonkeyPatch) -> Any:
    """pygame, with a display that exists in memory only."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    monkeypatch.setenv("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    import pygame

    yield pygame
    pygame.display.quit()


def test_rgb_array_is_the_screen() -> None:
    env = AtariEnv("adventure", render_mode="rgb_array", obs_type="ram")
    env.reset(seed=0)
    env.step(0)
    assert np.array_equal(env.render(), env.core.screen_rgb())


def test_rgb_array_list_is_a_frame_for_the_reset_and_each_step() -> None:
    env = AtariEnv("seaquest", render_mode="rgb_array_list")
    expected = [env.reset(seed=0)[0]]
    expected += [env.step(action)[0] for action in (1, 2, 3)]
    assert np.array_equal(np.stack(env.render()), np.stack(expected))
    assert env.render() == []
    last = env.step(4)[0]
    (frame,) = env.render()
    assert np.array_equal(frame, last)


def test_a_reset_begins_a_new_list() -> None:
    env = AtariEnv("pong", render_mode="rgb_array_list")
    env.reset(seed=0)
    env.step(0)
    first, _ = env.reset()
    (frame,) = env.render()
    assert np.array_equal(frame, first)


def test_without_a_render_mode_render_raises() -> None:
    env = AtariEnv("pong")
    env.reset(seed=0)
    with pytest.raises(gymnasium.error.Error, match=r"render\(\) needs a render mode; make the environment with"):
        env.render()


@pytest.mark.parametrize("mode", ["rgb_array", "rgb_array_list", "human"])
def test_gymnasium_makes_every_mode_without_a_warning(mode: str, display: Any) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make("ALE/Pong-v5", render_mode=mode)
        env.reset(seed=0)
        env.step(0)
        rendered = env.render()
        env.close()
    assert type(rendered) is {"rgb_array": np.ndarray, "rgb_array_list": list, "human": type(None)}[mode]


def test_human_shows_the_screen_with_wide_pixels(display: Any) -> None:
    env = AtariEnv("breakout", render_mode="human", frameskip=1)
    env.reset(seed=0)
    env.step(1)
    surface = display.display.get_surface()
    assert surface.get_size() == (480, 315)  # 160 x 210, each pixel twice as wide as high
    shown = display.surfarray.array3d(surface).swapaxes(0, 1)
    assert np.array_equal(shown, env.core.screen_rgb()[np.arange(315) * 2 // 3][:, np.arange(480) // 3])
    assert env.render() is None
    env.close()


def test_human_waits_for_the_time_of_the_next_frame(display: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    rates: list[float] = []

    class Clock:
        def tick(self, rate: float) -> None:
            rates.append(rate)

    monkeypatch.setattr(display.time, "Clock", Clock)
    env = AtariEnv("pacman", render_mode="human", frameskip=2)
    env.reset(seed=0)
    env.step(0)
    assert rates == [25.0, 25.0]
    env.close()


def test_closing_closes_the_window(display: Any) -> None:
    env = AtariEnv("pong", render_mode="human")
    assert display.display.get_surface() is not None
    env.close()
    assert display.display.get_surface() is None
    env.close()


def test_without_a_display_human_names_rgb_array() -> None:
    program = "import atari; atari.AtariEnv('pong', render_mode='human')"
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")
    environment = {key: value for key, value in os.environ.items() if key not in hidden}
    result = subprocess.run(
        [sys.executable, "-c", program],
        env={**environment, "SDL_VIDEODRIVER": "x11"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 1
    error = result.stderr.strip().splitlines()[-1]
    assert error.startswith("gymnasium.error.Error: render_mode='human' needs a display and found none (")
    assert error.endswith("; use render_mode='rgb_array' to get the screen as an array")


def test_without_pygame_human_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match=r"pip install 'pygame-ce>=2.4'"):
        AtariEnv("pong", render_mode="human")
