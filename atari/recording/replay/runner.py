"""`ReplayRunner`: feeds the events of a replay to a core."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from atari.cores import Core, snapshot
from atari.cores.writes import make_write
from atari.games.interventions import WriteRule
from atari.recording.replay import file_format
from atari.recording.replay.events import NO_VALUE, Event, Kind


class Call(NamedTuple):
    """One call of a core: an event, or one frame of an action, with its reward and whether it played a frame."""

    event: Event
    reward: int = 0
    played: bool = False


@dataclass(frozen=True)
class Checkpoint:
    """The state of a runner between two chunks, from which it can resume."""

    chunk: int
    saved: int
    frame: int
    episode: int
    score: int
    in_episode: bool
    core: bytes
    saves: Mapping[int, tuple[bytes, int]]
    uses: Counter[int]
    held: Mapping[int, int]


class ReplayRunner:
    """A core with the counters of a replay that is played on it, event by event.

    Args:
        core: a new core.
        snapshots: the snapshots stored in the file.
        uses: the number of times that the replay restores each snapshot taken during the recording.
    """

    def __init__(self, core: Core, snapshots: tuple[bytes, ...], uses: Counter[int]) -> None:
        self.core: Any = core
        self.chunk = 0
        """Chunks played so far."""
        self.frame = 0
        """Frames played so far."""
        self.episode = -1
        self.score = 0
        self.episodes: list[dict[str, Any]] = []
        """The summaries of the episodes that have ended."""
        self._snapshots = snapshots
        self._uses = Counter(uses)
        self._saves: dict[int, tuple[bytes, int]] = {}
        self._saved = 0
        self._in_episode = False
        self._held: dict[int, tuple[int, Any]] = {}  # by byte: the value, and the write

    def run(self, event: Event) -> Iterator[Call]:
        """Return an iterator that makes the calls of an event, one at each `next`.

        Raises:
            ValueError: the event is not possible on this core.
        """
        if event.kind == Kind.ACT:
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
        saves, uses = dict(self._saves), Counter(self._uses)
        core = self.core.snapshot()
        numbers = self.chunk, self._saved, self.frame, self.episode, self.score
        held = {index: value for index, (value, _) in self._held.items()}
        return Checkpoint(*numbers, self._in_episode, core, saves, uses, held)

    def resume(self, checkpoint: Checkpoint) -> None:
        """Continue from a checkpoint."""
        self.core.restore(checkpoint.core)
        self.chunk, self._saved, self.frame = checkpoint.chunk, checkpoint.saved, checkpoint.frame
        self.episode, self.score, self._in_episode = checkpoint.episode, checkpoint.score, checkpoint.in_episode
        self._saves, self._uses = dict(checkpoint.saves), Counter(checkpoint.uses)
        self.release()
        for index, value in checkpoint.held.items():
            self._hold(index, value)

    def release(self) -> None:
        """Hold no byte any longer."""
        for index in list(self._held):
            self._hold(index, NO_VALUE)

    def _hold(self, index: int, value: int) -> None:
        if index in self._held:
            self.core.remove_write(self._held.pop(index)[1])
        if value != NO_VALUE:
            write = make_write(self.core.game, WriteRule(index, value, when="held"), "HOLD")
            self.core.add_write(write)
            self._held[index] = value, write

    def _act(self, event: Event) -> Iterator[Call]:
        core = self.core
        action, frames = event.numbers
        strength = event.floats[0] if event.floats else 1.0
        for left in range(frames - 1, -1, -1):
            before = core.frame_number
            reward = core.act(action, strength)
            played = core.frame_number != before
            if played:
                self.frame += 1
                self.score += reward
            yield Call(Event(Kind.ACT, (action, 1), event.floats, event.ends_step and not left), reward, played)

    def _do(self, kind: Kind, first: int = 0, second: int = 0) -> None:
        core = self.core
        if kind == Kind.RESET:
            self.end_episode()
            core.reset()
            self._in_episode = True
            self.episode += 1
            self.score = 0
        elif kind == Kind.SEED:
            self.end_episode()  # the core forgets the episode
            core.seed(first)
        elif kind == Kind.POKE:
            core.set_ram(first, second)
        elif kind == Kind.HOLD:
            self._hold(first, second)
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
            core.restore(snapshot.with_options(self._snapshots[first], sound=core.sound))
            self.score = 0
        elif kind in (Kind.MODE, Kind.DIFFICULTY):
            choices = core.game.modes if kind == Kind.MODE else core.game.difficulties
            if first not in choices:
                raise ValueError(f"{core.game.id} has {kind.name.lower()} {', '.join(map(str, choices))}")
            (core.set_mode if kind == Kind.MODE else core.set_difficulty)(first)
