"""Wrappers that limit, begin or count episodes."""

import time
from collections import deque
from typing import Any

import numpy as np
from gymnasium import error

from atari.classic.core import Env, Step, Wrapper


class TimeLimit(Wrapper):
    """Episodes are done after `max_episode_steps` steps; `info["TimeLimit.truncated"]` distinguishes these ends.

    It is True if only the limit ended the episode, False if the limit coincided with the end, and absent before.

    Args:
        env: an environment.
        max_episode_steps: None means the limit of the environment's spec.

    Raises:
        ValueError: it is less than 1, or it is None and the spec has no limit.

    `step` raises:
        gymnasium.error.ResetNeeded: before the first reset.
    """

    def __init__(self, env: Env, max_episode_steps: int | None = None) -> None:
        super().__init__(env)
        if max_episode_steps is None and env.spec is not None:
            max_episode_steps = env.spec.max_episode_steps
        if max_episode_steps is None or max_episode_steps < 1:
            raise ValueError(f"max_episode_steps is a number of steps, 1 or more, got {max_episode_steps}")
        self._max_episode_steps = max_episode_steps
        self._elapsed_steps: int | None = None

    def _reset(self, **options: Any) -> Any:
        self._elapsed_steps = 0
        return self.env.reset(**options)

    def _step(self, action: Any) -> Step:
        if self._elapsed_steps is None:
            raise error.ResetNeeded("step() came before the first reset(); call env.reset() first")
        observation, reward, done, info = self.env.step(action)
        self._elapsed_steps += 1
        if self._past_limit():
            info["TimeLimit.truncated"] = not done
            done = True
        return observation, reward, done, info

    def _past_limit(self) -> bool:
        """Whether the episode ends at this step."""
        return (self._elapsed_steps or 0) >= self._max_episode_steps


class AutoResetWrapper(Wrapper):
    """Begins a new episode by itself: the observation of a last step is the first of the next episode.

    `info["final_observation"]` is the last observation then, and `info["final_info"]` the info of the last step.
    """

    def _step(self, action: Any) -> Step:
        observation, reward, done, info = self.env.step(action)
        if done:
            info = {"final_observation": observation, "final_info": info}
            observation = self.env.reset()
        return observation, reward, done, info


class RecordEpisodeStatistics(Wrapper):
    """`info["episode"]` at the end of an episode has its return "r", length "l" and time "t" in seconds.

    `return_queue` and `length_queue` have the returns and lengths of the last episodes.

    Args:
        env: an environment, or a vector of them.
        deque_size: the number of episodes in the queues.
    """

    def __init__(self, env: Env, deque_size: int = 100) -> None:
        super().__init__(env)
        self.is_vector_env = getattr(env, "is_vector_env", False)
        self.num_envs = getattr(env, "num_envs", 1)
        self.t0 = time.perf_counter()
        self.episode_count = 0
        self.return_queue: deque[float] = deque(maxlen=deque_size)
        self.length_queue: deque[int] = deque(maxlen=deque_size)
        self.episode_returns = np.zeros(self.num_envs)
        self.episode_lengths = np.zeros(self.num_envs, np.int32)

    @property
    def episode_return(self) -> float:
        """The return of the present episode."""
        return float(self.episode_returns[0])

    @property
    def episode_length(self) -> int:
        """The steps of the present episode."""
        return int(self.episode_lengths[0])

    def _reset(self, **options: Any) -> Any:
        observation = self.env.reset(**options)
        self.episode_returns[:], self.episode_lengths[:] = 0, 0
        return observation

    def _step(self, action: Any) -> Step:
        observation, reward, done, info = self.env.step(action)
        self.episode_returns += reward
        self.episode_lengths += 1
        infos: Any = info if self.is_vector_env else [info]
        for lane in np.flatnonzero(done).tolist():
            self._end(lane, infos[lane])
        return observation, reward, done, info

    def _end(self, lane: int, info: dict[str, Any]) -> None:
        result, length = float(self.episode_returns[lane]), int(self.episode_lengths[lane])
        info["episode"] = {"r": result, "l": length, "t": round(time.perf_counter() - self.t0, 6)}
        self.return_queue.append(result)
        self.length_queue.append(length)
        self.episode_count += 1
        self.episode_returns[lane], self.episode_lengths[lane] = 0, 0


def add_vector_episode_statistics(
    info: dict[str, Any], episode_info: dict[str, Any], num_envs: int, env_num: int
) -> dict[str, Any]:
    """Add the statistics of an environment's episode to the one info of a vector, as Gym 0.26 did.

    Args:
        info: the info of the vector, whose "episode" has arrays and whose "_episode" says for which environments.
        episode_info: "r", "l" and "t" of the episode.
        num_envs: the number of environments.
        env_num: the number of the environment.
    """
    episodes = info.setdefault("episode", {key: np.zeros(num_envs) for key in episode_info})
    for key, value in episode_info.items():
        episodes[key][env_num] = value
    info.setdefault("_episode", np.zeros(num_envs, np.bool_))[env_num] = True
    return info
