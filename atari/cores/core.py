"""`Core`: the interface of an emulator that environments use.

A core plays one game: frames, actions, RAM, pixels and sound. Observations, frame skip over several calls, spaces and
seeding by a Gymnasium seed belong to `AtariEnv`. `atari.testing.check_core` checks each rule here.
"""

from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from atari.games.game import Game

ByteArray = npt.NDArray[np.uint8]
"""An array of uint8 with any shape."""


class Core(Protocol):
    """One running game.

    A core is ready when constructed: the game is loaded, as after ALE's `loadROM`. Arrays are `uint8` and belong to
    the caller; with `out` (C-contiguous, same shape and dtype) that array is filled and returned instead of a new one,
    and another `out` is a ValueError.

    Example:
        >>> import atari
        >>> def play(core: atari.cores.Core) -> int:
        ...     core.reset()
        ...     return sum(core.act(0) for _ in range(100))
        >>> play(atari.cores.NativeCore("pong", seed=0)) == play(atari.cores.AleCore("pong", seed=0))
        True
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
            TypeError, ValueError: `action` is no action, or `strength` is not finite.
        """

    def set_mode(self, mode: int) -> None:
        """Play one of the game's modes from the next reset on.

        Raises:
            TypeError, ValueError: the game has no such mode.
        """

    def set_difficulty(self, difficulty: int) -> None:
        """Play one of the game's difficulties from the next frame on.

        Raises:
            TypeError, ValueError: the game has no such difficulty.
        """

    @property
    def mode(self) -> int:
        """The mode that the next reset plays."""

    @property
    def difficulty(self) -> int:
        """The difficulty that the next frame plays."""

    @property
    def lives(self) -> int:
        """Lives left, by the game's rules (always 0 in games without lives)."""

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
            TypeError, ValueError: one of them is not such an integer; nothing is written.
        """

    def screen(self, out: ByteArray | None = None) -> ByteArray:
        """(height, 160) palette indices."""

    def screen_rgb(self, out: ByteArray | None = None) -> ByteArray:
        """(height, 160, 3) red, green, blue."""

    def screen_grayscale(self, out: ByteArray | None = None) -> ByteArray:
        """(height, 160) luminance, by ALE's table."""

    def redraw(self, out: ByteArray | None = None) -> ByteArray:
        """(height, 160, 3): the present RAM, rendered by emulating a frame in a copy. The state does not change.

        Raises:
            NotImplementedError: the core is ale-py's, whose states are incomplete.
        """

    def audio(self, out: ByteArray | None = None) -> ByteArray:
        """(512,) samples of the last `act`, unsigned around 128; all zero unless made with `sound=True`."""

    def with_sound(self) -> "Core":
        """This core if it makes sound, else a new one that does, in the same state.

        The sound generators of a new core start from their initial state, with the registers that the game has set.
        """

    def snapshot(self) -> bytes:
        """The whole state, to be restored in this or another process."""

    def restore(self, data: bytes) -> None:
        """Continue from a snapshot.

        Raises:
            TypeError, ValueError: `data` is no snapshot, is damaged, or belongs to another game, core or options.
        """

    def clone_state(self, include_rng: bool = False) -> Any:
        """The state in memory, an opaque object of this kind of core; faster than `snapshot`."""

    def restore_state(self, state: Any) -> None:
        """Continue from a cloned state, with its random generators if the state includes them.

        Raises:
            TypeError, ValueError: it is no cloned state, or belongs to another game or kind of core.
        """

    def close(self) -> None:
        """Release the emulator; every later call except `close` raises `RuntimeError`."""
