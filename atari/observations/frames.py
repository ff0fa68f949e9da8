"""`FrameObservations`: the observations of a task, made from single frames, for programs that play frame by frame."""

from typing import Any

import numpy as np

from atari import _emulator
from atari.cores import ByteArray, Core
from atari.observations.layout import Layout
from atari.observations.settings import observation_settings
from atari.task import Task

Frame = Core | _emulator.Emulator | ByteArray
"""A core, whose present frame is read if needed, or palette indices, (rows, 160) uint8, C-contiguous.

For a task of RAM: a core, or the RAM, (128,) uint8.
"""


class FrameObservations:
    """The observations of a task, equal to those of `AtariVectorEnv`.

    `begin` gets the frame at the start of an episode, `frame_played` the frame after each frame of a step, and
    `skip_ended` makes the image of the step. After `begin` and `skip_ended`, `observation` is a policy's observation.

    Args:
        task: a task without sound.
        layout: the axes and the dtype of observations.

    Raises:
        ValueError: the task has sound, or an image size that a vector does not support.

    Example:
        >>> import atari
        >>> from atari.observations.frames import FrameObservations
        >>> core = atari.cores.NativeCore("pong", seed=0)
        >>> core.reset()
        >>> seen = FrameObservations(atari.Task.of("pong", preset="dqn2015"))
        >>> seen.begin(core)
        >>> seen.observation().shape
        (1, 4, 84, 84)
    """

    def __init__(self, task: Task, layout: Layout | None = None) -> None:
        if task.sound_obs:
            raise ValueError("observations are made from frames without sound; leave sound_obs=True out")
        self._layout = Layout.check(task, False, "uint8") if layout is None else layout
        self._dict = task.obs_type in ("dict", "rgb_dict")
        self._stack: _emulator.ObservationStack | None = None
        if task.obs_type != "ram" or task.stack_num is not None:
            screen = task.definition.screen
            self._stack = _emulator.ObservationStack(observation_settings(task), screen.shape[0], screen.format)
        self._ram: ByteArray = np.zeros(128, np.uint8)

    def see_ram(self, ram: ByteArray) -> None:
        """The RAM of the next observation, for tasks whose observations contain RAM without a stack."""
        self._ram = ram

    def begin(self, frame: Frame, fill: bool = True) -> None:
        """Begin an episode with the present frame; without `fill`, the images before it stay."""
        if self._stack is not None:
            self._stack.begin(frame, fill)

    def repeat(self, fill: bool = True) -> None:
        """Begin an episode with the last image again."""
        if self._stack is not None:
            self._stack.repeat(fill)

    def frame_played(self, frame: Frame, left: int, ended: bool) -> None:
        """A frame of a step was played, and `left` remain; `ended`: the episode has ended with it."""
        if self._stack is not None:
            self._stack.frame_played(frame, left, ended)

    def skip_ended(self, frame: Frame, left: int, ended: bool) -> None:
        """A step has ended, `left` frames early; `ended`: the episode has ended with it."""
        if self._stack is not None:
            self._stack.skip_ended(frame, left, ended)

    def save(self) -> bytes:
        """The images, as bytes."""
        return b"" if self._stack is None else self._stack.save()

    def load(self, state: bytes) -> None:
        """Continue from a result of `save`.

        Raises:
            ValueError: the bytes are no such result.
        """
        if self._stack is not None:
            self._stack.load(state)

    def observation(self) -> Any:
        """A batch of one observation; a new array."""
        ram = self._ram[None].copy()
        if self._stack is None:
            return self._layout.apply(ram)
        images = self._stack.observation()[None]
        return self._layout.apply({"image": images, "ram": ram} if self._dict else images)
