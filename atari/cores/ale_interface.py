"""`env.unwrapped.ale`: a core under the method names of ale-py's `ALEInterface`.

Wrappers of Gymnasium and Stable-Baselines3 call `env.unwrapped.ale.lives()` and other methods of ale-py. `AleInterface`
has these methods for every core, with the core's checks.
"""

from atari.actions import Action
from atari.cores.core import ByteArray, Core


class AleInterface:
    """The methods of ale-py's `ALEInterface` for a running game; ale-py documents each.

    Arrays and errors are those of `atari.cores.Core`.
    """

    # ruff: noqa: D102 - the names are ale-py's, one line each

    def __init__(self, core: Core) -> None:
        self._core = core

    def act(self, action: int, paddle_strength: float = 1.0) -> int:
        return self._core.act(action, paddle_strength)

    def reset_game(self) -> None:
        self._core.reset()

    def lives(self) -> int:
        return self._core.lives

    def game_over(self, with_truncation: bool = True) -> bool:
        return self._core.game_over or (with_truncation and self._core.truncated)

    def game_truncated(self) -> bool:
        return self._core.truncated

    def getFrameNumber(self) -> int:
        return self._core.frame_number

    def getEpisodeFrameNumber(self) -> int:
        return self._core.episode_frame_number

    def getRAM(self, buffer: ByteArray | None = None) -> ByteArray:
        return self._core.ram(buffer)

    def getRAMSize(self) -> int:
        return 128

    def setRAM(self, index: int, value: int) -> None:
        self._core.set_ram(index, value)

    def getScreen(self, buffer: ByteArray | None = None) -> ByteArray:
        return self._core.screen(buffer)

    def getScreenRGB(self, buffer: ByteArray | None = None) -> ByteArray:
        return self._core.screen_rgb(buffer)

    def getScreenGrayscale(self, buffer: ByteArray | None = None) -> ByteArray:
        return self._core.screen_grayscale(buffer)

    def getScreenDims(self) -> tuple[int, int]:
        return self._core.game.screen.shape

    def getAudio(self, buffer: ByteArray | None = None) -> ByteArray:
        return self._core.audio(buffer)

    def getMinimalActionSet(self) -> list[Action]:
        return list(self._core.game.minimal_actions)

    def getLegalActionSet(self) -> list[Action]:
        return list(self._core.game.legal_actions)

    def getAvailableModes(self) -> list[int]:
        return list(self._core.game.modes)

    def getAvailableDifficulties(self) -> list[int]:
        return list(self._core.game.difficulties)
