"""`Adapter`: a Gymnasium environment with Gym's old interface.

Gymnasium moved three things, which `Adapter` moves back:

- The seed is an argument of `reset`, not of a method. `seed` stores it for the next `reset`.
- The render mode is an argument of the constructor, not of `render`. The environment is made with a mode that opens no
  window; `render` sets another mode for the length of the call.
- `done` is split into terminated and truncated. `done` means either; `info["TimeLimit.truncated"]` distinguishes them.
"""

import inspect
import operator
import secrets
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from atari import AtariEnv
from atari.classic.core import Env, GoalEnv, Step
from atari.classic.spaces import from_gymnasium
from atari.classic.utils import seeding
from atari.classic.viewer import Viewer

Modern = gymnasium.Env[Any, Any]

_COUNTED = {"nS": "observation_space", "nA": "action_space"}  # attributes of Gym's toy text environments
_GYMS_OWN = (
    "gymnasium.envs.classic_control.",
    "gymnasium.envs.toy_text.",
)  # these are seeded like in Gym
_OWN = frozenset({"action_space", "metadata", "observation_space", "reward_range", "spec"})


class Adapter(Env):
    """A Gymnasium environment with the old interface.

    Other attributes, such as `ale`, `state` or `get_action_meanings`, are read from and written to the unwrapped
    Gymnasium environment.

    Args:
        modern: the environment, made with render mode "rgb_array" or "ansi" if it has one of them.

    `step` raises:
        gymnasium.error.ResetNeeded: before the first reset.
        TypeError, ValueError: the action is not in the action space.
    """

    def __init__(self, modern: Modern) -> None:
        self.modern = modern
        self.action_space = from_gymnasium(modern.action_space)
        self.observation_space = from_gymnasium(modern.observation_space)
        self.metadata = _old_metadata(modern)
        self._pending_seed: int | None = None
        self._started = False
        self._viewer: Viewer | None = None

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or name == "modern":
            raise AttributeError(name)
        if name in _COUNTED and isinstance(space := getattr(self, _COUNTED[name]), spaces.Discrete):
            return int(space.n)
        try:
            return getattr(self.modern.unwrapped, name)
        except AttributeError:
            kind = type(self.modern.unwrapped).__name__
            raise AttributeError(f"this {kind} has no attribute {name!r}") from None

    def __setattr__(self, name: str, value: Any) -> None:
        if name in _OWN or "_viewer" not in self.__dict__ or name in self.__dict__:
            super().__setattr__(name, value)
        else:
            setattr(self.modern.unwrapped, name, value)

    def seed(self, seed: int | None = None) -> list[int]:
        """Store the seed for the next `reset`; None chooses one. Returns the seed.

        Classic control and toy text then have Gym's episodes, as printed in books.

        Raises:
            ValueError: it is no integer of 0 or more.
        """
        if seed is None:
            seed = secrets.randbits(31)
        if not isinstance(seed, (int, np.integer)) or seed < 0:
            raise ValueError(f"a seed is an integer of 0 or more, or None, got {seed!r}")
        self._pending_seed = int(seed)
        return [self._pending_seed]

    def reset(self, **options: Any) -> Any:
        """Start a new episode and return its first observation.

        Raises:
            TypeError: options were given, such as Gymnasium's `seed`.
        """
        if options:
            raise TypeError(
                f"reset() takes no {' or '.join(options)} here; call env.seed(0) before it, or use gymnasium.make"
            )
        observation = self._begin(self._pending_seed)
        self._pending_seed = None
        self._started = True
        return observation

    def step(self, action: Any) -> Step:
        """Take an action; `info` has "TimeLimit.truncated" if a limit, not the task, ended the episode.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        if not self._started:
            raise gymnasium.error.ResetNeeded("step() came before the first reset(); call env.reset() first")
        action = to_action(self.action_space, action)
        observation, reward, terminated, truncated, info = self.modern.step(action)
        if truncated:
            info["TimeLimit.truncated"] = not terminated
        if "lives" in info:
            info["ale.lives"] = info["lives"]  # its name until 2021
        return observation, reward, bool(terminated or truncated), info

    def render(self, mode: str = "human", close: bool = False, **_: Any) -> Any:
        """Show the environment in a window or print it as text ("human"), or return it ("rgb_array" or "ansi").

        Before the first reset, it renders a possible start of an episode.

        Raises:
            gymnasium.error.UnsupportedMode: the environment has no such mode.
            gymnasium.error.DependencyNotInstalled: pygame is not installed.
            gymnasium.error.Error: the display does not work.
        """
        if close:
            self._close_viewer()
            return None
        modes = self.metadata["render.modes"]
        if mode not in modes:
            offered = ", ".join(modes) or "no mode"
            raise gymnasium.error.UnsupportedMode(f"this environment cannot render {mode!r}; it has {offered}")
        if not self._started:
            self._begin(self._pending_seed)
        if mode != "human":
            return self._render_as(mode)
        if "ansi" in modes:
            print(self._render_as("ansi"))
        elif "rgb_array" in modes:
            self._show(self._render_as("rgb_array"))
        else:
            self._render_as("human")
        return None

    def close(self) -> None:
        """Close the environment and its window."""
        self._close_viewer()
        self.modern.close()

    def __str__(self) -> str:
        return f"<{type(self.modern.unwrapped).__name__}{f'<{self.spec.id}>' if self.spec else ' instance'}>"

    def _begin(self, seed: int | None) -> Any:
        env = self.modern.unwrapped
        if seed is not None and type(env).__module__.startswith(_GYMS_OWN):
            env.np_random, seed = seeding.np_random(seed)[0], None  # type: ignore[assignment]
        return self.modern.reset(seed=seed)[0]

    def _render_as(self, mode: str) -> Any:
        env = self.modern.unwrapped
        made_with, env.render_mode = env.render_mode, mode
        try:
            return self.modern.render()
        except Exception as error:
            if type(error).__module__.startswith("mujoco"):
                raise gymnasium.error.Error(
                    f"MuJoCo cannot draw here ({error}); without a display, set the environment variable MUJOCO_GL=egl"
                ) from None
            raise
        finally:
            env.render_mode = made_with

    def _show(self, rgb: Any) -> None:
        if self._viewer is None:
            self._viewer = Viewer(
                self.spec.id if self.spec else "atari.classic",
                self.metadata["video.frames_per_second"],
                self.metadata["video.pixel_aspect"],
            )
        self._viewer.show(rgb)

    def _close_viewer(self) -> None:
        viewer, self._viewer = self._viewer, None
        if viewer is not None:
            viewer.close()


class GoalAdapter(Adapter, GoalEnv):
    """An `Adapter` of an environment with goals, such as those of Gymnasium-Robotics."""

    def compute_reward(self, achieved_goal: Any, desired_goal: Any, info: dict[str, Any]) -> Any:
        """The reward for an achieved goal when another one was desired."""
        return self.modern.unwrapped.compute_reward(achieved_goal, desired_goal, info)  # type: ignore[attr-defined]


def adapt(modern: Modern) -> Adapter:
    """The adapter for a Gymnasium environment."""
    return (GoalAdapter if hasattr(modern.unwrapped, "compute_reward") else Adapter)(modern)


def quiet_options(creator: Any) -> dict[str, Any]:
    """The option `render_mode` with which an environment shows nothing before `render`.

    The result is empty if the environment has no such mode, no such argument, or the old interface.
    """
    metadata = getattr(creator, "metadata", None)
    modes = metadata.get("render_modes") or () if isinstance(metadata, dict) else ()
    quiet = next((mode for mode in ("rgb_array", "ansi") if mode in modes), None)
    if quiet is None or (isinstance(creator, type) and issubclass(creator, Env)):
        return {}
    parameters = inspect.signature(creator).parameters.values()
    takes_mode = any(p.name == "render_mode" or p.kind is p.VAR_KEYWORD for p in parameters)
    return {"render_mode": quiet} if takes_mode else {}


def to_action(space: spaces.Space[Any], action: Any) -> Any:
    """The action, checked in the type that the environment expects.

    Raises:
        TypeError, ValueError: it is not in the space. Numbers beyond a Box's bounds are accepted: environments clip
            them.
    """
    if isinstance(space, spaces.Box):
        try:
            array = np.asarray(action, space.dtype)
        except (TypeError, ValueError, OverflowError):
            raise TypeError(f"an action is an array of shape {space.shape}, got {action!r}") from None
        if array.size != np.prod(space.shape):
            raise ValueError(f"an action is an array of shape {space.shape}, got one of shape {array.shape}")
        return array.reshape(space.shape)
    if isinstance(space, spaces.Discrete):
        try:
            action = operator.index(action)
        except TypeError:
            raise TypeError(f"an action is an integer within 0..{space.n - 1}, got {action!r}") from None
    if not space.contains(action):
        what = f"within 0..{space.n - 1}" if isinstance(space, spaces.Discrete) else f"in {space}"
        raise ValueError(f"the action {action!r} is not {what}; env.action_space.sample() gives one that is")
    return action


def _old_metadata(modern: Modern) -> dict[str, Any]:
    metadata = dict(modern.metadata)
    modes = [mode for mode in metadata.pop("render_modes", None) or [] if mode in ("human", "rgb_array", "ansi")]
    rate = metadata.pop("render_fps", None) or 30
    if modes and "human" not in modes:
        modes.insert(0, "human")  # `render` shows what the other modes return
    return {
        **metadata,
        "render.modes": modes,
        "video.frames_per_second": rate,
        "video.pixel_aspect": (2, 1) if isinstance(modern.unwrapped, AtariEnv) else (1, 1),
    }
