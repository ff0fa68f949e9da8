"""`AtariPreprocessing`: the preprocessing of Machado et al. 2018, by Gymnasium's wrapper."""

from collections.abc import Callable
from typing import Any

import gymnasium

from atari.base.extras import import_extra, pip_install
from atari.classic.adapter import Adapter
from atari.classic.core import Env, Step, Wrapper
from atari.classic.modern import Modern

_GymnasiumEnv = gymnasium.Env[Any, Any]


class Bridge(Wrapper):
    """An old-style environment, inside a wrapper of Gymnasium.

    Args:
        env: the environment.
        wrap: puts Gymnasium's wrapper around an environment of Gymnasium's interface.
    """

    def __init__(self, env: Env, wrap: Callable[[_GymnasiumEnv], _GymnasiumEnv]) -> None:
        super().__init__(env)
        self._wrapped = Adapter(wrap(_Inside(env)))
        self.action_space = self._wrapped.action_space
        self.observation_space = self._wrapped.observation_space

    def _reset(self, **options: Any) -> Any:
        return self._wrapped.reset()

    def _step(self, action: Any) -> Step:
        return self._wrapped.step(action)


class _Inside(Modern):
    """The environment with Gymnasium's interface; `unwrapped` is the Gymnasium environment inside an `Adapter`."""

    @property
    def unwrapped(self) -> _GymnasiumEnv:
        inside = self.classic.unwrapped
        return inside.modern.unwrapped if isinstance(inside, Adapter) else self


class AtariPreprocessing(Bridge):
    """Random no-ops at the start, skipped frames, the maximum of the last two frames, in gray and 84 x 84.

    Args:
        env: a game without a frame skip of its own, such as "PongNoFrameskip-v4".
        noop_max: most no-ops after a reset.
        frame_skip: frames a step.
        screen_size: rows and columns.
        terminal_on_life_loss: an episode is done when a life is lost.
        grayscale_obs: gray instead of colours.
        grayscale_newaxis: gray images have a third axis of one.
        scale_obs: floats within 0..1 instead of bytes.

    Raises:
        TypeError: the environment is not an Atari game.
        ValueError: the game has a frame skip, or an argument is out of range.
        gymnasium.error.DependencyNotInstalled: OpenCV, which Gymnasium's wrapper needs, is not installed.
    """

    def __init__(
        self,
        env: Env,
        noop_max: int = 30,
        frame_skip: int = 4,
        screen_size: int = 84,
        terminal_on_life_loss: bool = False,
        grayscale_obs: bool = True,
        grayscale_newaxis: bool = False,
        scale_obs: bool = False,
    ) -> None:
        if not hasattr(env.unwrapped, "ale"):
            raise TypeError(f"AtariPreprocessing is for Atari games, such as 'PongNoFrameskip-v4', got {env}")
        options: dict[str, Any] = {
            "noop_max": noop_max,
            "frame_skip": frame_skip,
            "screen_size": screen_size,
            "terminal_on_life_loss": terminal_on_life_loss,
            "grayscale_obs": grayscale_obs,
            "grayscale_newaxis": grayscale_newaxis,
            "scale_obs": scale_obs,
        }
        import_extra("cv2", f"Gymnasium's AtariPreprocessing needs OpenCV: {pip_install('opencv-python-headless')}")
        super().__init__(env, lambda inside: gymnasium.wrappers.AtariPreprocessing(inside, **options))
        self.noop_max, self.frame_skip, self.screen_size = noop_max, frame_skip, screen_size
        self.terminal_on_life_loss, self.scale_obs = terminal_on_life_loss, scale_obs
        self.grayscale_obs, self.grayscale_newaxis = grayscale_obs, grayscale_newaxis
        inner: Any = self._wrapped.modern
        self._preprocessing: Any = inner
        self._see = inner._get_obs
        inner._get_obs = self._get_obs  # a subclass may replace it

    @property
    def ale(self) -> Any:
        """The emulator."""
        return self.env.unwrapped.ale  # type: ignore[attr-defined]

    @property
    def lives(self) -> int:
        """The lives after the last step, with `terminal_on_life_loss`."""
        return int(self._preprocessing.lives)

    @property
    def game_over(self) -> bool:
        """Whether the game is over, with `terminal_on_life_loss`."""
        return bool(self._preprocessing.game_over)

    @property
    def obs_buffer(self) -> Any:
        """The last two frames, of which an observation is the maximum."""
        return self._preprocessing.obs_buffer

    def _get_obs(self) -> Any:
        """The observation of the frames in `obs_buffer`."""
        return self._see()
