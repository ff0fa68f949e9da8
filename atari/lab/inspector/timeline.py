"""`Timeline`: a game that is played frame by frame, and can return to each of its frames.

A snapshot is kept every `FRAMES_PER_SNAPSHOT` frames. The frames between are played again from their inputs, which
gives the same bytes.
"""

from collections.abc import Mapping
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from atari.cores import ByteArray, Core
from atari.lab.writes import Freeze

FRAMES_PER_SNAPSHOT = 30
_FRAMES_DROPPED = 20 * FRAMES_PER_SNAPSHOT
MOST_FRAMES = 108_000
"""Half an hour; older frames are dropped."""

NEW_GAME = -1
"""In place of an action: the core is reset."""


class FrameInput(NamedTuple):
    """The inputs of a frame: the action, bytes written before it, and frozen bytes, held before and after it.

    If `state` is not None, it is restored first. `slots` are the writes of the core; None stands for the writes of its
    interventions. The rules of the game see the held values of frozen bytes.
    """

    action: int
    before: tuple[tuple[int, int], ...] = ()
    held: tuple[tuple[int, int], ...] = ()
    strength: float = 1.0
    state: Any = None
    slots: tuple[Any, ...] | None = None


class Timeline:
    """A core, the inputs of all frames that were played on it, and the RAM after each.

    Frames are counted from the beginning of the inspection. `first` is the oldest frame that is kept, `at` the present
    one, `end` the newest: after going back, `at < end`, and `play_again` follows the recording.

    Args:
        core: the core that plays the frames.
        first: the number of its present frame.
        score: its score so far.
    """

    def __init__(self, core: Core, first: int = 0, score: int = 0) -> None:
        self.core = core
        self.first = self.at = first
        self.score = score
        self.pending: dict[int, int] = {}
        """Bytes that were written since the newest frame."""
        self.frozen: dict[int, int] = {}
        """Bytes that new frames hold."""
        self.added: dict[str, tuple[Any, ...]] = {}
        """The writes by name that new frames have beside the core's own writes."""
        self._holds: dict[tuple[int, int], Freeze] = {}
        self.own_slots = tuple(getattr(core, "writes", ()))
        """The writes of the core by slot, without the writes that hold frozen bytes; None where one has ended."""
        self._slots: tuple[Any, ...] | None = None
        self._new_slots: tuple[Any, ...] | None = None
        self._frames: list[FrameInput] = []
        self._states = [core.clone_state(include_rng=True)]
        self._ram: ByteArray = np.zeros((4096, 128), np.uint8)
        self._scores: npt.NDArray[np.int32] = np.zeros(4096, np.int32)
        self._keep()

    @property
    def end(self) -> int:
        """The newest frame."""
        return self.first + len(self._frames)

    @property
    def first_state(self) -> Any:
        """The state of the core at the frame `first`."""
        return self._states[0]

    def frames(self, start: int, stop: int) -> list[FrameInput]:
        """The inputs of the frames after `start`, up to `stop`."""
        return self._frames[start - self.first : stop - self.first]

    def play_new(self, action: int) -> None:
        """Play a frame with the frozen bytes and the interventions of this timeline."""
        self.play(FrameInput(action, held=tuple(self.frozen.items()), slots=self._new_slots))

    def play(self, frame: FrameInput) -> None:
        """Play a frame; the recorded frames after the present one are dropped."""
        self.cut()
        frame = frame._replace(before=(*self.pending.items(), *frame.before))
        if len(self._frames) >= MOST_FRAMES:
            count = _FRAMES_DROPPED
            del self._frames[:count], self._states[: count // FRAMES_PER_SNAPSHOT]
            self._ram[:-count] = self._ram[count:]
            self._scores[:-count] = self._scores[count:]
            self.first += count
        self._make(frame)
        self._frames.append(frame)
        self.pending = {}

    def append(self, frame: FrameInput, reward: int) -> bool:
        """Keep a frame that the core has played already; return whether there is room for it."""
        if len(self._frames) >= MOST_FRAMES:
            return False
        self._frames.append(frame)
        self.score = 0 if frame.action == NEW_GAME else self.score + reward
        self.at += 1
        self._keep()
        return True

    def play_again(self) -> None:
        """Play the next recorded frame, if there is one."""
        if self.at < self.end:
            self._make(self._frames[self.at - self.first])

    def seek(self, frame: int) -> None:
        """Return to a frame, or to the nearest one that is kept."""
        frame = min(max(frame, self.first), self.end)
        if not (self.at < frame <= self.at + FRAMES_PER_SNAPSHOT):
            number = (frame - self.first) // FRAMES_PER_SNAPSHOT
            self.core.restore_state(self._states[number])
            self.at = self.first + number * FRAMES_PER_SNAPSHOT
            self.score = int(self._scores[self.at - self.first])
        while self.at < frame:
            self.play_again()
        if self.at == self.end:
            self._write(self.pending)

    def cut(self) -> bool:
        """Drop the recorded frames after the present one; return whether there were any."""
        here = self.at - self.first
        if here == len(self._frames):
            return False
        del self._frames[here:], self._states[here // FRAMES_PER_SNAPSHOT + 1 :]
        self.pending = {}
        return True

    def write(self, index: int, value: int) -> None:
        """Write a byte of the present RAM; the recorded frames after the present one are dropped."""
        self.cut()
        self.core.set_ram(index, value)
        self.pending[index] = value

    def freeze(self, values: Mapping[int, int]) -> None:
        """Hold these bytes, and no others, in the frames that are played from here on.

        Raises:
            ValueError, RuntimeError: as `Freeze`; then nothing has changed.
        """
        self._hold(values)
        self.frozen = dict(values)

    def intervene(self, added: Mapping[str, tuple[Any, ...]]) -> None:
        """Play new frames with these interventions, and no others. Recorded frames after the present one are dropped.

        Raises:
            ValueError: the core has no room for their writes; then only these frames are dropped.
        """
        self.cut()
        before = self._slots
        slots = (*self.own_slots, *chain.from_iterable(added.values())) if added else None
        try:
            self._apply(slots)
            self._hold(self.frozen)
        except (RuntimeError, ValueError):
            self._apply(before)
            self._hold(self.frozen)
            raise
        self.added, self._new_slots = dict(added), slots

    def forget_write(self, index: int) -> None:
        """Undo the writes of a byte since the newest frame."""
        self.pending.pop(index, None)
        self.seek(self.at)

    def frames_of_game(self) -> int:
        """Frames since the game began, or since the oldest frame that is kept."""
        played = reversed(self._frames[: self.at - self.first])
        return next((count for count, frame in enumerate(played) if frame.action == NEW_GAME), self.at - self.first)

    def history(self, index: int, count: int) -> ByteArray:
        """The last values of a byte up to the present, (at most `count`,) uint8."""
        here = self.at - self.first
        return np.array(self._ram[max(0, here + 1 - count) : here + 1, index])

    def _make(self, frame: FrameInput) -> None:
        core: Any = self.core
        self._apply(frame.slots)
        if frame.state is not None:
            core.restore_state(frame.state)
        self._write(dict(frame.before))
        ram = core.ram() if frame.held else b""
        self._write({index: value for index, value in frame.held if ram[index] != value})
        self._hold(dict(frame.held))
        if frame.action == NEW_GAME:
            core.reset()
            self.score = 0
        else:
            self.score += core.act(frame.action, frame.strength)
        self.at += 1
        self._keep()

    def _apply(self, slots: tuple[Any, ...] | None) -> None:
        """Give the core these writes, see `FrameInput.slots`; if they are others, no byte is held after that."""
        if slots is not self._slots:
            self._hold({})
            core: Any = self.core
            core.writes = self.own_slots if slots is None else slots
            self._slots = slots

    def _hold(self, values: Mapping[int, int]) -> None:
        """Hold these bytes and no others. The others are released first, because a core has room for 64 writes."""
        wanted, before = set(values.items()), list(self._holds)
        for item in self._holds.keys() - wanted:
            self._holds.pop(item).release()
        try:
            for index, value in sorted(wanted - self._holds.keys()):
                self._holds[index, value] = Freeze(self.core, {index: value})
        except (RuntimeError, ValueError):
            for item in self._holds.keys() - before:
                self._holds.pop(item).release()
            for index, value in before:
                if (index, value) not in self._holds:
                    self._holds[index, value] = Freeze(self.core, {index: value})
            raise

    def _write(self, values: Mapping[int, int]) -> None:
        for index, value in values.items():
            self.core.set_ram(index, value)

    def _keep(self) -> None:
        here = self.at - self.first
        if here == len(self._ram):
            self._ram = np.concatenate([self._ram, np.zeros_like(self._ram)])
            self._scores = np.concatenate([self._scores, np.zeros_like(self._scores)])
        self._ram[here] = self.core.ram()
        self._scores[here] = np.clip(self.score, -(2**31), 2**31 - 1)
        if here == len(self._states) * FRAMES_PER_SNAPSHOT:
            self._states.append(self.core.clone_state(include_rng=True))
