"""`BaseSession`: the saved states, rewind points and videos of sessions for one and for several players."""

import json
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

from atari.base import durable
from atari.base.validation import check_file, check_name
from atari.cores import ByteArray, snapshot
from atari.games.actions import Action
from atari.games.game import Game
from atari.recording import VideoWriter
from atari.recording.video.facts import PACKAGE

FRAMES_PER_REWIND_POINT = 20
"""Frames from one rewind point to the next."""
_MAX_REWIND_POINTS = 1800  # ten minutes, nine megabytes


class BaseSession(ABC):
    """A game played frame by frame, without its window. Subclasses own the emulator.

    Args:
        game: the game.
        played: the environment or the core, or its recorder.
        legal_actions, minimal_actions: the actions of a player, and those that have an effect in the game.
        players: the number of players, each with a score.
        state: the file of the saved state.
        videos: the folder of the videos.
        scale: a pixel becomes `2 * scale` x `scale` pixels of a video.
    """

    humans: tuple[int, ...] = (0,)
    """The human players; 0 is the first."""
    _saved_as: ClassVar[str]
    _blob: ClassVar[str]

    def __init__(
        self,
        game: Game,
        played: Any,
        legal_actions: tuple[Action, ...],
        minimal_actions: tuple[Action, ...],
        *,
        players: int,
        state: Path,
        videos: Path,
        scale: int,
    ) -> None:
        self.game, self._played = game, played
        self.legal_actions, self.minimal_actions = legal_actions, minimal_actions
        self._state, self._videos, self._scale = state, videos, scale
        self._rewind_points: deque[tuple[bytes, list[int]]] = deque(maxlen=_MAX_REWIND_POINTS)
        self._video: VideoWriter | None = None
        self._next_point = 0  # in frames
        self.frames = 0
        """Frames played, including rewound ones."""
        self.scores = [0] * players
        """The score of each player."""
        self.files: list[Path] = []
        """The videos that were begun, and the state that was saved."""

    @property
    @abstractmethod
    def over(self) -> bool:
        """Whether the game has ended."""

    @property
    @abstractmethod
    def screen(self) -> ByteArray:
        """The current screen, (height, 160, 3) uint8."""

    @property
    @abstractmethod
    def samples(self) -> ByteArray:
        """The sound of the last frame, (512,) uint8 around 128."""

    @property
    def title(self) -> str:
        """The game and the score, or the score of each player, for the window's title."""
        if len(self.scores) == 1:
            return f"{self.game.title}   {self.scores[0]:,}"
        return "   ".join([self.game.title, *(f"player {i}: {score:,}" for i, score in enumerate(self.scores, 1))])

    @property
    def interventions(self) -> Mapping[str, bool]:
        """The interventions that a key switches, by name, and whether each is on; none for several players."""
        return {}

    def toggle_intervention(self, name: str) -> None:
        """Switch one of `interventions` on or off.

        Raises:
            ValueError: there is no such intervention, or the core has no room for its writes.
        """
        check_name("intervention", name, self.interventions)

    @property
    def _facts(self) -> dict[str, Any]:
        """The facts in the metadata of a video of the session, see `video_facts`."""
        return {"game": self.game.id, "players": len(self.scores), "package": PACKAGE}

    @abstractmethod
    def _step(self, actions: tuple[Action, ...]) -> list[int]:
        """Play a frame with an action of each human player, and return the reward of each player."""

    @abstractmethod
    def _snapshot(self) -> bytes: ...

    @abstractmethod
    def _restore(self, data: bytes) -> None:
        """Continue from a snapshot; raise ValueError, before anything changes, if it is from another game."""

    @abstractmethod
    def _reset(self) -> None: ...

    @property
    def _between_steps(self) -> bool:
        return True

    @property
    def recording(self) -> bool:
        """Whether a video is being written."""
        return self._video is not None

    def play(self, *actions: Action) -> None:
        """Play a frame with an action of each human player; after the end of the game, do nothing.

        Raises:
            TypeError, ValueError: there is not an action for each human player, or one is not legal; nothing is played.
            OSError: the replay or the video can no longer be written; play can continue without it.
        """
        if len(actions) != len(self.humans):
            raise TypeError(f"play takes an action of each of {len(self.humans)} human players, got {len(actions)}")
        for action in actions:
            if action not in self.legal_actions:
                names = ", ".join(f"Action.{legal.name}" for legal in self.legal_actions)
                raise ValueError(f"an action is one of {names}, got {action!r}")
        if self.over:
            return
        if self.frames >= self._next_point and self._between_steps:
            self._next_point = self.frames + FRAMES_PER_REWIND_POINT
            self._rewind_points.append((self._snapshot(), self.scores))
        rewards = self._step(actions)
        self.frames += 1
        self.scores = [score + reward for score, reward in zip(self.scores, rewards, strict=True)]
        if self._video is not None:
            try:
                self._video.write(self.screen, self.samples)
            except OSError:
                self._video = None
                raise

    def rewind(self) -> bool:
        """Restore the last rewind point and drop it; return False if there is none."""
        if not self._rewind_points:
            return False
        data, self.scores = self._rewind_points.pop()
        self._restore(data)
        return True

    def new_game(self) -> None:
        """Reset the game."""
        self._reset()
        self.scores = [0] * len(self.scores)

    def save(self) -> Path:
        """Save the state to its file.

        Raises:
            OSError: the file cannot be written.
        """
        score = self.scores if len(self.scores) > 1 else self.scores[0]
        data = snapshot.pack({"of": self._saved_as, "score": score}, {self._blob: self._snapshot()})
        self._state.parent.mkdir(parents=True, exist_ok=True)
        durable.write_file(self._state, data)
        if self._state not in self.files:
            self.files.append(self._state)
        return self._state

    def load(self) -> None:
        """Continue from the saved state.

        Raises:
            FileNotFoundError: there is no saved state.
            ValueError: the file is damaged, or from another game, mode or difficulty.
        """
        facts, blobs = snapshot.unpack(check_file(self._state).read_bytes())
        snapshot.require(facts, {"of": self._saved_as})
        snapshot.require_blobs(blobs, self._blob)
        score = facts.get("score")
        scores: list[Any] = score if isinstance(score, list) else [score]
        if not all(type(one) is int for one in scores):
            raise ValueError(f"{self._state} is damaged: its score is no whole number")
        if len(scores) != len(self.scores):
            raise ValueError(f"{self._state} is from a game of {len(scores)} players, not of {len(self.scores)}")
        self._restore(blobs[self._blob])
        self.scores = scores
        self._rewind_points.clear()

    def toggle_video(self) -> Path | None:
        """Begin a video and return its path; or complete the current one and return None.

        Raises:
            OSError: the file cannot be written.
            gymnasium.error.DependencyNotInstalled: PyAV is not installed.
        """
        if self._video is not None:
            video, self._video = self._video, None
            video.close()
            return None
        number = 1
        while (path := self._videos / f"{self.game.id}-{number}.mp4").exists():
            number += 1
        comment = json.dumps(self._facts)
        self._video = VideoWriter(path, self.game, scale=self._scale, sound=True, comment=comment)
        self.files.append(path)
        return path

    def close(self) -> None:
        """Complete the replay and the video.

        Raises:
            OSError: a file cannot be written.
        """
        try:
            if self._video is not None:
                self.toggle_video()
        finally:
            self._played.close()
