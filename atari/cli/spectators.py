"""Those who watch a game that a command has played: they see the frames that are skipped, and the true score."""

from dataclasses import dataclass, field

from atari.env import AtariEnv
from atari.recording import VideoWriter


@dataclass
class ScoreBoard:
    """Counts frames and points of each game."""

    frames: int = 0
    scores: list[int] = field(default_factory=list)

    def game_begun(self) -> None:
        """A new game."""
        self.scores.append(0)

    def frame_played(self, action: int, reward: int) -> None:
        """A frame."""
        self.frames += 1
        self.scores[-1] += reward


@dataclass
class Film:
    """Shows each frame to a video. An error of it ends the command."""

    env: AtariEnv
    video: VideoWriter

    def game_begun(self) -> None:
        """Nothing was played yet."""

    def frame_played(self, action: int, reward: int) -> None:
        """A frame."""
        core = self.env.core
        self.video.write(core.screen_rgb(), core.audio() if self.video.sound else None)
