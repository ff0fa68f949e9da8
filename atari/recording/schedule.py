"""When to record: the episodes and steps that Gymnasium's `RecordVideo` would record, under the same names.

Gymnasium decides after a reset or a step and takes the screen that it led to. Here the decision comes before, so that
the frames inside the step are in the video too; what is recorded, and how files are named, is the same.
"""

from collections.abc import Callable
from math import inf

from atari.cores.options import check_integer

Trigger = Callable[[int], bool]


def capped_cubic_video_schedule(episode_id: int) -> bool:
    """Gymnasium's default: episodes 0, 1, 8, 27, ... 729, 1000, and every 1000th from there on."""
    if episode_id < 1000:
        return bool(round(episode_id ** (1.0 / 3)) ** 3 == episode_id)
    return episode_id % 1000 == 0


class Schedule:
    """Counts episodes and steps, and says which video begins with the next one.

    Args:
        episode_trigger: whether to record an episode, by its number; without any trigger, Gymnasium's schedule.
        step_trigger: whether to begin a recording with a step, by its number over all episodes.
        video_length: steps after which a video ends, counting resets; 0 is at the end of the episode.
        name_prefix: of the files.

    Raises:
        TypeError, ValueError: a trigger is no function, or the length no integer of 0 or more.
    """

    def __init__(
        self, episode_trigger: Trigger | None, step_trigger: Trigger | None, video_length: int, name_prefix: str
    ) -> None:
        if episode_trigger is None and step_trigger is None:
            episode_trigger = capped_cubic_video_schedule
        for name, trigger in (("episode_trigger", episode_trigger), ("step_trigger", step_trigger)):
            if trigger is not None and not callable(trigger):
                raise TypeError(f"{name} is a function of a number, got {trigger!r}")
        self.episode_trigger, self.step_trigger = episode_trigger, step_trigger
        self.video_length: float = check_integer("video_length", video_length, 0, 2**31) or inf
        self.name_prefix = name_prefix
        self.episode_id = self.step_id = -1
        self._asked_episode = self._asked_step = -1
        self._taken = 0

    @property
    def by_episode(self) -> bool:
        """Whether videos end where episodes do."""
        return self.video_length == inf

    def episode_video(self) -> str | None:
        """The name of the video that begins with the next episode, if one does. It is told once."""
        number = self.episode_id + 1
        if self.episode_trigger is None or number == self._asked_episode:
            return None
        self._asked_episode = number
        return f"{self.name_prefix}-episode-{number}" if self.episode_trigger(number) else None

    def step_video(self) -> str | None:
        """The name of the video that begins with the next step, if one does. It is told once."""
        number = self.step_id + 1
        if self.step_trigger is None or number == self._asked_step:
            return None
        self._asked_step = number
        return f"{self.name_prefix}-step-{number}" if self.step_trigger(number) else None

    def begin(self) -> None:
        """A video has begun."""
        self._taken = 0

    def take(self) -> bool:
        """A step or a reset is in the video; returns whether it is the last one."""
        self._taken += 1
        return self._taken > self.video_length
