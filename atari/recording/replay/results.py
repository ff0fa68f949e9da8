"""The objects that a `Replay` returns: frames, episodes, and the result of a verification."""

from dataclasses import dataclass

from atari.cores import ByteArray


@dataclass(frozen=True)
class Frame:
    """One emulated frame of a replay; `Replay.frames` documents the fields."""

    index: int
    episode: int
    action: int
    strength: float
    ends_step: bool
    reward: int
    score: int
    lives: int
    terminated: bool
    truncated: bool
    ram: ByteArray
    screen: ByteArray
    audio: ByteArray
    actions: tuple[int, ...]
    rewards: tuple[int, ...]
    scores: tuple[int, ...]
    all_lives: tuple[int, ...]


@dataclass(frozen=True)
class Episode:
    """An episode of a replay; `Replay.episodes` documents the fields."""

    frames: int
    score: int
    end: str
    scores: list[int] | None = None


@dataclass(frozen=True)
class Divergence:
    """The first difference between a replay and the recorded game.

    A difference in RAM changes the hash of its frame with a probability of 3/4; otherwise a later frame reports it.
    """

    frame: int
    since: int
    what: str

    def __str__(self) -> str:
        first = f"; it may have begun at frame {self.since}" if self.since < self.frame else ""
        return f"frame {self.frame} differs in {self.what}{first}"


@dataclass(frozen=True)
class Verification:
    """The result of `Replay.verify`, which documents the fields. It is true if there is no divergence."""

    core: str
    frames: int
    divergence: Divergence | None

    def __bool__(self) -> bool:
        return self.divergence is None
