"""`FrameEpisode`: the episodes of a task on a core whose frames another program plays, one by one."""

from collections.abc import Callable, Generator
from contextlib import suppress
from typing import Any

import atari._emulator as _emulator
from atari.cores import ByteArray, Core
from atari.env.settings import episode_settings, make_episode
from atari.task import Task

ReadScreen = Callable[[Core], ByteArray]
"""Returns the palette indices of a core's present frame, (rows, 160) uint8, C-contiguous."""

Status = tuple[int, bool, bool, int]
"""Lives, whether the game is over, whether it is truncated, and the frame number."""


class FrameEpisode:
    """An `Episode` that yields the action of each frame, for programs that show every frame.

    `reset` and `step` are generators. They yield the ALE action number of a frame, and continue after the core has
    played it. They return the results of `Episode.reset` and `Episode.step`.

    `Episode` plays all frames of a step in one call. `FrameEpisode` therefore calls it several times for a step, and
    loads the state at the start of the step before each call: first over frames that are only assumed, for their
    actions, and last over all frames that the core has played, for the result.

    Args:
        task: the task; its limits and its reward have no effect, and NumPy draws its no-ops and frame skips.
        read_screen: returns the frame that the observation is made of.
    """

    core: Core
    """The core that is played. It is set before each `next` of a generator."""

    def __init__(self, task: Task, read_screen: ReadScreen) -> None:
        settings = episode_settings(
            task,
            acts_after_end=False,
            players=1,  # the policy is one of several players
            repeat_action_probability=0.0,  # the core repeats actions
            seeding=_emulator.Seeding.GYMNASIUM,
            life_loss_info=False,  # it ends no episode
            max_frames=None,  # the program that plays the frames ends the games
            max_episode_steps=None,
        )
        self._episode = make_episode(task.replace(reward=None), settings)
        self._read_screen = read_screen

    def reset(self, seed: list[int] | None, noops: int | None) -> Generator[int, None, Any]:
        """Begin an episode in the present state of the core. A new game begins without a reset of the core.

        Args:
            seed: nine words, see `Episode.reset`; None does not seed the generator.
            noops: the number of no-ops; None draws it.
        """
        return self._play(lambda core: self._episode.reset(core, lambda: core, seed=seed, noops=noops))

    def step(self, action: int) -> Generator[int, None, Any]:
        """Play an ALE action number for the frames of a step."""
        return self._play(lambda core: self._episode.step(core, action))

    def _play(self, call: Callable[["PlayedFrames"], Any]) -> Generator[int, None, Any]:
        before, frames = self._episode.save(), PlayedFrames(self.core, self._read_screen)
        while True:
            self._episode.load(before)
            frames.rewind()
            with suppress(Unplayed):
                result = call(frames)
            if not frames.ahead:
                return result
            for action in frames.ahead:
                yield action
                if not frames.add(self.core):
                    break


class Unplayed(Exception):
    """A step reads the screen or the RAM of an assumed frame."""


class PlayedFrames:
    """The core of a step that is called again: the frames that the real core has played, and then assumed frames.

    An assumed frame has the lives of the frame before it, and does not end the game. The actions inside a step depend
    on these alone, and a step stops where it reads the screen or the RAM of an assumed frame. So a step reads each
    frame for the first time while that frame is the present frame of the real core.
    """

    episode_frame_number = 0  # `Episode` only counts with it

    def __init__(self, core: Core, read_screen: ReadScreen) -> None:
        self._core, self._read_screen = core, read_screen
        self._played = [_status(core)]
        self._screens: dict[int, ByteArray] = {}
        self._rams: dict[int, ByteArray] = {}
        self.rewind()

    def rewind(self) -> None:
        """Go back to the start of the step."""
        self._at = 0
        self.lives, self.game_over, self.truncated, self.frame_number = self._played[0]
        self.ahead: list[int] = []
        """The actions of the assumed frames."""

    def add(self, core: Core) -> bool:
        """Add the present frame of the real core. Returns whether it is as assumed."""
        self._core = core
        self._played.append(_status(core))
        return self._played[-1][:3] == self._played[-2][:3]

    def act(self, action: int, strength: float) -> int:
        """Go to the next frame. Returns 0, as agents do not read rewards."""
        self._at += 1
        if self._at < len(self._played):
            self.lives, self.game_over, self.truncated, self.frame_number = self._played[self._at]
        else:
            self.frame_number += 1
            self.ahead.append(action)
        return 0

    def screen(self) -> ByteArray:
        """The screen of a played frame, see `ReadScreen`.

        Raises:
            Unplayed: the frame is an assumed one.
        """
        return self._read(self._screens, self._read_screen)

    def ram(self) -> ByteArray:
        """The RAM after a played frame.

        Raises:
            Unplayed: the frame is an assumed one.
        """
        return self._read(self._rams, lambda core: core.ram())

    def _read(self, kept: dict[int, ByteArray], read: ReadScreen) -> ByteArray:
        if self.ahead:
            raise Unplayed
        if self._at not in kept:
            kept[self._at] = read(self._core)
        return kept[self._at]


def _status(core: Core) -> Status:
    return core.lives, core.game_over, core.truncated, core.frame_number
