"""What a `Replay` has and returns: frames, episodes, and the result of a verification."""

from dataclasses import dataclass

from atari.cores import ByteArray


@dataclass(frozen=True)
class Frame:
    """One emulated frame of a replay.

    `index` counts from 0 over all episodes, `episode` from 0. `action` is ALE's number 0..17 and `strength` the
    paddle's; with sticky actions the core may have repeated the previous action. `ends_step` is True for the last
    frame of a step of the environment. `score` is that of the episode up to this frame. `ram` is (128,) and `screen`
    (height, 160, 3), uint8. `audio` is (512,) uint8 samples, all zero without sound=True. `actions`, `rewards` and
    `all_lives` have a number of each player; `action`, `reward`, `score` and `lives` are the first player's.

    Example:
        >>> import atari
        >>> from atari.recording import RecordReplay, Replay
        >>> with RecordReplay(atari.make("pong"), "game.a26") as env:
        ...     observation, info = env.reset(seed=0)
        ...     observation = env.step(2)[0]
        >>> frame = next(Replay.load("game.a26").frames())
        >>> frame.index, frame.action, frame.ram.shape, frame.screen.shape
        (0, 3, (128,), (210, 160, 3))
    """

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
    all_lives: tuple[int, ...]


@dataclass(frozen=True)
class Episode:
    """Frames and score of an episode, and how it ended: "game over", "truncated", or "open" if it did not.

    With several players, `scores` has the score of each, and `score` is the first one's.

    Example:
        >>> from atari.recording import Episode
        >>> Episode(frames=240, score=-1, end="open")
        Episode(frames=240, score=-1, end='open', scores=None)
    """

    frames: int
    score: int
    end: str
    scores: list[int] | None = None


@dataclass(frozen=True)
class Divergence:
    """The first difference between a replay and the recorded game.

    `frame` is the first frame whose hashes differ, counted from 0. The frames before `since` are equal. A difference in
    RAM changes the hash of its frame with a probability of 3/4; otherwise a later frame reports it.

    Example:
        >>> from atari.recording import Divergence
        >>> print(Divergence(frame=119, since=60, what="RAM"))
        frame 119 differs in RAM; it may have begun at frame 60
    """

    frame: int
    since: int
    what: str

    def __str__(self) -> str:
        first = f"; it may have begun at frame {self.since}" if self.since < self.frame else ""
        return f"frame {self.frame} differs in {self.what}{first}"


@dataclass(frozen=True)
class Verification:
    """The result of `Replay.verify`: the core, the number of compared frames, and the divergence, or None.

    Example:
        >>> from atari.recording import Verification
        >>> bool(Verification(core="native", frames=240, divergence=None))
        True
    """

    core: str
    frames: int
    divergence: Divergence | None

    def __bool__(self) -> bool:
        return self.divergence is None
