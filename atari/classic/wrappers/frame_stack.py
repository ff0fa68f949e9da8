"""`FrameStack`: the last few observations at once."""

from collections import deque
from collections.abc import Iterable
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from atari.classic.core import Env, ObservationWrapper, Step
from atari.classic.spaces import Box


class LazyFrames:
    """A stack of frames that becomes an array when NumPy converts it; stacks share their common frames.

    Args:
        frames: arrays of one shape and dtype.
        lz4_compress: has no effect; shared frames need no compression.
    """

    __slots__ = ("_frames", "lz4_compress")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, frames: Iterable[Any], lz4_compress: bool = False) -> None:
        self._frames = tuple(frames)
        self.lz4_compress = lz4_compress

    @property
    def frame_shape(self) -> tuple[int, ...]:
        """The shape of a frame."""
        return np.shape(self._frames[0])

    @property
    def shape(self) -> tuple[int, ...]:
        """(number of frames, *shape of a frame)."""
        return (len(self._frames), *self.frame_shape)

    @property
    def dtype(self) -> np.dtype[Any]:
        """The dtype of the frames."""
        return np.asarray(self._frames[0]).dtype

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        # With copy=False it copies too: in NumPy of Gym's time, that meant "copy only if necessary".
        array = np.stack([self._check_decompress(frame) for frame in self._frames])
        return array if dtype is None else array.astype(dtype, copy=False)

    def __len__(self) -> int:
        return len(self._frames)

    def __getitem__(self, index: Any) -> Any:
        return self._check_decompress(self._frames[index]) if isinstance(index, int) else self.__array__()[index]

    def __eq__(self, other: object) -> Any:
        return self.__array__() == np.asarray(other)

    def _check_decompress(self, frame: Any) -> Any:
        """The frame as an array; a subclass may store it in another form."""
        return frame


class FrameStack(ObservationWrapper):
    """Observations contain the last `num_stack`, the oldest first, in shape (num_stack, *shape).

    They are `LazyFrames`.

    Args:
        env: an environment with Box observations.
        num_stack: the number of stacked observations.
        lz4_compress: has no effect; shared frames need no compression.

    Raises:
        TypeError: the observations are not a Box.
        ValueError: `num_stack` is less than 1.
    """

    def __init__(self, env: Env, num_stack: int, lz4_compress: bool = False) -> None:
        space = env.observation_space
        if not isinstance(space, gymnasium.spaces.Box):
            raise TypeError(f"FrameStack stacks the arrays of a Box space, got {space}")
        if num_stack < 1:
            raise ValueError(f"num_stack is a number of observations, 1 or more, got {num_stack}")
        super().__init__(env)
        self.num_stack = num_stack
        self.lz4_compress = lz4_compress
        self.frames: deque[Any] = deque(maxlen=num_stack)
        low, high = (np.repeat(bound[None], num_stack, axis=0) for bound in (space.low, space.high))
        self.observation_space = Box(low, high, dtype=space.dtype)

    def _reset(self, **options: Any) -> LazyFrames:
        self.frames.extend([self.env.reset(**options)] * self.num_stack)
        return self.observation()  # type: ignore[no-any-return]

    def _step(self, action: Any) -> Step:
        observation, reward, done, info = self.env.step(action)
        self.frames.append(observation)
        return self.observation(), reward, done, info

    def observation(self, observation: Any = None) -> Any:
        """The stack; the argument, which Gym 0.26 has, has no effect."""
        return self._get_observation()

    def _get_observation(self) -> LazyFrames:
        return LazyFrames(self.frames, self.lz4_compress)
