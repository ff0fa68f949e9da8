"""`Modern`: an old-style environment for `gymnasium.make`, Gymnasium's wrappers and vector environments.

`atari.classic.register` puts an `EntryPoint` into Gymnasium's registry. It loads the class only when it is needed, and
then checks whether the class has the old or the new interface.
"""

import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from gymnasium.envs.registration import load_env_creator

from atari.classic.checks import Checked
from atari.classic.core import Env


class Modern(gymnasium.Env[Any, Any]):
    """An old-style environment with Gymnasium's interface.

    The seed of `reset` goes to the environment's `seed` method; an environment without this method does not repeat its
    episodes. Other attributes come from the environment, `classic`.

    Args:
        classic: the environment.
        render_mode: the mode for the environment's `render`; with "human", it is called after every reset and step.

    Raises:
        gymnasium.error.UnsupportedMode: the environment has no such render mode.
        TypeError: the environment lacks a space; from `reset` and `step`: it returned a wrong result.
    """

    classic: Env

    def __init__(self, classic: Env, render_mode: str | None = None) -> None:
        self._checked = Checked(classic)
        self.classic = classic
        self.metadata = modern_metadata(classic.metadata)
        modes = self.metadata["render_modes"]
        if render_mode not in (None, *modes):
            raise gymnasium.error.UnsupportedMode(
                f"{type(classic).__name__} has the render modes {modes}, got {render_mode!r}; "
                "name what its render() takes in metadata['render.modes']"
            )
        self.render_mode = render_mode
        self.action_space = classic.action_space
        self.observation_space = classic.observation_space

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Seed the environment, if `seed` is given, and start a new episode. `options` are ignored."""
        super().reset(seed=seed)
        if seed is not None:
            self._checked.seed(seed)
        observation = self._observation(self._checked.reset())
        self._show()
        return observation, {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Take an action; `done` is terminated, or truncated if `info["TimeLimit.truncated"]` is true."""
        observation, reward, done, info = self._checked.step(action)
        truncated = done and bool(info.get("TimeLimit.truncated", False))
        self._show()
        return self._observation(observation), float(reward), done and not truncated, truncated, info

    def render(self) -> Any:
        """The result of the environment's `render` in this mode; None with "human", which renders at each step.

        Raises:
            gymnasium.error.Error: there is no render mode.
        """
        if self.render_mode is None:
            raise gymnasium.error.Error("render() needs a render mode; make the environment with one, such as 'human'")
        return None if self.render_mode == "human" else self._render()

    def close(self) -> None:
        """Close the environment."""
        self._checked.close()

    def __getattr__(self, name: str) -> Any:
        # `seed` is an argument of `reset` here; `copy` looks up the other names before they exist.
        if name.startswith("__") or name in ("classic", "_checked", "seed"):
            raise AttributeError(name)
        return getattr(self.classic, name)

    def _observation(self, observation: Any) -> Any:
        """An observation of a Box as an array of its dtype, which Gymnasium's wrappers need; Gym accepted lists."""
        space = self.observation_space
        return np.asarray(observation, space.dtype) if isinstance(space, gymnasium.spaces.Box) else observation

    def _show(self) -> None:
        if self.render_mode == "human":
            self._render()

    def _render(self) -> Any:
        takes_mode = inspect.signature(self.classic.render).parameters
        return self._checked.render(self.render_mode) if takes_mode else self._checked.render()


@dataclass(frozen=True)
class EntryPoint:
    """A class or function that makes environments of either interface, or its import path."""

    entry_point: str | Callable[..., Any]

    def load(self) -> Callable[..., Any]:
        """The class or function; a path in `gym.envs` means the class of that name here, or else in Gymnasium."""
        if not isinstance(self.entry_point, str):
            return self.entry_point
        path = re.sub(r"^gym(?=\.envs\.(atari|classic_control|toy_text)\b)", "atari.classic", self.entry_point)
        return load_env_creator(re.sub(r"^gym\.", "gymnasium.", path))

    @property
    def metadata(self) -> dict[str, Any]:
        """The metadata of the class, with Gymnasium's keys; AttributeError for a function, which has none."""
        return modern_metadata(self.load().metadata)  # type: ignore[attr-defined]

    def create(self, **options: Any) -> Env | gymnasium.Env[Any, Any]:
        """Make an environment, with either interface.

        Raises:
            TypeError: the result has neither; the message says how to fix it.
        """
        env = self.load()(**options)
        if isinstance(env, Env):
            return env
        name = type(env).__name__
        if not isinstance(env, gymnasium.Env):
            raise TypeError(f"{name} is no environment; derive the class from Env, of atari.classic or of gymnasium")
        if not _takes_seed(env.unwrapped.reset):
            raise TypeError(
                f"{name} derives from gymnasium.Env, but its reset() takes no `seed`; derive it from "
                "atari.classic.Env, or let reset(self, *, seed=None, options=None) return observation and info"
            )
        return env

    def __call__(self, **options: Any) -> gymnasium.Env[Any, Any]:
        """Make an environment with the new interface."""
        creator = self.load()
        render_mode = options.get("render_mode")
        modern_class = isinstance(creator, type) and issubclass(creator, gymnasium.Env)
        given = modern_class or "render_mode" in inspect.signature(creator).parameters
        if not given:
            options.pop("render_mode", None)
        env = self.create(**options)
        if isinstance(env, Env):
            return Modern(env, render_mode)
        if render_mode is not None and not given:
            raise TypeError(f"the entry point of this {type(env).__name__} has no parameter render_mode; give it one")
        return env


def modern_metadata(metadata: dict[str, Any]) -> dict[str, Any]:
    """Metadata of an old-style environment with Gymnasium's keys."""
    old = {"render_modes": metadata.get("render.modes", []), "render_fps": metadata.get("video.frames_per_second", 30)}
    rest = {name: value for name, value in metadata.items() if name not in ("render.modes", "video.frames_per_second")}
    return {**old, **rest}


def _takes_seed(reset: Callable[..., Any]) -> bool:
    parameters = inspect.signature(reset).parameters
    return "seed" in parameters or any(each.kind == each.VAR_KEYWORD for each in parameters.values())
