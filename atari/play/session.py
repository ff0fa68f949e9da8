"""`Session`: a game played by hand, without its window: the replay, saved states, rewind points and videos."""

from collections import deque
from os import PathLike
from pathlib import Path
from typing import Any

from atari.actions import Action
from atari.cores import ByteArray, snapshot
from atari.env import AtariEnv
from atari.games.game import Game
from atari.recording import RecordReplay, VideoWriter, frame_rate
from atari.validation import check_file

FRAMES_PER_REWIND_POINT = 20
"""Frames from one rewind point to the next."""
_MAX_REWIND_POINTS = 1800  # ten minutes, nine megabytes


class Session:
    """A game played frame by frame, with all legal actions and without sticky actions.

    Args:
        game: see `AtariEnv`.
        replay: the replay file, with the suffix ".a26"; None writes no replay.
        state: the file of the saved state.
        videos: the folder of the videos.
        mode, difficulty: the game's mode and difficulty; None is the default.
        seed: the game's seed; None is a random one.
        scale: a pixel becomes `2 * scale` x `scale` pixels of a video.

    Raises:
        TypeError, ValueError, OSError: see `AtariEnv` and `RecordReplay`.
    """

    def __init__(
        self,
        game: str | PathLike[str] | Game,
        *,
        rom: Path | None = None,
        replay: Path | None = None,
        state: Path = Path("game.state"),
        videos: Path = Path("videos"),
        mode: int | None = None,
        difficulty: int | None = None,
        seed: int | None = None,
        scale: int = 2,
    ) -> None:
        self._atari = AtariEnv(
            game,
            rom=rom,
            frameskip=1,
            repeat_action_probability=0.0,
            full_action_space=True,
            mode=mode,
            difficulty=difficulty,
            sound_obs=True,
        )
        self.game = self._atari.game
        self._env: Any = self._atari if replay is None else RecordReplay(self._atari, replay)
        self._state, self._videos, self._scale = state, videos, scale
        self._rewind_points: deque[tuple[bytes, int]] = deque(maxlen=_MAX_REWIND_POINTS)
        self._video: VideoWriter | None = None
        self.frames = 0
        """Frames played, including rewound ones."""
        self.score = 0
        self.best = 0
        self.video_files: list[Path] = []
        """The videos that were begun."""
        self._env.reset(seed=seed)

    @property
    def legal_actions(self) -> tuple[Action, ...]:
        """The game's legal actions."""
        return self._atari.game.legal_actions

    @property
    def over(self) -> bool:
        """Whether the game has ended."""
        return self._atari.core.game_over or self._atari.core.truncated

    @property
    def recording(self) -> bool:
        """Whether a video is being written."""
        return self._video is not None

    @property
    def screen(self) -> ByteArray:
        """The current screen, (height, 160, 3) uint8."""
        return self._atari.core.screen_rgb()

    @property
    def samples(self) -> ByteArray:
        """The sound of the last frame, (512,) uint8 around 128."""
        return self._atari.core.audio()

    def play(self, action: Action) -> None:
        """Play a frame; after the end of the game, do nothing.

        Raises:
            OSError: the replay or the video cannot be written any more; play can continue without it.
        """
        if self.over:
            return
        if self.frames % FRAMES_PER_REWIND_POINT == 0:
            self._rewind_points.append((self._atari.snapshot(), self.score))
        _, reward, _, _, _ = self._env.step(self.legal_actions.index(action))
        self.frames += 1
        self.score += int(reward)
        self.best = max(self.best, self.score)
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
        data, self.score = self._rewind_points.pop()
        self._atari.restore(data)
        return True

    def new_game(self) -> None:
        """Reset the game."""
        self._env.reset()
        self.score = 0

    def save(self) -> Path:
        """Save the state to its file.

        Raises:
            OSError: the file cannot be written.
        """
        data = snapshot.pack({"of": "play", "score": self.score}, {"env": self._atari.snapshot()})
        self._state.parent.mkdir(parents=True, exist_ok=True)
        self._state.write_bytes(data)
        return self._state

    def load(self) -> None:
        """Continue from the saved state.

        Raises:
            FileNotFoundError: there is no saved state.
            ValueError: the file is damaged, or of another game, mode or difficulty.
        """
        facts, blobs = snapshot.unpack(check_file(self._state).read_bytes())
        snapshot.require(facts, {"of": "play"})
        snapshot.require_blobs(blobs, "env")
        score = facts.get("score")
        if type(score) is not int:
            raise ValueError(f"{self._state} is damaged: its score is no whole number")
        self._atari.restore(blobs["env"])
        self.score = score
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
        rate = frame_rate(self.game)
        self._video = VideoWriter(path, self.game.screen.shape, rate, scale=self._scale, sound=True)
        self.video_files.append(path)
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
            self._env.close()
