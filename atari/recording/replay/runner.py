"""`ReplayRunner`: feeds the events of a replay to a core."""

from collections import Counter
from collections.abc import Iterator, Sequence
from copy import copy
from typing import Any, NamedTuple

from atari.cores import snapshot
from atari.cores.writes import write_of
from atari.recording.replay import file_format
from atari.recording.replay.events import Event, Kind
from atari.recording.replay.recorded_core import own_writes

_COUNTERS = ("chunk", "frame", "episode", "score", "_saves", "_saved", "_uses", "_in_episode")
"""The attributes of a runner that a checkpoint keeps."""


class Call(NamedTuple):
    """One call of a core: an event, or one frame of an action, with its reward and whether it played a frame.

    With several players, `reward` is the `Scores` of the frame.
    """

    event: Event
    reward: Any = 0
    played: bool = False


class Checkpoint(NamedTuple):
    """The state of a runner between two chunks, from which it can resume."""

    chunk: int
    frame: int
    core: bytes
    writes: Sequence[Any]
    counters: dict[str, Any]


class ReplayRunner:
    """A core with the counters of a replay that is played on it, event by event.

    Args:
        core: a new core.
        content: the content of the file.
        uses: the number of times that the replay restores each snapshot taken during the recording.
    """

    _plays = Kind.ACT

    def __init__(self, core: Any, content: file_format.ReplayContent, uses: Counter[int]) -> None:
        self.core: Any = core
        self.chunk = 0
        """Chunks played so far."""
        self.frame = 0
        """Frames played so far."""
        self.episode = -1
        self.score: Any = file_format.no_score(self.core)
        self.episodes: list[dict[str, Any]] = []
        """The summaries of the episodes that have ended."""
        self._content = content
        self._uses = Counter(uses)
        self._saves: dict[int, tuple[bytes, int]] = {}
        self._saved = 0
        self._in_episode = False

    def run(self, event: Event) -> Iterator[Call]:
        """Return an iterator that makes the calls of an event, one at each `next`.

        Raises:
            ValueError: the event is not possible on this core.
        """
        if event.kind == self._plays:
            yield from self._act(event)
            return
        try:
            self._do(event.kind, *event.numbers)
        except (KeyError, IndexError, AttributeError, TypeError, ValueError, OverflowError, RuntimeError) as error:
            raise ValueError(
                f"the replay cannot continue after frame {self.frame} on core {self.core.name!r}, at "
                f"{event.kind.name} {event.numbers}: {error}"
            ) from error
        yield Call(event)

    def end_episode(self) -> None:
        """Append the current episode's summary, if an episode has begun."""
        if self._in_episode:
            self.episodes.append(file_format.episode_summary(self.core, self.score))
        self._in_episode = False

    def checkpoint(self) -> Checkpoint:
        """Return the current state; valid only between two chunks."""
        counters = {name: copy(getattr(self, name)) for name in _COUNTERS}
        return Checkpoint(self.chunk, self.frame, self.core.snapshot(), getattr(self.core, "writes", ()), counters)

    def resume(self, checkpoint: Checkpoint) -> None:
        """Continue from a checkpoint."""
        if checkpoint.writes:
            self.core.writes = checkpoint.writes
        self.core.restore(checkpoint.core)
        vars(self).update({name: copy(value) for name, value in checkpoint.counters.items()})

    def release(self) -> None:
        """End the writes of the replay."""
        for write in getattr(self.core, "writes", [])[own_writes(self.core) :]:
            if write is not None:
                self.core.remove_write(write)

    def _act(self, event: Event) -> Iterator[Call]:
        action, frames = event.numbers
        for left in range(frames - 1, -1, -1):
            before = self.core.frame_number
            reward = self._play_frame(event)
            played = self.core.frame_number != before
            if played:
                self.frame += 1
                self.score += reward
            yield Call(Event(event.kind, (action, 1), event.floats, event.ends_step and not left), reward, played)

    def _play_frame(self, event: Event) -> Any:
        return self.core.act(event.numbers[0], event.floats[0] if event.floats else 1.0)

    def _do(self, kind: Kind, first: int = 0, second: int = 0) -> None:
        core = self.core
        if kind == Kind.RESET:
            self.end_episode()
            core.reset()
            self._in_episode = True
            self.episode += 1
            self.score = file_format.no_score(self.core)
        elif kind == Kind.SEED:
            self.end_episode()  # the seed drops the episode
            core.seed(first)
        elif kind == Kind.POKE:
            core.set_ram(first, second)
        elif kind in (Kind.ADD_WRITE, Kind.REMOVE_WRITE):
            self._do_write(kind, first, bool(second))
        elif kind == Kind.SAVE:
            if self._uses[self._saved]:
                self._saves[self._saved] = core.snapshot(), self.score
            self._saved += 1
        elif kind == Kind.RESTORE:
            self._in_episode = True
            data, self.score = self._saves[first]
            core.restore(data)
            self._uses[first] -= 1
            if not self._uses[first]:
                del self._saves[first]
        elif kind == Kind.LOAD:
            self._in_episode = True
            core.restore(snapshot.with_options(self._content.snapshots[first], sound=core.sound))
            self.score = file_format.no_score(self.core)
        elif kind in (Kind.MODE, Kind.DIFFICULTY):
            choices = core.game.modes if kind == Kind.MODE else core.game.difficulties
            if first not in choices:
                raise ValueError(f"{core.game.id} has {kind.name.lower()} {', '.join(map(str, choices))}")
            (core.set_mode if kind == Kind.MODE else core.set_difficulty)(first)
        elif kind in (Kind.ACT, Kind.ACTIONS):
            raise ValueError("the action is for another number of players")

    def _do_write(self, kind: Kind, number: int, now: bool) -> None:
        core = self.core
        if not hasattr(core, "writes"):
            raise ValueError("this core cannot write RAM within a step; use core='native'")
        if kind == Kind.ADD_WRITE:
            core.add_write(write_of(core.game, self._content.writes[number]), now)
        elif (write := core.writes[number]) is not None:
            core.remove_write(write)
        else:
            raise ValueError(f"there is no write in slot {number}")
