"""`Session`: a game of one player, played by hand, without its window: the emulator and the replay."""

from os import PathLike
from pathlib import Path
from typing import Any, ClassVar

from atari.actions import Action
from atari.cores import ByteArray
from atari.env import AtariEnv
from atari.games.game import Game
from atari.play.base import BaseSession
from atari.recording import RecordReplay


class Session(BaseSession):
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

    Example:
        >>> import atari
        >>> from atari.play import Session
        >>> session = Session("pong")
        >>> session.score, session.over, session.screen.shape
        (0, False, (210, 160, 3))
        >>> session.close()
    """

    _saved_as: ClassVar[str] = "play"  # `AtariEnv.restore` reads these files, too
    _blob: ClassVar[str] = "env"

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
        super().__init__(self._atari.game, 1, state, videos, scale)
        self._env: Any = self._atari if replay is None else RecordReplay(self._atari, replay)
        self.best = 0
        self._env.reset(seed=seed)

    @property
    def score(self) -> int:
        """The score of the current game."""
        return self.scores[0]

    @property
    def legal_actions(self) -> tuple[Action, ...]:
        """The game's legal actions."""
        return self._atari.game.legal_actions

    @property
    def over(self) -> bool:
        """Whether the game has ended."""
        return self._atari.core.game_over or self._atari.core.truncated

    @property
    def screen(self) -> ByteArray:
        """The current screen, (height, 160, 3) uint8."""
        return self._atari.core.screen_rgb()

    @property
    def samples(self) -> ByteArray:
        """The sound of the last frame, (512,) uint8 around 128."""
        return self._atari.core.audio()

    @property
    def title(self) -> str:
        """The game and the score, for the window's title."""
        return f"{self.game.title}   {self.score:,}"

    def close(self) -> None:
        """Complete the replay and the video.

        Raises:
            OSError: a file cannot be written.
        """
        try:
            super().close()
        finally:
            self._env.close()

    def _step(self, actions: tuple[Action, ...]) -> list[int]:
        (action,) = actions
        _, reward, _, _, _ = self._env.step(self.legal_actions.index(action))
        self.best = max(self.best, self.score + int(reward))
        return [int(reward)]

    def _snapshot(self) -> bytes:
        return self._atari.snapshot()

    def _restore(self, data: bytes) -> None:
        self._atari.restore(data)

    def _reset(self) -> None:
        self._env.reset()
