"""`Core`: what an environment needs of an emulator, on one page.

A core plays one game. It knows frames, actions, RAM, pixels and sound; observations, frame skip over several calls,
spaces and seeding by a Gymnasium seed belong to `AtariEnv` above it. `tests/core_contract.py` is this page as tests.
"""

from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from atari.game import Game

ByteArray = npt.NDArray[np.uint8]


class Core(Protocol):
    """One running game.

    A core is ready when constructed: the game is loaded, as after ALE's `loadROM`. Arrays are `uint8` and belong to
    the caller; with `out` (C-contiguous, same shape and dtype) that array is filled and returned instead of a new one,
    and another `out` is a ValueError.
    """

    name: str
    game: Game
    sound: bool

    def seed(self, seed: int) -> None:
        """Start over as if constructed with this seed (0 .. 2**32 - 1); mode and difficulty stay.

        Raises:
            TypeError, ValueError: it is no such seed.
        """

    def reset(self) -> None:
        """Start a new game: power on, 60 frames, RESET, mode selection, the game's starting actions."""

    def act(self, action: int, strength: float = 1.0) -> int:
        """Play `frame_skip` frames with an ALE action number (0..17) and return the reward.

        `strength` scales paddle movement. Actions the game does not allow count as NOOP; after the end nothing
        happens and the reward is 0.

        Raises:
            TypeError, ValueError: no action, or a strength that is not finite.
        """

    @property
    def lives(self) -> int:
        """Lives left, as the game's rules count them (0 throughout in games without lives)."""

    @property
    def game_over(self) -> bool:
        """Whether the game has ended by its own rules."""

    @property
    def truncated(self) -> bool:
        """Whether the episode has reached `max_num_frames_per_episode`."""

    @property
    def frame_number(self) -> int:
        """Frames played since the game was loaded."""

    @property
    def episode_frame_number(self) -> int:
        """Frames played since the last reset."""

    def ram(self, out: ByteArray | None = None) -> ByteArray:
        """(128,) bytes of RAM, addresses 0x80..0xFF in order."""

    def set_ram(self, index: int, value: int) -> None:
        """Write one byte of RAM; `index` 0..127, `value` 0..255.

        Raises:
            TypeError, ValueError: one of them is no such integer; nothing is written.
        """

    def screen(self, out: ByteArray | None = None) -> ByteArray:
        """(height, 160) palette indices."""

    def screen_rgb(self, out: ByteArray | None = None) -> ByteArray:
        """(height, 160, 3) red, green, blue."""

    def screen_grayscale(self, out: ByteArray | None = None) -> ByteArray:
        """(height, 160) luminance, by ALE's table."""

    def audio(self, out: ByteArray | None = None) -> ByteArray:
        """(512,) samples of the last `act`, unsigned around 128; all zero unless made with `sound=True`."""

    def with_sound(self) -> "Core":
        """This core if it makes sound, else another one that does, in the same state.

        The sound generators of the other one start anew, with the registers that the game has set.
        """

    def snapshot(self) -> bytes:
        """The whole state, to be restored in this or another process."""

    def restore(self, data: bytes) -> None:
        """Continue from a snapshot.

        Raises:
            TypeError, ValueError: not a snapshot, damaged, or of another game, core or other options.
        """

    def clone_state(self, include_rng: bool = False) -> Any:
        """A state in memory, as cheap as this core can; it is opaque, and belongs to this kind of core."""

    def restore_state(self, state: Any) -> None:
        """Continue from a cloned state; the generators of the environment too if it included them.

        Raises:
            TypeError, ValueError: it is no cloned state, or of another game or kind of core.
        """

    def close(self) -> None:
        """Release what the core holds; every later call but `close` raises `RuntimeError`."""
