"""`AssignedAle`: the core of an environment whose attribute `ale` a user has assigned.

ale-py's environment plays and reads everything through its attribute `ale`. So users assign an object that changes what
an environment shows: HackAtari's inpainting, mocks of OCAtari. Our environment plays its core. An assignment puts this
class between the two, so an environment without an assignment does not change.
"""

from typing import Any

from atari.cores.ale_actions import Action as AleAction
from atari.cores.core import ByteArray, Core


class AssignedAle:
    """A core that is played and read through an object with the methods of ale-py's `ALEInterface`.

    The methods below call those that ale-py's environment calls. Every other attribute is the emulator core's.

    Args:
        emulated: the emulator core.
        ale: the object.
    """

    def __init__(self, emulated: Core, ale: Any) -> None:
        self.emulated: Any = emulated
        self.ale = ale

    def __getattr__(self, name: str) -> Any:
        return getattr(self.emulated, name)

    def reset(self) -> None:
        """Start a new game."""
        self.ale.reset_game()

    def act(self, action: int, strength: float = 1.0) -> int:
        """Play a frame."""
        return self.ale.act(AleAction(action), strength)

    @property
    def lives(self) -> int:
        """Lives left."""
        return self.ale.lives()

    @property
    def game_over(self) -> bool:
        """Whether the game has ended by its own rules."""
        return self.ale.game_over(with_truncation=False)

    @property
    def truncated(self) -> bool:
        """Whether the episode has reached its limit of frames."""
        return self.ale.game_truncated()

    @property
    def frame_number(self) -> int:
        """Frames played since the game was loaded."""
        return self.ale.getFrameNumber()

    @property
    def episode_frame_number(self) -> int:
        """Frames played since the last reset."""
        return self.ale.getEpisodeFrameNumber()

    def ram(self, out: ByteArray | None = None) -> ByteArray:
        """The bytes of RAM."""
        return _read(self.ale.getRAM, out)

    def screen_rgb(self, out: ByteArray | None = None) -> ByteArray:
        """The screen in red, green, blue."""
        return _read(self.ale.getScreenRGB, out)

    def screen_grayscale(self, out: ByteArray | None = None) -> ByteArray:
        """The screen in luminance."""
        return _read(self.ale.getScreenGrayscale, out)

    def audio(self, out: ByteArray | None = None) -> ByteArray:
        """The samples of the last `act`."""
        return _read(self.ale.getAudio, out)

    def screen(self, out: ByteArray | None = None) -> ByteArray:
        """Raise an error: preprocessing in C++ reads palette indices, which show no change of `getScreenRGB`.

        Raises:
            ValueError: always.
        """
        raise ValueError(
            "this preprocessing reads the emulator's palette indices, and would not show what the assigned env.ale "
            "returns; use gymnasium.wrappers.AtariPreprocessing, which reads through env.ale, or assign the former ale"
        )

    @property
    def writes(self) -> list[Any]:
        """The writes by slot."""
        return self.emulated.writes

    @writes.setter
    def writes(self, slots: list[Any]) -> None:
        self.emulated.writes = slots


def _read(getter: Any, out: ByteArray | None) -> ByteArray:
    """The array that a getter of ale-py's returns, or `out`, which the getter has filled."""
    if out is None:
        return getter()
    getter(out)
    return out
