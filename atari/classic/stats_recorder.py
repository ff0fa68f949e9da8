"""`StatsRecorder`: the statistics file of a monitor."""

import json
import os
import time
from typing import Any

from atari.classic import error
from atari.classic.monitor_files import atomic_write, json_encode_np


class StatsRecorder:
    """Records length, return and time of each episode, and writes them to a JSON file.

    A monitor calls `before_reset` and `after_reset` around a reset, and `before_step` and `after_step` around a step.
    A subclass may replace each of them. A script may set `done`, to end an episode without steps to its end. An episode
    that is reset or closed before its end counts with the steps that it had.

    Args:
        directory: the folder of the file.
        file_prefix: the beginning of its name, before ".stats.json".
        autoreset: the environment begins a new episode by itself: the observation of a last step is its first.
        env_id: the ID for error messages.

    Attributes:
        episode_lengths, episode_rewards: the steps and the return of each episode that ended.
        timestamps: the end of each, in seconds since 1970.
        episode_types: the `type` with which each episode began, with the present one.
        total_steps: the steps so far.
        steps, rewards: those of the present episode; None before the first reset.
        path: the file.

    Example:
        >>> import tempfile
        >>> from atari.classic.wrappers.monitoring.stats_recorder import StatsRecorder
        >>> recorder = StatsRecorder(tempfile.mkdtemp(), "openaigym.episode_batch.0")
        >>> recorder.before_reset(); recorder.after_reset(0)
        >>> recorder.before_step(1); recorder.after_step(0, 1.5, True, {})
        >>> recorder.close()
        >>> recorder.episode_lengths, recorder.episode_rewards
        ([1], [1.5])
    """

    def __init__(
        self, directory: str | os.PathLike[str], file_prefix: str, autoreset: bool = False, env_id: str | None = None
    ) -> None:
        self.autoreset = autoreset
        self.env_id = env_id
        self.initial_reset_timestamp: float | None = None
        self.directory = directory
        self.file_prefix = file_prefix
        self.episode_lengths: list[int] = []
        self.episode_rewards: list[float] = []
        self.episode_types: list[str] = []
        self.timestamps: list[float] = []
        self.steps: int | None = None
        self.total_steps = 0
        self.rewards: float | None = None
        self.done: bool | None = None
        self.closed = False
        self.path = os.path.join(directory, f"{file_prefix}.stats.json")
        self._type = "t"
        self._is_saved = True  # whether the lists have the present episode, or it has no steps

    @property
    def type(self) -> str:
        """ "t" for training, "e" for evaluation; it counts from the next reset on.

        Raises:
            gymnasium.error.Error: the assigned value is neither.
        """
        return self._type

    @type.setter
    def type(self, type: str) -> None:
        if type not in ("t", "e"):
            raise error.Error(f"the type of an episode is 't' for training or 'e' for evaluation, got {type!r}")
        self._type = type

    def before_step(self, action: Any) -> None:
        """Check that an episode is running.

        Raises:
            gymnasium.error.ResetNeeded: the episode is over, or there was no reset.
        """
        self._check_open()
        if self.done:
            raise error.ResetNeeded("the episode is over, and Monitor does not go on; call env.reset() first")
        if self.steps is None:
            raise error.ResetNeeded("step() came before the first reset(); call env.reset() first")

    def after_step(self, observation: Any, reward: Any, done: bool, info: dict[str, Any]) -> None:
        """Count a step."""
        self.steps = (self.steps or 0) + 1
        self.total_steps += 1
        self.rewards = (self.rewards or 0) + float(reward)
        self.done = done
        self._is_saved = False
        if done:
            self.save_complete()
            if self.autoreset:
                self.before_reset()
                self.after_reset(observation)

    def before_reset(self) -> None:
        """End the present episode."""
        self._check_open()
        if not self._is_saved:
            self.save_complete()
        self.done = False
        if self.initial_reset_timestamp is None:
            self.initial_reset_timestamp = time.time()

    def after_reset(self, observation: Any) -> None:
        """Begin an episode."""
        self.steps, self.rewards = 0, 0
        self._is_saved = True
        self.episode_types[len(self.episode_lengths) :] = [self._type]

    def save_complete(self) -> None:
        """Add the present episode to the lists."""
        if self.steps is not None and self.rewards is not None:
            self.episode_lengths.append(self.steps)
            self.episode_rewards.append(float(self.rewards))
            self.timestamps.append(time.time())
        self._is_saved = True

    def close(self) -> None:
        """Write the file, with an episode that is not over; later calls do nothing."""
        if not self.closed and not self._is_saved:
            self.save_complete()
        self.flush()
        self.closed = True

    def flush(self) -> None:
        """Write the file."""
        if self.closed:
            return
        with atomic_write(self.path) as file:
            json.dump(
                {
                    "initial_reset_timestamp": self.initial_reset_timestamp,
                    "timestamps": self.timestamps,
                    "episode_lengths": self.episode_lengths,
                    "episode_rewards": self.episode_rewards,
                    "episode_types": self.episode_types[: len(self.episode_lengths)],
                },
                file,
                default=json_encode_np,
            )

    def _check_open(self) -> None:
        if self.closed:
            raise error.Error("this recorder is closed; make another one")
