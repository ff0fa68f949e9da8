"""`MemoryOptions`: the options of a `ReplayMemory`, checked. They decide its sizes, and a file begins with them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

import atari._emulator as _emulator
from atari.base import json_text
from atari.base.gymnasium_versions import AutoresetMode
from atari.base.gymnasium_versions import autoreset_mode as known_mode
from atari.base.validation import check_integer
from atari.task import Task
from atari.vector import AtariVectorEnv
from atari.vector.env import vector_of

Shape = tuple[int, ...]
_MODES = {AutoresetMode.NEXT_STEP: 0, AutoresetMode.SAME_STEP: 1, AutoresetMode.DISABLED: 2}
_PADDINGS = ("zero", "reset")
_MOST = 2**40
_MOST_FRAME = 2**26  # bytes


@dataclass(frozen=True)
class Part:
    """One array of an observation: the image, or the RAM.

    Attributes:
        name: the key in the dict of observations; "" if an observation is no dict.
        shape: of one frame as environments give it, such as (1, 84, 84).
        stack: the most frames in an observation.
    """

    name: str
    shape: Shape
    stack: int

    @property
    def frame(self) -> Shape:
        """The shape without a first axis of 1, which stands for the stack."""
        return self.shape[1:] if len(self.shape) >= 3 and self.shape[0] == 1 else self.shape

    @property
    def size(self) -> int:
        """Bytes of a frame."""
        return math.prod(self.shape)

    @property
    def pitch(self) -> int:
        """Bytes from a pixel to the pixel below it."""
        return math.prod(self.frame[1:]) if len(self.frame) >= 2 else self.size

    def stacked(self, stack: int) -> Shape:
        """The shape of an observation of `stack` frames, the oldest first."""
        return self.shape if stack == 1 else (stack, *self.frame)

    def shared(self, stack: int) -> Shape:
        """The shape of two observations of `stack` frames, one step apart, that share their frames."""
        return (2, *self.shape) if stack == 1 else (stack + 1, *self.frame)


@dataclass(frozen=True)
class MemoryOptions:
    """The checked options of `ReplayMemory`; only `priority_exponent` and `compressed_bytes` may be None."""

    capacity: int
    num_envs: int
    observation_shape: dict[str, list[int]]
    stack_num: dict[str, int]
    padding: str
    autoreset_mode: str
    action_shape: list[int]
    action_dtype: str
    priority_exponent: float | None
    final_frames: int
    compressed_bytes: int | None
    margin: int
    saved: bool

    @classmethod
    def check(
        cls,
        *,
        capacity: Any,
        num_envs: Any,
        observation_shape: Any,
        stack_num: Any,
        padding: Any,
        autoreset_mode: Any,
        action_shape: Any,
        action_dtype: Any,
        priority_exponent: Any,
        final_frames: Any,
        compressed_bytes: Any,
        margin: Any,
        saved: bool,
        compress: bool = False,
    ) -> "MemoryOptions":
        """Check options. Raises TypeError or ValueError if one is of the wrong kind or out of range."""
        lanes = check_integer("num_envs", num_envs, 1, 2**20)
        capacity = check_integer("capacity", capacity, 1, _MOST)
        shapes = _check_shapes(observation_shape)
        mode = known_mode(autoreset_mode)
        if padding not in _PADDINGS:
            raise ValueError(f"padding must be one of {', '.join(map(repr, _PADDINGS))}, got {padding!r}")
        dtype = np.dtype(action_dtype)
        if dtype.kind not in "iufb":
            raise TypeError(f"action_dtype must be of numbers or bools, got {dtype}")
        least_finals = 0 if mode == AutoresetMode.NEXT_STEP else 2 * lanes
        if final_frames is None:
            final_frames = max(least_finals, capacity // 50) if least_finals else 0
        if margin is None:
            margin = capacity // 64 if saved else 0
        raw = capacity * sum(math.prod(shape) for shape in shapes.values())
        exponent = None if priority_exponent is None else _check_exponent(priority_exponent)
        options = cls(
            capacity=capacity,
            num_envs=lanes,
            observation_shape={name: list(shape) for name, shape in shapes.items()},
            stack_num=check_stacks(stack_num, dict.fromkeys(shapes, 1024)),
            padding=padding,
            autoreset_mode=mode.value,
            action_shape=list(_check_shape("action_shape", action_shape, least=0)),
            action_dtype=dtype.str,
            priority_exponent=exponent,
            final_frames=check_integer("final_frames", final_frames, least_finals, _MOST),
            compressed_bytes=None,
            margin=check_integer("margin", margin, 0, _MOST),
            saved=saved,
        )
        if compress or compressed_bytes is not None:
            least = _emulator.ReplayGeometry.least_packed_bytes(options._geometry(packed_bytes=2**45))
            chosen = max(raw // 7, least) if compressed_bytes is None else compressed_bytes
            options = replace(options, compressed_bytes=check_integer("compressed_bytes", chosen, 1, 2**46))
        options.geometry()
        return options

    def stacks(self, stack_num: Any) -> dict[str, int]:
        """The number of frames in an observation, by part; None is the memory's own number."""
        return dict(self.stack_num) if stack_num is None else check_stacks(stack_num, self.stack_num)

    @property
    def parts(self) -> tuple[Part, ...]:
        """The arrays of an observation."""
        return tuple(Part(name, tuple(shape), self.stack_num[name]) for name, shape in self.observation_shape.items())

    def geometry(self) -> _emulator.ReplayGeometry:
        """The sizes for the extension module.

        Raises:
            ValueError: a size is out of range.
        """
        return self._geometry(self.compressed_bytes)

    def _geometry(self, packed_bytes: int | None) -> _emulator.ReplayGeometry:
        return _emulator.ReplayGeometry(
            lanes=self.num_envs,
            rows=-(-self.capacity // self.num_envs),
            margin=-(-self.margin // self.num_envs),
            finals=self.final_frames,
            parts=[(part.size, part.pitch, part.stack) for part in self.parts],
            action_bytes=math.prod(self.action_shape) * np.dtype(self.action_dtype).itemsize,
            autoreset=_MODES[AutoresetMode(self.autoreset_mode)],
            repeat_first=self.padding == "reset",
            exponent=self.priority_exponent,
            saved=self.saved,
            packed_bytes=packed_bytes,
        )


def options_for(envs: Any, num_envs: int | None = None) -> dict[str, Any]:
    """The options that a vector environment decides: number, shapes, autoreset mode; of `AtariVectorEnv` the padding.

    Raises:
        TypeError, ValueError: see `ReplayMemory.for_env`.
    """
    made = vector_of(envs, num_envs, {})
    stack_num, stacks_ram, padding = 4, False, {}
    if made is not envs:
        stack_num, stacks_ram = made.task.stack_num or 1, not made.task.kind.image
        padding = {"padding": made.task.padding}
        made = AtariVectorEnv(made.task.replace(stack_num=None if stacks_ram else 1), made.num_envs)
    envs = made
    observation, action = envs.single_observation_space, envs.single_action_space
    parts = observation.spaces if isinstance(observation, spaces.Dict) else {"": observation}
    for name, part in parts.items():
        if not isinstance(part, spaces.Box) or part.dtype != np.uint8:
            raise TypeError(f"a ReplayMemory stores observations of uint8, and these are {part} {name}".rstrip())
    if not isinstance(action, (spaces.Discrete, spaces.Box, spaces.MultiDiscrete, spaces.MultiBinary)):
        raise TypeError(f"a ReplayMemory stores actions that are arrays, and these are {action}")
    shapes = {name: tuple(part.shape or ()) for name, part in parts.items()}
    stacks = {name: stack_num if stacks_ram or len(shape) >= 2 else 1 for name, shape in shapes.items()}
    options = {
        "num_envs": envs.num_envs,
        "observation_shape": shapes if isinstance(observation, spaces.Dict) else shapes[""],
        "stack_num": stacks,
        "autoreset_mode": envs.metadata.get("autoreset_mode", AutoresetMode.NEXT_STEP),
        "action_shape": tuple(action.shape or ()),
        "action_dtype": action.dtype,
    }
    unwrapped = getattr(envs, "unwrapped", envs)
    return {**options, **_atari_options(unwrapped), **padding} if isinstance(unwrapped, AtariVectorEnv) else options


def _atari_options(envs: AtariVectorEnv) -> dict[str, Any]:
    task = envs.task
    single = 1 if task.kind.image else None
    if task.stack_num != single:
        raise ValueError(
            f"a ReplayMemory makes the stacks: make the environments with stack_num={single}, not {task.stack_num}"
        )
    if not envs.options.layout.is_engines:
        raise ValueError("a ReplayMemory stores what the engine writes: leave channels_last and dtype out")
    if envs.batch_size != envs.num_envs:
        raise ValueError("a ReplayMemory stores steps of all environments: leave batch_size out")
    check_lives(task)
    return {"padding": task.padding}


def check_lives(task: Task) -> None:
    """Refuse a task whose stacks go on after the end of an episode.

    Raises:
        ValueError: the task has `life_loss_info` or `seamless_lives`.
    """
    if task.life_loss_info or task.seamless_lives:
        raise ValueError(
            "a ReplayMemory begins a stack anew after each end: it does not serve life_loss_info, "
            "nor episodic_life of a preset whose stack goes on after a lost life"
        )


def _check_shape(name: str, shape: Any, least: int = 1) -> Shape:
    try:
        result = tuple(check_integer(name, size, 1, _MOST_FRAME) for size in shape)
    except TypeError as error:
        raise TypeError(f"{name} must be a tuple of integers, got {shape!r}") from error
    if not least <= len(result) <= 8:
        raise ValueError(f"{name} must have {least} to 8 axes, got {shape!r}")
    if math.prod(result) > _MOST_FRAME:
        raise ValueError(f"{name} must have at most 2**26 values, got {shape!r}")
    return result


def _check_shapes(shapes: Any) -> dict[str, Shape]:
    parts = dict(shapes) if isinstance(shapes, Mapping) else {"": shapes}
    if not 1 <= len(parts) <= 16 or not all(isinstance(name, str) for name in parts):
        raise ValueError(f"observation_shape must be a shape, or a dict of 1 to 16 shapes by name, got {shapes!r}")
    for name in parts:
        json_text.check_text(name, "the name of a part of observations")
    return {name: _check_shape("observation_shape", shape) for name, shape in parts.items()}


def check_stacks(stacks: Any, most: Mapping[str, int]) -> dict[str, int]:
    """The number of frames in an observation by part, from a number or a dict of numbers, at most `most`."""
    parts = dict(stacks) if isinstance(stacks, Mapping) else dict.fromkeys(most, stacks)
    if set(parts) != set(most):
        raise ValueError(f"stack_num must be a number, or a dict with the keys {', '.join(most)}, got {stacks!r}")
    return {name: check_integer("stack_num", parts[name], 1, most[name]) for name in most}


def _check_exponent(exponent: Any) -> float:
    if isinstance(exponent, bool) or not isinstance(exponent, (int, float, np.floating, np.integer)):
        raise TypeError(f"priority_exponent must be a number, or None for uniform sampling, got {exponent!r}")
    if not 0 <= exponent <= 100:
        raise ValueError(f"priority_exponent must be within 0..100, got {exponent!r}")
    return float(exponent)


def as_numpy(name: str, array: Any) -> npt.NDArray[Any]:
    """An array or CPU tensor as a NumPy array of the same memory.

    Raises:
        TypeError: `array` is neither.
    """
    if isinstance(array, np.ndarray):
        return array
    for convert in (lambda: array.numpy(), lambda: np.from_dlpack(array)):
        try:
            result = convert()
        except Exception:
            continue
        if isinstance(result, np.ndarray):
            return result
    raise TypeError(f"{name} must be a NumPy array or a tensor on the CPU, got {type(array).__name__}")
