"""`Monitor`: videos and statistics of the episodes of an environment, in the files that Gym's Monitor wrote."""

import atexit
import os
from pathlib import Path
from typing import Any, Literal

from atari.classic.core import Env, Step, Wrapper
from atari.classic.episode_recorder import EpisodeRecorder, EpisodeStatistics, VideoCallable


class Monitor(Wrapper):
    """Writes videos of episodes 0, 1, 8, 27, ..., 1000, 2000, ..., and the statistics of all episodes.

    An episode ends when it is done, or with the next `reset`. A monitor that is open when the interpreter exits is
    closed then.

    Args:
        env: an environment.
        directory: the folder for the files; it is made if necessary.
        video_callable: a function of the number of an episode that returns whether to record it. None records the
            episodes above, False none. Environments that cannot render "rgb_array" are not recorded.
        force: remove the files of other monitors in the directory.
        resume: keep these files, and add to them.
        write_upon_reset: write the statistics after every episode, not only when closed.
        uid: a name in place of the process's number.
        mode: "training" or "evaluation", recorded with each episode.

    Raises:
        gymnasium.error.Error: another monitor wrote there, and neither `force` nor `resume` is given; from `step`: the
            episode is over.
        gymnasium.error.DependencyNotInstalled: PyAV is not installed (extra `video`); `video_callable=False` does not
            need it.
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
        super().__init__(env)
        self._recorder = EpisodeRecorder(env, directory, video_callable, force, resume, write_upon_reset, uid, mode)
        self.directory = self._recorder.directory
        self.file_infix = self._recorder.file_infix
        self.videos = self._recorder.videos
        atexit.register(self.close)

    @property
    def stats_path(self) -> Path:
        """The file of the statistics."""
        return self._recorder.stats_path

    @property
    def stats_recorder(self) -> EpisodeStatistics:
        """The statistics; a script sets its `done` to end an episode without steps to its end."""
        return self._recorder.statistics

    def get_total_steps(self) -> int:
        """Steps so far."""
        return self._recorder.statistics.total_steps

    def get_episode_rewards(self) -> list[float]:
        """The return of each episode that ended."""
        return self._recorder.statistics.rewards

    def get_episode_lengths(self) -> list[int]:
        """The number of steps of each episode that ended."""
        return self._recorder.statistics.lengths

    def _reset(self, **options: Any) -> Any:
        observation = self.env.reset(**options)
        self._recorder.begin_episode()
        return observation

    def _step(self, action: Any) -> Step:
        self._recorder.check_running()
        observation, reward, done, info = self.env.step(action)
        self._recorder.add_step(reward, done)
        return observation, reward, done, info

    def _close(self) -> None:
        atexit.unregister(self.close)
        self._recorder.close()
        self.env.close()
