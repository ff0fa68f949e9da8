"""`Batch` of transitions and `Sequences` of steps, which a `ReplayMemory` samples. Their arrays can be used again."""

import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
import numpy.typing as npt

import atari._emulator as _emulator
from atari.base.extras import import_extra, pip_install
from atari.base.validation import check_integer
from atari.learning.memory.options import MemoryOptions, as_numpy
from atari.task.checks import check_bool

Array = Callable[[tuple[int, ...], Any], Any]


class _Rows:
    """The common part of batches of steps: the environments of the rows, and copies.

    A copy has no target of the extension module, which writes to the arrays of the original.
    """

    indices: Any
    num_envs: int

    @property
    def env_id(self) -> Any:
        """The environment of each row, (batch,) int64. With several games, `envs.games[i]` is its game."""
        return self.indices % self.num_envs

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_target": []}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Make shared frames shared again: copies of views are arrays of their own."""
        self.__dict__.update(state)
        frames, seen = state.get("frames"), state["observations"]
        if isinstance(frames, Mapping):
            pairs = {name: _views(part, seen[name].ndim < part.ndim) for name, part in frames.items()}
            first, second = ({name: pair[number] for name, pair in pairs.items()} for number in (0, 1))
            self.__dict__.update(observations=first, next_observations=second)
        elif frames is not None:
            first, second = _views(frames, seen.ndim < frames.ndim)
            self.__dict__.update(observations=first, next_observations=second)


def _views(frames: Any, single: bool) -> tuple[Any, Any]:
    """The observations and the next observations in shared frames; a `single` frame has no axis of a stack."""
    return (frames[:, 0], frames[:, 1]) if single else (frames[:, :-1], frames[:, 1:])


@dataclass(frozen=True, eq=False)
class Batch(_Rows):
    """Transitions, see `ReplayMemory.sample`: arrays of NumPy, or tensors of PyTorch on the CPU."""

    observations: Any
    actions: Any
    rewards: Any
    next_observations: Any
    discounts: Any
    terminations: Any
    truncations: Any
    indices: Any
    weights: Any
    frames: Any = None
    num_envs: int = 1
    _target: list[Any] = field(default_factory=list, repr=False)


@dataclass(frozen=True, eq=False)
class Sequences(_Rows):
    """Sequences of steps, see `ReplayMemory.sample_sequences`: arrays of NumPy, or tensors of PyTorch on the CPU."""

    observations: Any
    actions: Any
    rewards: Any
    terminations: Any
    truncations: Any
    mask: Any
    indices: Any
    num_envs: int = 1
    _target: list[Any] = field(default_factory=list, repr=False)


def make_batch(
    options: MemoryOptions,
    size: int,
    length: int,
    stacks: dict[str, int],
    array: Array = np.empty,
    share: bool = False,
) -> Batch | Sequences:
    """Arrays for `size` transitions, or for `size` sequences if `length` is not 0. `array` makes each array."""
    check_bool("share", share)
    steps = (size, length) if length else (size,)
    shown = (size, length + 1) if length else (size,)

    def unnamed(parts: dict[str, Any]) -> Any:
        return parts[""] if list(parts) == [""] else parts

    def observations() -> Any:
        return unnamed(
            {part.name: array((*shown, *part.stacked(stacks[part.name])), np.uint8) for part in options.parts}
        )

    both = {part.name: array((size, *part.shared(stacks[part.name])), np.uint8) for part in options.parts if share}
    views = {name: _views(frames, stacks[name] == 1) for name, frames in both.items()}
    common = {
        "observations": unnamed({name: one for name, (one, _) in views.items()}) if share else observations(),
        "actions": array((*steps, *options.action_shape), options.action_dtype),
        "rewards": array(steps, np.float32),
        "terminations": array(steps, np.bool_),
        "truncations": array(steps, np.bool_),
        "indices": array((size,), np.int64),
        "num_envs": options.num_envs,
    }
    if length:
        return Sequences(**common, mask=array(steps, np.bool_))
    floats = {name: array((size,), np.float32) for name in ("discounts", "weights")}
    if not share:
        return Batch(**common, next_observations=observations(), **floats)
    second = unnamed({name: other for name, (_, other) in views.items()})
    return Batch(**common, next_observations=second, frames=unnamed(both), **floats)


def array_maker(torch: bool, pin_memory: bool) -> Array:
    """A function that makes arrays, or tensors, of a shape and a dtype.

    Raises:
        TypeError, ValueError: an argument is no bool, or `pin_memory` is true without `torch`.
        gymnasium.error.DependencyNotInstalled: `torch` is true, and PyTorch is not installed.
    """
    if not check_bool("torch", torch):
        if check_bool("pin_memory", pin_memory):
            raise ValueError("pin_memory=True is for tensors; add torch=True")
        return np.empty
    check_bool("pin_memory", pin_memory)
    library = import_extra("torch", f"batches of tensors need PyTorch: {pip_install('torch')}")

    def array(shape: tuple[int, ...], dtype: Any) -> Any:
        kind = library.from_numpy(np.empty(0, dtype)).dtype
        return library.empty(shape, dtype=kind, pin_memory=pin_memory and library.cuda.is_available())

    return array


def target_of(
    batch: Batch | Sequences, core: _emulator.ReplayMemory, options: MemoryOptions, size: int, length: int
) -> _emulator.ReplayTarget:
    """The arrays of a batch for the extension module, which writes to them. The batch keeps the result.

    Raises:
        TypeError, ValueError: the batch is of another size or kind.
    """
    kind = Sequences if length else Batch
    if not isinstance(batch, kind):
        raise TypeError(f"out must be a {kind.__name__}, got {type(batch).__name__}")
    if batch._target and batch._target[0] == (id(core), size, length):
        return cast(_emulator.ReplayTarget, batch._target[1])
    steps = (size, length) if length else (size,)
    shown = (size, length + 1) if length else (size,)
    following: list[Any] = []
    if isinstance(batch, Batch) and batch.frames is not None:
        observations, stacks = _parts("frames", batch.frames, options, shown, shared=True)
    else:
        observations, stacks = _parts("observations", batch.observations, options, shown)
    if isinstance(batch, Batch) and batch.frames is None:
        following, next_stacks = _parts("next_observations", batch.next_observations, options, shown)
        if next_stacks != stacks:
            raise ValueError("observations and next_observations must have equally many frames")
    actions = _checked("actions", batch.actions, (*steps, *options.action_shape), options.action_dtype)
    target = _emulator.ReplayTarget(
        core,
        size,
        length,
        stacks,
        observations,
        following,
        actions.reshape(-1).view(np.uint8),
        _checked("rewards", batch.rewards, steps, np.float32),
        _checked("terminations", batch.terminations, steps, np.bool_),
        _checked("truncations", batch.truncations, steps, np.bool_),
        _checked("indices", batch.indices, (size,), np.int64),
        _checked("discounts", batch.discounts, (size,), np.float32) if isinstance(batch, Batch) else None,
        _checked("weights", batch.weights, (size,), np.float32) if isinstance(batch, Batch) else None,
        _checked("mask", batch.mask, steps, np.bool_) if isinstance(batch, Sequences) else None,
    )
    batch._target[:] = [(id(core), size, length), target]
    return target


def _parts(
    name: str, arrays: Any, options: MemoryOptions, shown: tuple[int, ...], shared: bool = False
) -> tuple[list[Any], list[int]]:
    named = list(options.observation_shape) != [""]
    parts = arrays if named else {"": arrays}
    if not isinstance(parts, Mapping) or set(parts) != set(options.observation_shape):
        raise TypeError(f"{name} must be a dict with the keys {', '.join(options.observation_shape)}")
    result, stacks = [], []
    for part in options.parts:
        array = as_numpy(name, parts[part.name])
        found = max(1, math.prod(array.shape[len(shown) :]) // part.size - shared)
        stack = check_integer("stack_num", found, 1, part.stack)
        shape = part.shared(stack) if shared else part.stacked(stack)
        result.append(_checked(name, array, (*shown, *shape), np.uint8))
        stacks.append(stack)
    return result, stacks


def _checked(name: str, array: Any, shape: tuple[int, ...], dtype: Any) -> Any:
    values = as_numpy(name, array)
    if values.shape != shape or values.dtype != np.dtype(dtype):
        raise ValueError(f"{name} of out must be {np.dtype(dtype)} {shape}, got {values.dtype} {values.shape}")
    if not (values.flags.c_contiguous and values.flags.writeable):
        raise ValueError(f"{name} of out must be writable and C-contiguous")
    return values


def check_size(batch_size: Any) -> int:
    """The number of transitions or sequences of a batch."""
    return check_integer("batch_size", batch_size, 1, 2**24)


_MOST_BYTES = 2**26  # larger batches are not kept
_ALIGNMENT = 64

_Key = tuple[int, int, tuple[int, ...]]  # size, length, stacks


class _Arena:
    """Makes arrays one after the other in a buffer; without one, it counts the bytes that they need."""

    def __init__(self, buffer: Any = None) -> None:
        self.buffer, self.end = buffer, 0

    def __call__(self, shape: tuple[int, ...], dtype: Any) -> npt.NDArray[Any]:
        start, kind = self.end, np.dtype(dtype)
        count = kind.itemsize
        for size in shape:
            count *= size
        self.end = start + -(-count // _ALIGNMENT) * _ALIGNMENT
        return np.empty(0, kind) if self.buffer is None else np.ndarray(shape, kind, self.buffer, start)


@dataclass(frozen=True, eq=False)
class _Kept:
    """The memory of a batch. It is free when the user holds no array in it any more."""

    key: _Key
    lender: _emulator.ArrayLender
    target: _emulator.ReplayTarget


class BatchPool:
    """The memory of the last two batches that were made. Threads may share it.

    The system clears new memory page by page when it is first written. For a batch of 32 that takes longer than
    sampling.
    """

    def __init__(self, options: MemoryOptions) -> None:
        self._options = options
        self._kept: deque[_Kept] = deque(maxlen=2)

    def take(
        self, core: _emulator.ReplayMemory, size: int, length: int, stacks: dict[str, int]
    ) -> tuple[Batch | Sequences, _emulator.ReplayTarget]:
        """A batch without other references, and the target through which the extension module writes it."""
        key = (size, length, tuple(stacks.values()))
        kept = self._unused(key)
        if kept is None:
            make_batch(self._options, size, length, stacks, arena := _Arena())
            if arena.end > _MOST_BYTES:
                batch = make_batch(self._options, size, length, stacks)
                return batch, target_of(batch, core, self._options, size, length)
            memory = np.empty(arena.end, np.uint8)
            whole = make_batch(self._options, size, length, stacks, _Arena(memory))
            kept = _Kept(key, _emulator.ArrayLender(memory), target_of(whole, core, self._options, size, length))
        batch = make_batch(self._options, size, length, stacks, _Arena(kept.lender.lend()))
        self._kept.append(kept)
        return batch, kept.target

    def _unused(self, key: _Key) -> _Kept | None:
        """Take free memory out of the pool, so that no other thread can take it."""
        for _ in range(len(self._kept)):
            try:
                kept = self._kept.popleft()
            except IndexError:  # another thread has it
                return None
            if kept.key == key and not kept.lender.lent:
                return kept
            self._kept.append(kept)
        return None
