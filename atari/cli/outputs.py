"""`Outputs`: the files of `record` and `demo`. Games are played to a replay, and videos are rendered from it."""

import math
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tqdm import tqdm

from atari.games.game import Game
from atari.recording import Replay, VideoWriter
from atari.recording.replay.file_format import SUFFIX
from atari.recording.video.formats import FORMATS, has_sound
from atari.recording.video.overlay import Overlay
from atari.recording.video.writer import frame_rate


@dataclass(frozen=True)
class Outputs:
    """The replays and videos that a command writes.

    Attributes:
        files: their endings say what they are.
        scale, sound, overlay: as of `Replay.render`.
        best: whether videos show the game with the highest score alone.
    """

    files: list[Path]
    scale: int = 2
    sound: bool = True
    overlay: tuple[str, ...] | None = None
    best: bool = False

    @property
    def replays(self) -> list[Path]:
        """The replays."""
        return [path for path in self.files if path.suffix.lower() == SUFFIX]

    @property
    def videos(self) -> list[Path]:
        """The videos."""
        return [path for path in self.files if path.suffix.lower() != SUFFIX]

    def check(self, game: Game) -> None:
        """Find what is wrong with the videos before the games are played, which may take hours.

        Raises:
            TypeError, ValueError, OSError, gymnasium.error.DependencyNotInstalled: as `VideoWriter`.
        """
        endings = (*FORMATS, SUFFIX)
        for path in self.files:
            if path.suffix.lower() not in endings:
                raise ValueError(f"-o is a file that ends in one of {', '.join(endings)}, got {str(path)!r}")
        shown = Overlay(self.overlay)
        size, lines = shown.size(game.screen.shape), shown.caption_lines
        for path in self.videos:
            sound = self.sound and has_sound(path)
            VideoWriter(
                path, size, frame_rate(game), scale=self.scale, sound=sound, caption_lines=lines
            ).close()  # without frames it leaves no file

    def replay(self, folder: str) -> Path:
        """The replay that is played to: the first one, or one in a folder of temporary files."""
        return self.replays[0] if self.replays else Path(folder, "games.a26")

    def write(self, replay: Replay, seconds: float | None = None) -> int:
        """Write all files but the one that the replay was loaded from; returns the number of frames of a video.

        Args:
            replay: what was played.
            seconds: the length of the videos; None is the whole.
        """
        for path in self.replays:
            if path != replay.path:
                path.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(replay.path, path)
        frames, part = replay.frames_total, dict[str, int]()
        if self.best:
            part = {"episode": replay.best_episode}
            frames = replay.episodes[replay.best_episode].frames
        elif seconds is not None:
            frames = min(frames, math.ceil(seconds * frame_rate(replay.game)))
            part = {"stop": frames}
        options: dict[str, Any] = {"scale": self.scale, "sound": self.sound, "overlay": self.overlay, **part}
        for path in self.videos:
            with tqdm(unit=" frames", total=frames, disable=None) as bar:
                replay.render(path, **options, progress=bar.update)
        return frames

    def __str__(self) -> str:
        return " and ".join(str(path.resolve()) for path in self.files)
