"""The objects that a `Replay` returns: frames, episodes, and the result of a verification; and how frames are made."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from atari.cores import ByteArray
from atari.recording.replay import file_format
from atari.recording.replay.events import Kind
from atari.recording.replay.file_format import FRAMES_PER_FULL_HASH
from atari.recording.replay.players import actions_of
from atari.recording.replay.runner import Call, ReplayRunner


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
class EpisodeSummary:
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


def frames_of(calls: Iterable[tuple[ReplayRunner, Call]]) -> Iterator[Frame]:
    """The frames of calls. Where a game ends within a step, a call that plays no frame ends the step."""
    held: Frame | None = None
    for runner, call in calls:
        if call.played:
            if held is not None:
                yield held
            held = _frame(runner, call)
        elif held is not None and (call.event.ends_step or call.event.kind == Kind.STEP):
            held = replace(held, ends_step=True)
    if held is not None:
        yield held


def _frame(runner: ReplayRunner, call: Call) -> Frame:
    core, (kind, numbers, floats, ends_step) = runner.core, call.event
    several = kind == Kind.ACTIONS
    actions = actions_of(numbers[0], core.players) if several else [numbers[0]]
    rewards = call.reward if several else [call.reward]
    lives = core.player_lives if several else [core.lives]
    return Frame(
        index=runner.frame - 1,
        episode=runner.episode,
        action=actions[0],
        strength=floats[0] if floats else 1.0,
        ends_step=ends_step,
        reward=rewards[0],
        score=runner.score[0] if several else runner.score,
        scores=tuple(runner.score) if several else (runner.score,),
        lives=lives[0],
        terminated=core.game_over,
        truncated=core.truncated,
        ram=core.ram(),
        screen=core.screen_rgb(),
        audio=core.audio(),
        actions=tuple(actions),
        rewards=tuple(rewards),
        all_lives=tuple(lives),
    )


def difference(runner: ReplayRunner, play: file_format.PlayChunk) -> str:
    """Return what differs between the last frame and the hashes in the file, or ""."""
    place = runner.frame - play.first - 1
    if place >= len(play.short_hashes):
        return "that the game goes on"
    if file_format.short_hash(runner.core) != play.short_hashes[place]:
        return "RAM"
    if runner.frame % FRAMES_PER_FULL_HASH == 0:
        number = runner.frame // FRAMES_PER_FULL_HASH - play.first // FRAMES_PER_FULL_HASH - 1
        if file_format.full_hash(runner.core, runner.score) != play.full_hashes[number]:
            return "RAM, screen, reward, lives or end"
    return ""
