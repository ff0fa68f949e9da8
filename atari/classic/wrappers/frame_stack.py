"""`FrameStack`: the last few observations at once."""

from atari.classic.core import Env
from atari.classic.wrappers.bridge import Bridge


class FrameStack(Bridge):
    """Observations contain the last `num_stack`, the oldest first, in shape (num_stack, *shape).

    They share their frames, and become arrays when NumPy converts them: `np.array(observation)`.

    Args:
        env: an environment with Box observations.
        num_stack: the number of stacked observations.
        lz4_compress: has no effect; shared frames need no compression.
    """

    def __init__(self, env: Env, num_stack: int, lz4_compress: bool = False) -> None:
        from atari.wrappers import FrameStack as GymnasiumFrameStack  # imported here because it imports OpenCV

        super().__init__(env, lambda inside: GymnasiumFrameStack(inside, num_stack, lazy=True))
        self.num_stack = num_stack
