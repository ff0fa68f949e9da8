"""`FrameSkip`: repeat each action for several frames.

The console draws 60 frames a second, more than an agent needs. Many games draw some objects only every other frame,
so the observation is the maximum of the last two frames (Mnih et al. 2015).
"""

from typing import Any

import numpy as np

from atari.base.validation import check_integer
from atari.env.restorable import RestorableWrapper
from atari.wrappers._checks import Environment, require_pixels, require_single_frames


class FrameSkip(RestorableWrapper):
    """Play each action for `frame_skip` steps and sum the rewards.

    The observation is the maximum, pixel by pixel, of the last two frames played, also when the episode ends inside the
    skip. (`DqnPreprocessing` does this and the next steps faster.)

    Args:
        env: an environment that plays one frame a step.
        frame_skip: steps for each action, 1 or more.
        max_pool: False returns only the last observation; RAM needs False.

    Raises:
        TypeError, ValueError: `frame_skip` is not an integer, or less than 1; the environment already skips frames; the
            observations are not pixels and `max_pool` is true.

    Example:
        >>> import atari
        >>> from atari.wrappers import FrameSkip
        >>> env = FrameSkip(atari.AtariEnv("pong", frameskip=1), 4)
        >>> observation, info = env.reset(seed=0)
        >>> env.step(0)[4]["episode_frame_number"]
        4
    """

    def __init__(self, env: Environment, frame_skip: int = 4, max_pool: bool = True) -> None:
        frame_skip = check_integer("frame_skip", frame_skip, 1, 10_000)
        require_single_frames(env, "FrameSkip")
        if max_pool:
            require_pixels(env, "FrameSkip(max_pool=True)")
        super().__init__(env, frame_skip=frame_skip, max_pool=max_pool)
        self.frame_skip = frame_skip
        self._max_pool = max_pool

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Play the action until the skip or the episode ends."""
        previous: Any = None
        current: Any = None
        total = 0.0
        for _ in range(self.frame_skip):
            previous = current
            current, reward, terminated, truncated, info = self.env.step(action)
            total += float(reward)
            if terminated or truncated:
                break
        observation = np.maximum(previous, current) if self._max_pool and previous is not None else current
        return observation, total, terminated, truncated, info
