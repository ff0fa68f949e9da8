"""`Session`: a game played by hand, without a window: its replay, its saved states, its way back, its videos."""

from collections import deque
from os import PathLike
from pathlib import Path
from typing import Any

from atari import snapshot
from atari.actions import Action
from atari.cores import ByteArray
from atari.env import AtariEnv
from atari.game import Game
from atari.recording import RecordReplay, VideoWriter, frame_rate

FRAMES_PER_MOMENT = 20
"""As often, a moment is kept to go back to."""
_MOMENTS = 1800  # ten minutes, nine megabytes


class Session:
    """A game frame by frame, with all legal actions and none that stick.

    Args:
        game: as of `AtariEnv`.
        replay: file of the replay, ending in ".a26"; None writes none.
        state: file of the saved state.
        videos: folder for videos.
        mode, difficulty: of the game.
        seed: of the game.
        scale: of the videos' pixels.

    Raises:
        TypeError, ValueError, OSError: as of `AtariEnv` and `RecordReplay`.
    """

    def __init__(
        self,
        game: str | PathLike[str] | Game,
        *,
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
        self._moments: deque[tuple[bytes, int]] = deque(maxlen=_MOMENTS)
        self._video: VideoWriter | None = None
        self.frames = 0
        """Frames played, those taken back too."""
        self.score = 0
        self.best = 0
        self.written: list[Path] = []
        """The videos."""
        self._env.reset(seed=seed)

    @property
    def legal_actions(self) -> tuple[Action, ...]:
        """The actions there are."""
        return self._atari.game.legal_actions

    @property
    def over(self) -> bool:
        """Whether the game has ended."""
        return self._atari.core.game_over or self._atari.core.truncated

    @property
    def filming(self) -> bool:
        """Whether a video is being written."""
        return self._video is not None

    @property
    def screen(self) -> ByteArray:
        """What is seen, (height, 160, 3) uint8."""
        return self._atari.core.screen_rgb()

    @property
    def samples(self) -> ByteArray:
        """What was heard during the last frame, (512,) uint8 around 128."""
        return self._atari.core.audio()

    def play(self, action: Action) -> None:
        """Play a frame; when the game has ended, nothing happens.

        Raises:
            OSError: the replay or the video cannot be written any more; the game can go on without it.
        """
        if self.over:
            return
        if self.frames % FRAMES_PER_MOMENT == 0:
            self._moments.append((self._atari.snapshot(), self.score))
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

    def go_back(self) -> bool:
        """Return to the last moment kept, which then is forgotten; False if there is none."""
        if not self._moments:
            return False
        data, self.score = self._moments.pop()
        self._atari.restore(data)
        return True

    def new_game(self) -> None:
        """Begin again."""
        self._env.reset()
        self.score = 0

    def save(self) -> Path:
        """Save the state to its file.

        Raises:
            OSError: it cannot be written.
        """
        data = snapshot.pack({"of": "play", "score": self.score}, {"env": self._atari.snapshot()})
        self._state.parent.mkdir(parents=True, exist_ok=True)
        self._state.write_bytes(data)
        return self._state

    def load(self) -> None:
        """Continue from the saved state.

        Raises:
            FileNotFoundError: none was saved.
            ValueError: it is damaged, or of another game, mode or difficulty.
        """
        facts, blobs = snapshot.unpack(self._state.read_bytes())
        snapshot.require(facts, {"of": "play"})
        self._atari.restore(blobs["env"])
        self.score = int(facts["score"])
        self._moments.clear()

    def film(self) -> Path | None:
        """Begin a video, or end the one that is being written; the file that was begun.

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
        self.written.append(path)
        return path

    def close(self) -> None:
        """Complete the files.

        Raises:
            OSError: one cannot be written.
        """
        try:
            if self._video is not None:
                self.film()
        finally:
            self._env.close()
