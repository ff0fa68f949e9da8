"""`play`: play an environment by keyboard, through Gymnasium's `play` (extra `play`)."""

from collections.abc import Callable
from functools import cache
from typing import Any

import gymnasium

from atari.classic.core import Env
from atari.classic.modern import Modern

Callback = Callable[[Any, Any, Any, Any, bool, dict[str, Any]], Any]


def play(
    env: Env,
    transpose: bool = True,
    fps: int = 30,
    zoom: float | None = None,
    callback: Callback | None = None,
    keys_to_action: dict[Any, Any] | None = None,
) -> None:
    """Play until the window is closed or Escape is pressed.

    Args:
        env: an environment that renders "rgb_array".
        transpose: images are (rows, columns, 3).
        fps: steps a second.
        zoom: size of the window relative to the image.
        callback: called after each step with the observation before and after, action, reward, done and info.
        keys_to_action: the action of each combination of keys, such as {(ord("a"),): 1}; () is no key, whose action is
            otherwise 0. None uses the keys of the environment.

    Raises:
        gymnasium.error.DependencyNotInstalled: pygame is not installed.
        gymnasium.error.Error: the environment has no keys, and none were given.
    """
    if keys_to_action is None and not hasattr(env, "get_keys_to_action"):
        raise gymnasium.error.Error(
            f"{env} does not say which keys play it; give them, as in play(env, keys_to_action={{(ord('a'),): 0}})"
        )
    try:
        import gymnasium.utils.play as gymnasium_play
    except gymnasium.error.DependencyNotInstalled:
        raise gymnasium.error.DependencyNotInstalled("playing needs pygame-ce: pip install pygame-ce") from None

    keys = dict(keys_to_action or env.get_keys_to_action())  # type: ignore[attr-defined]
    gymnasium_play.play(
        Modern(env, render_mode="rgb_array"),
        transpose=transpose,
        fps=fps,
        zoom=zoom,
        callback=None if callback is None else _of_five_values(callback),
        noop=keys.pop((), 0),
        keys_to_action=keys,
    )


def __getattr__(name: str) -> Any:
    """`PlayPlot`, `PlayableGame`, `MissingKeysToAction` and `display_arr`, which need pygame."""
    if name not in ("MissingKeysToAction", "PlayPlot", "PlayableGame", "display_arr"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import gymnasium.utils.play as gymnasium_play

    return _play_plot(gymnasium_play.PlayPlot) if name == "PlayPlot" else getattr(gymnasium_play, name)


@cache
def _play_plot(modern: type[Any]) -> type[Any]:
    class PlayPlot(modern):  # type: ignore[misc]
        """Plots what `callback(obs_t, obs_tp1, action, rew, done, info)` returns at each step of `play`."""

        def __init__(self, callback: Callback, horizon_timesteps: int, plot_names: list[str]) -> None:
            super().__init__(_of_five_values(callback), horizon_timesteps, plot_names)

        def callback(self, obs_t: Any, obs_tp1: Any, action: Any, rew: Any, done: bool, info: dict[str, Any]) -> None:
            super().callback(obs_t, obs_tp1, action, rew, done, False, info)

    return PlayPlot


def _of_five_values(callback: Callback) -> Callable[..., Any]:
    def call(before: Any, after: Any, action: Any, reward: Any, terminated: bool, truncated: bool, info: Any) -> Any:
        return callback(before, after, action, reward, terminated or truncated, info)

    return call
