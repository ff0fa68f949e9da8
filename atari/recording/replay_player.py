"""`Player`: does to a core what was done to the recorded one."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from atari import snapshot
from atari.cores import Core
from atari.recording import replay_file
from atari.recording.replay_events import Event, Kind


class Call(NamedTuple):
    """What was done: an event, or one frame of it, with its reward and whether it has played a frame."""

    event: Event
    reward: int = 0
    played: bool = False


@dataclass(frozen=True)
class Position:
    """A place between two chunks, to go on from."""

    chunk: int
    saved: int
    frame: int
    episode: int
    score: int
    in_episode: bool
    core: bytes
    saves: Mapping[int, tuple[bytes, int]]
    uses: Counter[int]


class Player:
    """Plays the events of a replay one after another.

    Args:
        core: the core, as it was made.
        snapshots: those of the file.
        uses: how often the replay goes back to each snapshot that was taken while it was recorded.
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
        """What is noted of those that another one has followed."""
        self._snapshots = snapshots
        self._uses = Counter(uses)
        self._saves: dict[int, tuple[bytes, int]] = {}
        self._saved = 0
        self._in_episode = False

    def play(self, event: Event) -> Iterator[Call]:
        """Do the calls of an event, one each time the iterator is asked.

        Raises:
            ValueError: the event is not possible on this core.
        """
        if event.kind == Kind.ACT:
            yield from self._act(event)
            return
        try:
            self._do(event.kind, *event.numbers)
        except (KeyError, IndexError, AttributeError, TypeError, ValueError) as error:
            raise ValueError(
                f"the replay cannot go on behind frame {self.frame} on core {self.core.name!r}, at "
                f"{event.kind.name} {event.numbers}: {error}"
            ) from error
        yield Call(event)

    def end_episode(self) -> None:
        """Take note of the episode, if there is one."""
        if self._in_episode:
            self.episodes.append(replay_file.episode(self.core, self.score))
        self._in_episode = False

    def position(self) -> Position:
        """Where it is, between two chunks."""
        saves, uses = dict(self._saves), Counter(self._uses)
        core = self.core.snapshot()
        numbers = self.chunk, self._saved, self.frame, self.episode, self.score
        return Position(*numbers, self._in_episode, core, saves, uses)

    def go_to(self, position: Position) -> None:
        """Go on from there."""
        self.core.restore(position.core)
        self.chunk, self._saved, self.frame = position.chunk, position.saved, position.frame
        self.episode, self.score, self._in_episode = position.episode, position.score, position.in_episode
        self._saves, self._uses = dict(position.saves), Counter(position.uses)

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
            core.seed(first)
        elif kind == Kind.POKE:
            core.set_ram(first, second)
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
            core.restore(_with_sound_of(core, self._snapshots[first]))
            self.score = 0
        elif kind in (Kind.MODE, Kind.DIFFICULTY):
            choices = core.game.modes if kind == Kind.MODE else core.game.difficulties
            if first not in choices:
                raise ValueError(f"{core.game.id} has {kind.name.lower()} {', '.join(map(str, choices))}")
            (core.set_mode if kind == Kind.MODE else core.set_difficulty)(first)


def _with_sound_of(core: Core, data: bytes) -> bytes:
    """A snapshot as this core takes it, which may make sound where the recorded one did not, or the other way round.

    The state of the native core has room for sound in any case. ale-py's snapshots have not, and are left as they are.
    """
    facts, blobs = snapshot.unpack(data)
    return data if facts.get("core") == "ale" else snapshot.pack({**facts, "sound": core.sound}, blobs)
