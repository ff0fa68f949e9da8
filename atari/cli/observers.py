"""Observers of the emulated frames of an environment, including those inside a frame skip."""

from dataclasses import dataclass, field

from atari.env import AtariEnv
from atari.recording import VideoWriter


@dataclass
class ScoreCounter:
    """The number of frames, and the score of each game, without the clipping of wrappers."""

    frames: int = 0
    scores: list[int] = field(default_factory=list)

    def game_begun(self) -> None:
        """Begin a new score."""
        self.scores.append(0)

    def frame_played(self, action: int, reward: int) -> None:
        """Count a frame and its reward."""
        self.frames += 1
        self.scores[-1] += reward


@dataclass
class VideoObserver:
    """Writes each frame to a video. An error of the video ends the command."""

    env: AtariEnv
    video: VideoWriter

    def game_begun(self) -> None:
        """Do nothing: no frame was played yet."""

    def frame_played(self, action: int, reward: int) -> None:
        """Write a frame and its sound."""
        core = self.env.core
        self.video.write(core.screen_rgb(), core.audio() if self.video.sound else None)
