"""`Adapter`: a Gymnasium environment with Gym's old interface.

Gymnasium moved three things, which `Adapter` moves back:

- The seed is an argument of `reset`, not of a method. `seed` stores it for the next `reset`.
- The render mode is an argument of the constructor, not of `render`. The environment is made with a mode that opens no
  window; `render` sets another mode for the length of the call.
- `done` is split into terminated and truncated. `done` means either; `info["TimeLimit.truncated"]` distinguishes them.
"""

import copy
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
)  # these draw from a generator of Gym
_OWN = frozenset({"action_space", "observation_space"})

CLASSES: dict[type[Modern], "type[Adapter]"] = {}
"""The class of the adapter by the class of the adapted environment, for the classes that scripts import from Gym."""


class Adapter(Env):
    """A Gymnasium environment with the old interface.

    Other attributes, such as `gravity`, `state` or `get_action_meanings`, are read from and written to the unwrapped
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
        self.metadata = old_metadata(modern.unwrapped)
        self._pending_seed: int | None = None
        self._np_random: Any = None
        self._started = False
        self.viewer: Viewer | None = None
        """The window of `render()`; None before it opens."""

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
        made = "viewer" in self.__dict__
        if not made or name in _OWN or name in self.__dict__ or hasattr(type(self), name):
            super().__setattr__(name, value)
        else:
            setattr(self.modern.unwrapped, name, value)

    @property
    def np_random(self) -> Any:
        """A generator with Gym's stream: NumPy's `RandomState`, with `randint` and `rand`, which `seed` seeds.

        Classic control and toy text draw from it. Other environments have a generator of their own besides, which the
        next `reset` seeds.
        """
        if self._np_random is None:
            self.np_random = seeding.np_random()[0]
        return self._np_random

    @np_random.setter
    def np_random(self, generator: Any) -> None:
        self._np_random = generator
        if self._draws_as_gym():
            self.modern.unwrapped.np_random = generator

    def seed(self, seed: int | None = None) -> list[int]:
        """Seed `np_random` now, and the environment at the next `reset`; None chooses a seed. Returns the seed.

        Classic control and toy text then have Gym's episodes, as printed in books.

        Raises:
            ValueError: it is no integer of 0 or more.
        """
        if seed is None:
            seed = secrets.randbits(31)
        if not isinstance(seed, (int, np.integer)) or seed < 0:
            raise ValueError(f"a seed is an integer of 0 or more, or None, got {seed!r}")
        self.np_random = seeding.np_random(int(seed))[0]
        if not self._draws_as_gym():
            self._pending_seed = int(seed)
        return [int(seed)]

    def reset(self, **options: Any) -> Any:
        """Start a new episode and return its first observation.

        Raises:
            TypeError: options were given, such as Gymnasium's `seed`.
        """
        if options:
            raise TypeError(
                f"reset() takes no {' or '.join(options)} here; call env.seed(0) before it, or use gymnasium.make"
            )
        observation = self.modern.reset(seed=self._pending_seed)[0]
        self._pending_seed = None
        self._started = True
        return observation

    def step(self, action: Any) -> Step:
        """Take an action; `info` has "TimeLimit.truncated" if a limit, not the task, ended the episode.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        if not self._started:
            self._before_reset()
        action = to_action(self.action_space, action)
        observation, reward, terminated, truncated, info = self._play(action)
        if truncated:
            info["TimeLimit.truncated"] = not terminated
        if "lives" in info:
            info["ale.lives"] = info["lives"]  # its name until 2021
        return observation, reward, bool(terminated or truncated), info

    def render(self, mode: str = "human", close: bool = False, **_: Any) -> Any:
        """Show the environment in a window or print it as text ("human"), or return it ("rgb_array" or "ansi").

        Before the first reset, it renders the start of the first episode. With a window, it returns whether the window
        is open.

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
            self.preview()
        if mode != "human":
            return self._render_as(mode)
        if "ansi" in modes:
            print(self._render_as("ansi"))
        elif "rgb_array" in modes:
            return self._show(self._render_as("rgb_array"))
        else:
            self._render_as("human")
        return None

    def close(self) -> None:
        """Close the environment and its window."""
        self._close_viewer()
        self.modern.close()

    def __str__(self) -> str:
        return f"<{type(self.modern.unwrapped).__name__}{f'<{self.spec.id}>' if self.spec else ' instance'}>"

    _step, _reset, _render, _close, _seed = step, reset, render, close, seed  # their names before 2018

    def preview(self) -> None:
        """Put the environment at the start of its first episode, which the first `reset` repeats if it is seeded."""
        generator = copy.deepcopy(self._np_random)
        self.modern.reset(seed=self._pending_seed)
        if generator is not None:
            self.np_random = generator

    def _before_reset(self) -> None:
        """Prepare a step before the first reset, or refuse it."""
        raise gymnasium.error.ResetNeeded("step() came before the first reset(); call env.reset() first")

    def _play(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        return self.modern.step(action)

    def _draws_as_gym(self) -> bool:
        return type(self.modern.unwrapped).__module__.startswith(_GYMS_OWN)

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

    def _show(self, rgb: Any) -> bool:
        if self.viewer is None:
            self.viewer = Viewer(
                self.spec.id if self.spec else "atari.classic",
                self.metadata["video.frames_per_second"],
                self.metadata["video.pixel_aspect"],
            )
        self.viewer.imshow(rgb)
        return self.viewer.isopen

    def _close_viewer(self) -> None:
        viewer, self.viewer = self.viewer, None
        if viewer is not None:
            viewer.close()


class GoalAdapter(Adapter, GoalEnv):
    """An `Adapter` of an environment with goals, such as those of Gymnasium-Robotics."""

    def compute_reward(self, achieved_goal: Any, desired_goal: Any, info: dict[str, Any]) -> Any:
        """The reward for an achieved goal when another one was desired."""
        return self.modern.unwrapped.compute_reward(achieved_goal, desired_goal, info)  # type: ignore[attr-defined]


def adapt(modern: Modern) -> Adapter:
    """The adapter for a Gymnasium environment."""
    other = GoalAdapter if hasattr(modern.unwrapped, "compute_reward") else Adapter
    kind = CLASSES.get(type(modern.unwrapped), other)
    adapter = kind.__new__(kind)
    Adapter.__init__(adapter, modern)  # the classes of CLASSES have constructors that make an environment
    return adapter


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
            action = _index(action)
        except TypeError:
            raise TypeError(f"an action is an integer within 0..{space.n - 1}, got {action!r}") from None
    if not space.contains(action):
        what = f"within 0..{space.n - 1}" if isinstance(space, spaces.Discrete) else f"in {space}"
        raise ValueError(f"the action {action!r} is not {what}; env.action_space.sample() gives one that is")
    return action


def _index(action: Any) -> int:
    """The integer that an action is, or that is alone in it, as in `np.array([[3]])`."""
    if isinstance(action, (list, tuple, np.ndarray)):
        array = np.asarray(action)
        if array.size == 1 and array.dtype.kind in "iu":
            return int(array.item())
    return operator.index(action)


def old_metadata(env: "Modern | type[Modern]") -> dict[str, Any]:
    """The metadata of an environment or its class with Gym's keys."""
    metadata = dict(env.metadata)
    modes = [mode for mode in metadata.pop("render_modes", None) or [] if mode in ("human", "rgb_array", "ansi")]
    rate = metadata.pop("render_fps", None) or 30
    if modes and "human" not in modes:
        modes.insert(0, "human")  # `render` shows what the other modes return
    return {
        **metadata,
        "render.modes": modes,
        "video.frames_per_second": rate,
        "video.pixel_aspect": (2, 1) if env is AtariEnv or isinstance(env, AtariEnv) else (1, 1),
    }
