"""Wrappers that check, or that convert between Gym's interfaces of four and of five values."""

from typing import Any, Protocol, runtime_checkable

import numpy as np
from gymnasium.utils.step_api_compatibility import step_api_compatibility

from atari.classic import error
from atari.classic.checks import Checked
from atari.classic.core import Env, Step, Wrapper
from atari.classic.modern import Modern


class OrderEnforcing(Wrapper):
    """`step` before the first `reset` is an error.

    Raises:
        gymnasium.error.ResetNeeded: from `step`, and from `render` unless `disable_render_order_enforcing`.
    """

    def __init__(self, env: Env, disable_render_order_enforcing: bool = False) -> None:
        super().__init__(env)
        self._has_reset = False
        self._disable_render_order_enforcing = disable_render_order_enforcing

    @property
    def has_reset(self) -> bool:
        """Whether there was a reset."""
        return self._has_reset

    def _reset(self, **options: Any) -> Any:
        self._has_reset = True
        return self.env.reset(**options)

    def _step(self, action: Any) -> Step:
        if not self._has_reset:
            raise error.ResetNeeded("step() came before the first reset(); call env.reset() first")
        return self.env.step(action)

    def _render(self, *args: Any, **options: Any) -> Any:
        if not self._disable_render_order_enforcing and not self._has_reset:
            raise error.ResetNeeded("render() came before the first reset(); call env.reset() first")
        return self.env.render(*args, **options)


class PassiveEnvChecker(Checked):
    """Checks actions and results; see `atari.classic.checks.Checked`."""

    def __init__(self, env: Env) -> None:
        super().__init__(env)
        self.checked_reset = self.checked_step = self.checked_render = False

    def _reset(self, **options: Any) -> Any:
        self.checked_reset = True
        return super()._reset(**options)

    def _step(self, action: Any) -> Step:
        self.checked_step = True
        return super()._step(action)

    def _render(self, *args: Any, **options: Any) -> Any:
        self.checked_render = True
        return super()._render(*args, **options)


class StepAPICompatibility(Wrapper):
    """`step` returns five values, with terminated and truncated, or four if `output_truncation_bool` is False.

    Example:
        >>> import atari.classic as gym
        >>> env = gym.wrappers.StepAPICompatibility(gym.make("CartPole-v1"))
        >>> observation = env.reset()
        >>> len(env.step(0))
        5
    """

    def __init__(self, env: Env, output_truncation_bool: bool = True) -> None:
        super().__init__(env)
        self.output_truncation_bool = output_truncation_bool
        self.is_vector_env = getattr(env, "is_vector_env", False)

    def _step(self, action: Any) -> Any:
        return step_api_compatibility(self.env.step(action), self.output_truncation_bool, self.is_vector_env)


@runtime_checkable
class LegacyEnv(Protocol):
    """An environment of the interface of four values."""

    observation_space: Any
    action_space: Any

    def reset(self) -> Any:
        """Start an episode and return its first observation."""

    def step(self, action: Any) -> Step:
        """Take an action; return observation, reward, done and info."""

    def render(self, mode: str | None = "human") -> Any:
        """Show it, or return an image or text."""

    def close(self) -> None:
        """Release its resources."""

    def seed(self, seed: int | None = None) -> Any:
        """Seed its generators."""


class EnvCompatibility(Modern):
    """An environment of the interface of four values, with that of five and Gymnasium's `reset`.

    Args:
        old_env: the environment, `env`.
        render_mode: the mode for its `render`.
    """

    def __init__(self, old_env: Env, render_mode: str | None = None) -> None:
        super().__init__(old_env, render_mode)
        self.env = old_env
        self.reward_range = old_env.reward_range

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Seed the environment, if `seed` is given, and start a new episode. `options` are ignored."""
        return super().reset(seed=seed, options=options)

    def render(self) -> Any:
        """What the environment's `render` returns for this mode."""
        return self._render()

    def _show(self) -> None:
        if self.render_mode == "human":
            self.render()


class VectorListInfo(Wrapper):
    """The infos of a vector are a list with a dictionary for each environment.

    Vectors of this package have such a list already. One dictionary of arrays, as of a vector of Gym 0.26, is
    converted: `infos["k"][i]` is the value of environment i if `infos["_k"][i]` is true.

    Raises:
        TypeError: the environment is no vector.
    """

    def __init__(self, env: Env) -> None:
        if not getattr(env, "is_vector_env", False):
            raise TypeError(f"VectorListInfo is for vectors, such as gym.vector.make(...), got {env}")
        super().__init__(env)

    def _step(self, action: Any) -> Any:
        *results, infos = self.env.step(action)
        return *results, self._convert_info_to_list(infos)

    def _convert_info_to_list(self, infos: Any) -> list[dict[str, Any]]:
        if not isinstance(infos, dict):
            return list(infos)
        lists: list[dict[str, Any]] = [{} for _ in range(self.env.num_envs)]  # type: ignore[attr-defined]
        lists = self._process_episode_statistics(infos, lists)
        for key, values in infos.items():
            if key.startswith("_") or key == "episode":
                continue
            for lane in np.flatnonzero(infos[f"_{key}"]):
                lists[lane][key] = values[lane]
        return lists

    def _process_episode_statistics(self, infos: dict[str, Any], list_info: list[dict[str, Any]]) -> Any:
        for lane in np.flatnonzero(infos.get("_episode", ())):
            list_info[lane]["episode"] = {key: infos["episode"][key][lane] for key in "rlt"}
        return list_info
