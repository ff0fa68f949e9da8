"""`FrameStack`: stack the last few observations, so that one observation contains motion.

Successive stacks of four share three frames. A replay memory that stores stacks as arrays has each frame four times,
eight times with the next observations; `lazy` stacks have it once.
"""

from collections import deque
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from atari.base.validation import check_integer, check_name
from atari.env.restorable import RestorableWrapper, State
from atari.wrappers._checks import Environment

Padding = Literal["reset", "zero"]
Array = npt.NDArray[Any]


class FrameStack(RestorableWrapper):
    """Observations become (stack_size, *shape), the oldest frame first.

    Each is a new array with copies of the frames, as Gymnasium requires. With `lazy` no frame is
    ever copied: an observation is a `LazyStack`, which refers to frames and becomes an array when NumPy converts it.
    (Gymnasium's `FrameStackObservation` copies each frame twice and has no lazy stacks.)

    Args:
        env: an environment with Box observations.
        stack_size: the number of observations, 1 or more.
        padding_type: the frames before the first observation of an episode: "reset" repeats it, "zero" is black.
        lazy: observations are `LazyStack`s.

    Raises:
        TypeError: the observations are not a Box, or `stack_size` is not an integer.
        ValueError: `stack_size` is less than 1, or `padding_type` unknown.

    Example:
        >>> import atari
        >>> from atari.wrappers import FrameStack
        >>> env = FrameStack(atari.make("pong", obs_type="ram"), 4)
        >>> env.reset(seed=0)[0].shape
        (4, 128)
    """

    def __init__(
        self, env: Environment, stack_size: int = 4, padding_type: Padding = "reset", *, lazy: bool = False
    ) -> None:
        space = env.observation_space
        if not isinstance(space, spaces.Box):
            raise TypeError(f"FrameStack stacks the arrays of a Box space, got {space}; put it inside other wrappers")
        stack_size = check_integer("stack_size", stack_size, 1, 10_000)
        check_name("padding_type", padding_type, get_args(Padding))
        super().__init__(env, stack_size=stack_size, padding_type=padding_type, lazy=lazy)
        low, high = (np.repeat(bound[None], stack_size, axis=0) for bound in (space.low, space.high))
        self.observation_space = spaces.Box(low, high, dtype=space.dtype)
        self._padding = None if padding_type == "reset" else np.zeros(space.shape, space.dtype)
        self.stack_size = stack_size
        self._lazy = lazy
        self._frames: deque[Array] = deque(maxlen=stack_size)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset and begin a new stack."""
        observation, info = self.env.reset(seed=seed, options=options)
        padding = observation if self._padding is None else self._padding
        self._frames.extend([padding] * self.stack_size)
        return self._push(observation), info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Step and stack the observation."""
        self._warn_if_restored()
        observation, reward, terminated, truncated, info = self.env.step(action)
        return self._push(observation), reward, terminated, truncated, info

    def _save_state(self) -> State:
        space = self.observation_space
        frames = np.array(self._frames) if self._frames else np.zeros(space.shape or (), space.dtype)
        return {"frames": frames, "begun": bool(self._frames)}

    def _load_state(self, state: State) -> dict[str, Any]:
        return {"_frames": deque(state["frames"] if state["begun"] else (), maxlen=self.stack_size)}

    def _push(self, frame: Array) -> "Array | LazyStack":
        self._frames.append(frame)
        return LazyStack(tuple(self._frames)) if self._lazy else np.array(self._frames)


class LazyStack:
    """A stack of frames that becomes an array when NumPy converts it.

    `np.asarray(stack)`, `stack[-1]`, `len(stack)` and `==` have the results of the array (stack_size, *shape). Stacks
    share their common frames, also when they are pickled together; frames are read-only.

    Example:
        >>> import atari, numpy
        >>> from atari.wrappers import FrameStack
        >>> observation, _ = FrameStack(atari.make("pong", obs_type="ram"), 4, lazy=True).reset(seed=0)
        >>> type(observation).__name__, numpy.asarray(observation).shape
        ('LazyStack', (4, 128))
    """

    __slots__ = ("frames",)

    def __init__(self, frames: tuple[Array, ...]) -> None:
        for frame in frames:
            frame.flags.writeable = False  # other stacks share the frame
        self.frames = frames

    @property
    def shape(self) -> tuple[int, ...]:
        """(stack_size, *shape of a frame)."""
        return (len(self.frames), *self.frames[0].shape)

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return 1 + self.frames[0].ndim

    @property
    def dtype(self) -> np.dtype[Any]:
        """The dtype of the frames."""
        return self.frames[0].dtype

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> Array:
        if copy is False:
            raise ValueError("a LazyStack has no array yet; np.asarray(stack) makes one, copy=False cannot")
        return np.stack(self.frames).astype(dtype or self.dtype, copy=False)

    def __len__(self) -> int:
        return len(self.frames)

    def __getitem__(self, index: Any) -> Array:
        if isinstance(index, int):
            return self.frames[index]
        return np.asarray(self)[index]

    def __eq__(self, other: object) -> Any:
        return np.asarray(self) == np.asarray(other)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"LazyStack(shape={self.shape}, dtype={self.dtype})"
