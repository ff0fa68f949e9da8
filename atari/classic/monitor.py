"""`Monitor`: videos and statistics of the episodes of an environment, in the files that Gym's Monitor wrote."""

import os
from contextlib import suppress
from typing import Any, Literal

from atari.classic.core import Env, Step, Wrapper
from atari.classic.monitor_hooks import MonitorHooks, VideoCallable


class Monitor(MonitorHooks, Wrapper):
    """Writes videos of episodes 0, 1, 8, 27, ..., 1000, 2000, ..., and the statistics of all episodes.

    An episode ends when it is done, or with the next `reset`. A monitor that is open when the interpreter exits is
    closed then. A subclass may replace `_before_step`, `_after_step`, `_before_reset`, `_after_reset`,
    `_video_enabled`, `_env_info`, `_start`, `_flush`, `_set_mode`, `reset_video_recorder` and `_close_video_recorder`.

    Args:
        env: an environment.
        directory: the folder for the files; it is made if necessary.
        video_callable: a function of the number of an episode that returns whether to record it. None records the
            episodes above, False none. Environments that cannot render "rgb_array" or "ansi" are not recorded.
        force: remove the files of other monitors in the directory.
        resume: keep these files, and add to them.
        write_upon_reset: write the statistics after every reset, not only when closed.
        uid: a name in place of the process's number.
        mode: "training" or "evaluation", recorded with each episode.

    Raises:
        gymnasium.error.Error: another monitor wrote there, and neither `force` nor `resume` is given; from `step`: the
            episode is over.
        gymnasium.error.DependencyNotInstalled: PyAV is not installed (extra `video`); `video_callable=False` does not
            need it.

    Example:
        >>> import tempfile
        >>> import atari.classic as gym
        >>> class Silent(gym.wrappers.Monitor):
        ...     def _video_enabled(self):
        ...         return False
        >>> with Silent(gym.make("CartPole-v0"), tempfile.mkdtemp()) as env:
        ...     observation = env.reset()
        ...     result = env.step(0)
        >>> env.videos, env.get_episode_lengths()
        ([], [1])
    """

    def __init__(
        self,
        env: Env,
        directory: str | os.PathLike[str],
        video_callable: VideoCallable | Literal[False] | None = None,
        force: bool = False,
        resume: bool = False,
        write_upon_reset: bool = False,
        uid: str | None = None,
        mode: Literal["training", "evaluation"] | None = None,
    ) -> None:
        Wrapper.__init__(self, env)
        MonitorHooks.__init__(self, env)
        self._start(directory, video_callable, force, resume, write_upon_reset, uid, mode)

    def set_monitor_mode(self, mode: Literal["training", "evaluation"]) -> None:
        """Record the next episodes as training or evaluation.

        Raises:
            gymnasium.error.Error: it is neither.
        """
        self._set_mode(mode)

    def get_total_steps(self) -> int:
        """Steps so far."""
        return self.stats_recorder.total_steps

    def get_episode_rewards(self) -> list[float]:
        """The return of each episode that ended."""
        return self.stats_recorder.episode_rewards

    def get_episode_lengths(self) -> list[int]:
        """The number of steps of each episode that ended."""
        return self.stats_recorder.episode_lengths

    def close(self) -> None:
        """Write the files, and close the environment."""
        Wrapper.close(self)

    def _reset(self, **options: Any) -> Any:
        self._before_reset()
        observation = self.env.reset(**options)
        self._after_reset(observation)
        return observation

    def _step(self, action: Any) -> Step:
        self._before_step(action)
        observation, reward, done, info = self.env.step(action)
        done = self._after_step(observation, reward, done, info)
        return observation, reward, done, info

    def _close(self) -> None:
        self._finish()
        self.env.close()

    def __del__(self) -> None:
        with suppress(Exception):  # a finalizer has no caller; its modules may be gone
            self._finish()
