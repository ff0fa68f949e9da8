"""`FrameObservations`: the observations of a task, made from single frames, for programs that play frame by frame."""

from collections.abc import Callable
from typing import Any, Literal

import cv2
import numpy as np

from atari.cores import ByteArray, Core
from atari.task import Task
from atari.vector.layout import Layout

Read = Callable[[], ByteArray]
"""Returns the screen as `FrameObservations.kind` says, or the RAM."""


class FrameObservations:
    """The observations of a task, equal to those of `AtariVectorEnv`.

    `begin` gets the screen at the start of an episode, `frame_played` that after each frame of a step, and `skip_ended`
    makes the image of the step. Frames are read only where an image needs them. After `begin` and `skip_ended`,
    `observation` is what a policy sees.

    Args:
        task: without sound and indicator of the player.
        layout: the axes and the dtype of observations.

    Attributes:
        kind: what `read` returns: "rgb", "grayscale" or, for a task of RAM, "ram".

    Raises:
        ValueError: the task has sound, or an indicator of the player.
    """

    def __init__(self, task: Task, layout: Layout | None = None) -> None:
        if task.sound_obs or task.agent_indicator:
            field = "sound_obs" if task.sound_obs else "agent_indicator"
            raise ValueError(f"observations are made from frames alone, which do not have it; leave {field}=True out")
        self._task = task
        self._layout = Layout.check(task, False, "uint8") if layout is None else layout
        self._colours = task.obs_type in ("rgb", "rgb_dict")
        self.kind: Literal["rgb", "grayscale", "ram"] = "grayscale"
        if task.obs_type == "ram":
            self.kind = "ram"
        elif self._colours or task.pool_rgb:
            self.kind = "rgb"
        rows, columns = task.definition.screen.shape
        raw = (rows, columns, 3)[: 3 if self.kind == "rgb" else 2]
        self._frames_read = 2 if task.maxpool and task.frames[1] > 2 else 1
        self._early, self._late = np.zeros(raw, np.uint8), np.zeros(raw, np.uint8)
        size = (task.img_height or rows, task.img_width or columns, *raw[2:][: 1 if self._colours else 0])
        self._stack: ByteArray = np.zeros((task.stack_num or 1, *size), np.uint8)
        self._ram: ByteArray = np.zeros(128, np.uint8)

    def read(self, core: Core) -> ByteArray:
        """The present frame of a core, as `kind` says."""
        if self.kind == "ram":
            return core.ram()
        return core.screen_rgb() if self.kind == "rgb" else core.screen_grayscale()

    def see_ram(self, ram: ByteArray) -> None:
        """The RAM of the next observation, for tasks whose observations have it."""
        self._ram = ram

    def begin(self, read: Read, fill: bool = True) -> None:
        """Begin an episode with the present frame; without `fill`, the images before it stay."""
        if self.kind == "ram":
            return
        shown, other = (self._early, self._late)
        if self._task.end_frames == "gymnasium":
            shown, other = other, shown
        shown[...] = read()
        other.fill(0)
        self._push(shown, fill)

    def repeat(self, fill: bool = True) -> None:
        """Begin an episode with the last image again."""
        if self.kind != "ram":
            self._append(self._stack[-1].copy(), fill)

    def frame_played(self, left: int, ended: bool, read: Read) -> None:
        """A frame of a step was played, with `left` to come; `ended` is whether the episode has ended with it."""
        if self.kind == "ram" or left >= self._frames_read or (ended and self._task.end_frames == "gymnasium"):
            return
        (self._early if left else self._late)[...] = read()

    def skip_ended(self, left: int, read: Read) -> None:
        """A step has ended, `left` frames early."""
        if self.kind != "ram":
            self._push(self._image(left == 0, read))

    def observation(self) -> Any:
        """A batch of one observation; a new array."""
        if self.kind == "ram":
            return self._layout.apply(self._ram[None].copy())
        stack = self._stack[None].copy()
        dicts = self._task.obs_type in ("dict", "rgb_dict")
        return self._layout.apply({"image": stack, "ram": self._ram[None].copy()} if dicts else stack)

    def _image(self, whole: bool, read: Read) -> ByteArray:
        """The frame for the observation after a step; `whole` is whether it was played to its end."""
        early, late, ends = self._early, self._late, self._task.end_frames
        if ends == "last" and not whole:
            late[...] = read()
            return late
        if self._frames_read == 1:
            return late
        if ends == "gymnasium":
            return np.maximum(late, early, out=late)  # in place: a later stale frame is this maximum
        if ends == "envpool":
            return np.maximum(early, late, out=early) if whole else early
        return np.maximum(early, late)

    def _push(self, frame: ByteArray, fill: bool = False) -> None:
        """Make an image of a frame, and append it."""
        if self._task.pool_rgb:
            frame = np.asarray(cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY), np.uint8)
        rows, columns = self._stack.shape[1:3]
        image = np.asarray(cv2.resize(frame, (columns, rows), interpolation=cv2.INTER_AREA), np.uint8)
        self._append(image, fill)

    def _append(self, image: ByteArray, fill: bool) -> None:
        """Append an image to the stack, or, with `fill`, begin a stack with it."""
        if fill:
            self._stack[:-1] = 0 if self._task.padding == "zero" else image
        else:
            self._stack[:-1] = self._stack[1:]
        self._stack[-1] = image
