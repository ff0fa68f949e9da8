"""`TimeLimit`: end an episode after a number of steps."""

from typing import Any

from atari.classic.core import Env, Step, Wrapper


class TimeLimit(Wrapper):
    """Episodes are done after `max_episode_steps` steps; `info["TimeLimit.truncated"]` distinguishes these ends.

    It is True if only the limit ended the episode, False if the limit coincided with the end, and absent before.

    Args:
        env: an environment.
        max_episode_steps: None means the limit of the environment's spec.

    Raises:
        ValueError: it is less than 1, or it is None and the spec has no limit.
    """

    def __init__(self, env: Env, max_episode_steps: int | None = None) -> None:
        super().__init__(env)
        if max_episode_steps is None and env.spec is not None:
            max_episode_steps = env.spec.max_episode_steps
        if max_episode_steps is None or max_episode_steps < 1:
            raise ValueError(f"max_episode_steps is a number of steps, 1 or more, got {max_episode_steps}")
        self._max_episode_steps = max_episode_steps
        self._elapsed_steps = 0

    def _reset(self, **options: Any) -> Any:
        self._elapsed_steps = 0
        return self.env.reset(**options)

    def _step(self, action: Any) -> Step:
        observation, reward, done, info = self.env.step(action)
        self._elapsed_steps += 1
        if self._past_limit():
            info["TimeLimit.truncated"] = not done
            done = True
        return observation, reward, done, info

    def _past_limit(self) -> bool:
        """Whether the episode ends at this step."""
        return self._elapsed_steps >= self._max_episode_steps
