"""The other direction: an old-style environment for `gymnasium.make`, Gymnasium's wrappers and vector environments.

`EntryPoint` is what `atari.classic.register` puts into Gymnasium's registry. Whether a class is of the old or the new
interface shows when it is first needed, as its name may be all that was registered.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import gymnasium
from gymnasium.envs.registration import load_env_creator

from atari.classic.core import Env


class Modern(gymnasium.Env[Any, Any]):
    """An old-style environment with Gymnasium's interface.

    Args:
        classic: the environment.
        render_mode: how `render` calls it: "human", "rgb_array", "ansi".
    """

    def __init__(self, classic: Env, render_mode: str | None = None) -> None:
        self.classic = classic
        self.render_mode = render_mode
        self.action_space = classic.action_space
        self.observation_space = classic.observation_space
        self.metadata = modern_metadata(classic.metadata)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Seed the environment, if asked to, and start a new episode."""
        super().reset(seed=seed)
        if seed is not None:
            self.classic.seed(seed)
        return self.classic.reset(), {}

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Take an action; `info["TimeLimit.truncated"]` becomes `truncated`."""
        observation, reward, done, info = self.classic.step(action)
        truncated = bool(done and info.get("TimeLimit.truncated", False))
        return observation, reward, bool(done) and not truncated, truncated, info

    def render(self) -> Any:
        """What the environment's `render` returns in this mode."""
        return None if self.render_mode is None else self.classic.render(mode=self.render_mode)

    def close(self) -> None:
        """Close the environment."""
        self.classic.close()


@dataclass(frozen=True)
class EntryPoint:
    """A class, or where it is, that makes environments of either interface."""

    entry_point: str | Callable[..., Any]

    def load(self) -> Callable[..., Any]:
        """The class."""
        if isinstance(self.entry_point, str):
            return load_env_creator(self.entry_point)
        return self.entry_point

    @property
    def metadata(self) -> dict[str, Any]:
        """That of the class, in Gymnasium's words."""
        return modern_metadata(getattr(self.load(), "metadata", {}))

    def __call__(self, **options: Any) -> gymnasium.Env[Any, Any]:
        """Make an environment of the new interface."""
        creator: Any = self.load()
        if isinstance(creator, type) and issubclass(creator, gymnasium.Env):
            return creator(**options)  # type: ignore[no-any-return]
        render_mode = options.pop("render_mode", None)
        return Modern(creator(**options), render_mode)


def modern_metadata(metadata: dict[str, Any]) -> dict[str, Any]:
    """Metadata of an old-style environment in Gymnasium's words."""
    modes = metadata.get("render_modes", metadata.get("render.modes", []))
    return {**metadata, "render_modes": modes, "render_fps": metadata.get("video.frames_per_second", 30)}
