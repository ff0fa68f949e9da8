"""Wrappers that choose, add, count or stack observations."""

from collections import deque
from collections.abc import Iterable
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from atari.classic.core import Env, ObservationWrapper, Step
from atari.classic.spaces import Box, Dict

STATE_KEY = "state"
"""The key of the observation inside the dictionary of `PixelObservationWrapper`."""


class FilterObservation(ObservationWrapper):
    """The parts `filter_keys` of a dictionary; None means all.

    Raises:
        TypeError: the observations are no dictionaries.
        ValueError: the dictionaries have no such part.
    """

    def __init__(self, env: Env, filter_keys: Iterable[str] | None = None) -> None:
        super().__init__(env)
        space = env.observation_space
        if not isinstance(space, gymnasium.spaces.Dict):
            raise TypeError(f"FilterObservation chooses parts of a Dict space, got {space}")
        self._env = env
        self._filter_keys = tuple(space.spaces if filter_keys is None else filter_keys)
        missing = [key for key in self._filter_keys if key not in space.spaces]
        if missing:
            raise ValueError(f"the observations have the parts {', '.join(space.spaces)}, got {missing[0]!r}")
        self.observation_space = Dict(self._filter_observation(space.spaces))

    def observation(self, observation: Any) -> Any:
        """The observation to return instead."""
        return self._filter_observation(observation)

    def _filter_observation(self, observation: Any) -> Any:
        return type(observation)((key, value) for key, value in observation.items() if key in self._filter_keys)


class TimeAwareObservation(ObservationWrapper):
    """Observations end with the number of the step in the episode, `t`.

    Raises:
        TypeError: the observations are no arrays of float32.
    """

    def __init__(self, env: Env) -> None:
        super().__init__(env)
        space = env.observation_space
        if not isinstance(space, gymnasium.spaces.Box) or space.dtype != np.float32:
            raise TypeError(f"TimeAwareObservation adds to the arrays of float32 of a Box space, got {space}")
        self.observation_space = Box(np.append(space.low, 0.0), np.append(space.high, np.inf), dtype=np.float32)
        self.t = 0
        self.is_vector_env: bool = getattr(env, "is_vector_env", False)

    def observation(self, observation: Any) -> Any:
        """The observation to return instead."""
        return np.append(observation, self.t)

    def _step(self, action: Any) -> Step:
        self.t += 1
        return super()._step(action)

    def _reset(self, **options: Any) -> Any:
        self.t = 0
        return super()._reset(**options)


class PixelObservationWrapper(ObservationWrapper):
    """Observations are dictionaries with an image for each of `pixel_keys`.

    Args:
        env: an environment that renders "rgb_array".
        pixels_only: without the observation of the environment. Else its parts are in the dictionary too, or the whole
            with the key "state" if it is no dictionary.
        render_kwargs: arguments of `render` for each key.
        pixel_keys: the keys.

    Raises:
        TypeError: the observations are neither arrays nor dictionaries, or the images neither integers nor floats.
        ValueError: a key is in the observations already, or the mode of `render` is not "rgb_array".
    """

    def __init__(
        self,
        env: Env,
        pixels_only: bool = True,
        render_kwargs: dict[str, dict[str, Any]] | None = None,
        pixel_keys: Iterable[str] = ("pixels",),
    ) -> None:
        super().__init__(env)
        space = env.observation_space
        if not isinstance(space, (gymnasium.spaces.Box, gymnasium.spaces.Dict)):
            raise TypeError(f"PixelObservationWrapper adds to the observations of a Box or Dict space, got {space}")
        self._env = env
        self._pixels_only = pixels_only
        self.render_history: list[Any] = []  # the frames between two steps, of which this interface renders none
        self._pixel_keys = tuple(pixel_keys)
        self._observation_is_dict = isinstance(space, gymnasium.spaces.Dict)
        self._render_kwargs = {
            key: {"mode": "rgb_array", **(render_kwargs or {}).get(key, {})} for key in self._pixel_keys
        }
        for options in self._render_kwargs.values():
            if options["mode"] != "rgb_array":
                raise ValueError(f"the mode of an image is 'rgb_array', got {options['mode']!r}")
        parts: dict[str, Any] = {}
        if not pixels_only:
            parts = dict(space.spaces) if isinstance(space, gymnasium.spaces.Dict) else {STATE_KEY: space}
        for key in self._pixel_keys:
            if key in parts:
                raise ValueError(f"the observations have a part {key!r} already; choose another name in pixel_keys")
            parts[key] = _space_of(self._render(**self._render_kwargs[key]))
        self.observation_space = Dict(parts)

    def observation(self, observation: Any) -> Any:
        """The observation to return instead."""
        return self._add_pixel_observation(observation)

    def _add_pixel_observation(self, wrapped_observation: Any) -> Any:
        observation: dict[str, Any] = {}
        if not self._pixels_only:
            if self._observation_is_dict:
                observation.update(wrapped_observation)
            else:
                observation[STATE_KEY] = wrapped_observation
        for key in self._pixel_keys:
            observation[key] = self._render(**self._render_kwargs[key])
        return observation


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
        return self.observation()

    def _step(self, action: Any) -> Step:
        observation, reward, done, info = self.env.step(action)
        self.frames.append(observation)
        return self.observation(), reward, done, info

    def observation(self, observation: Any = None) -> Any:
        """The stack; the argument, which Gym 0.26 has, has no effect."""
        return self._get_observation()

    def _get_observation(self) -> LazyFrames:
        return LazyFrames(self.frames, self.lz4_compress)


def _space_of(image: Any) -> Box:
    if np.issubdtype(image.dtype, np.integer):
        return Box(0, 255, image.shape, image.dtype)
    if np.issubdtype(image.dtype, np.floating):
        return Box(-np.inf, np.inf, image.shape, image.dtype)
    raise TypeError(f"images are arrays of integers or floats, got {image.dtype}")
