"""`Schedule`: the episodes and steps that Gymnasium's `RecordVideo` would record, with the same file names.

Gymnasium decides after a reset or a step and records the frame after it. `Schedule` decides before the reset or step,
so that the video includes the frames inside it. The recorded episodes and steps are the same.
"""

from collections.abc import Callable
from math import inf
from typing import Any

from atari.base.validation import check_integer

Trigger = Callable[[int], bool]


def capped_cubic_video_schedule(episode_id: int) -> bool:
    """Return whether Gymnasium's default records an episode: 0, 1, 8, 27, ... 729, 1000, then every 1000th."""
    if episode_id < 1000:
        return bool(round(episode_id ** (1.0 / 3)) ** 3 == episode_id)
    return episode_id % 1000 == 0


class Schedule:
    """The counters of episodes and steps, and the names of the videos that begin with the next one.

    See `RecordVideo` for the arguments. A reset counts as a step of `video_length`.

    Raises:
        TypeError, ValueError: a trigger is not a function, or the length is not an integer of 0 or more.
    """

    def __init__(
        self, episode_trigger: Trigger | None, step_trigger: Trigger | None, video_length: int, name_prefix: str
    ) -> None:
        if episode_trigger is None and step_trigger is None:
            episode_trigger = capped_cubic_video_schedule
        self.video_length: float = inf
        self.set("episode_trigger", episode_trigger)
        self.set("step_trigger", step_trigger)
        self.set("video_length", video_length)
        self.set("name_prefix", name_prefix)
        self.episode_id = self.step_id = -1
        self._checked: dict[str, int] = {}  # by unit: the last number that was passed to its trigger
        self._counted = 0

    episode_trigger: Trigger | None
    step_trigger: Trigger | None
    name_prefix: str

    def set(self, name: str, value: Any) -> None:
        """Set an argument for the videos that begin from now on, and `video_length` for the open one too.

        Raises:
            TypeError, ValueError: the value is of the wrong kind or out of range.
        """
        if name.endswith("_trigger") and value is not None and not callable(value):
            raise TypeError(f"{name} is a function of a number, got {value!r}")
        if name == "name_prefix" and not isinstance(value, str):
            raise TypeError(f"name_prefix is a text, got {value!r}")
        if name == "video_length" and value != inf:
            value = check_integer(name, value, 0, 2**31) or inf
        setattr(self, name, value)

    @property
    def by_episode(self) -> bool:
        """Whether videos end with their episode."""
        return self.video_length == inf

    def episode_video(self) -> str | None:
        """Return the name of the video that begins with the next episode, or None. Each trigger is called once."""
        return self._video("episode", self.episode_trigger, self.episode_id + 1)

    def step_video(self) -> str | None:
        """Return the name of the video that begins with the next step, or None. Each trigger is called once."""
        return self._video("step", self.step_trigger, self.step_id + 1)

    def _video(self, unit: str, trigger: Trigger | None, number: int) -> str | None:
        if trigger is None or number == self._checked.get(unit):
            return None
        self._checked[unit] = number
        return f"{self.name_prefix}-{unit}-{number}" if trigger(number) else None

    def start_video(self) -> None:
        """Reset the counter of the steps in a video."""
        self._counted = 0

    def count_step(self) -> bool:
        """Count a recorded step or reset and return whether it is the video's last one."""
        self._counted += 1
        return self._counted > self.video_length
