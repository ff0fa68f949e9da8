"""`NativeCore`: our own emulator, in C++ (`atari/emulator/`), with the interface `Core`.

Bit-exact with ale-py: RAM, framebuffer, sound, reward, lives, ends, counters, and the decisions of sticky actions.
`clone_state` returns the state in memory, `snapshot` as portable bytes.
"""

import functools
import re
import zlib
from collections.abc import Callable, Sequence
from dataclasses import asdict
from os import PathLike
from typing import Any, TypeVar

import numpy as np
from typing_extensions import Self

import atari._emulator as _emulator
from atari.base.validation import check_integer, check_poke
from atari.cores import snapshot, writes
from atari.cores.compiled import compiled
from atari.cores.options import SEED_LIMIT, CoreOptions, check_difficulty, check_mode
from atari.cores.snapshot import CopiedBySnapshot
from atari.games.catalog import games
from atari.games.game import Game
from atari.games.interventions import Intervention
from atari.roms import find
from atari.roms import image as rom_image

STATE_VERSION: int = _emulator.STATE_VERSION
"""The version of the layout of saved states: `Machine` and `EnvironmentState` of the C++ headers, as in memory."""

_Class = TypeVar("_Class", bound=type)

_FAST = {"act", "act_until", "reset", "ram", "audio", "screen", "screen_rgb", "screen_grayscale", "redraw"}
"""Methods that are called for each frame. They convert their arguments themselves, and have no wrapper."""


def _with_readable_errors(kind: _Class) -> _Class:
    """Replace the methods that a class inherits from the extension module, except the fast ones.

    If the binding refuses the number or the types of the arguments, a TypeError with one sentence says which it takes.
    """
    for name in dir(kind):
        method = getattr(kind, name)
        if not name.startswith("_") and name not in _FAST and hasattr(method, "__nb_signature__"):
            setattr(kind, name, _readable(method))
    return kind


def _readable(method: Any) -> Callable[..., Any]:
    takes = re.sub(r"\b(?:[A-Za-z_]\w*\.)+(?=[A-Za-z_])", "", method.__nb_signature__[0][0])
    takes = re.sub(r"\\\d+", "...", takes.removeprefix("def ").partition(" -> ")[0]).replace("(self, ", "(")
    takes = takes.replace("(self)", "()")

    @functools.wraps(method)
    def call(self: Any, *arguments: Any, **named: Any) -> Any:
        try:
            return method(self, *arguments, **named)
        except TypeError as error:
            if "incompatible function arguments" not in str(error):
                raise
        given = [repr(value)[:40] for value in arguments] + [f"{name}={value!r:.40}" for name, value in named.items()]
        raise TypeError(f"the core's method is {takes}, got ({', '.join(given)})")

    return call


@_with_readable_errors
class EmulatorCore(CopiedBySnapshot, _emulator.Emulator):
    """The emulator with checked pokes, copies, and snapshots as portable bytes; the base of our cores."""

    sound: bool

    def set_ram(self, index: int, value: int) -> None:
        """Write one byte of RAM."""
        super().set_ram(*check_poke(index, value))

    def snapshot(self) -> bytes:
        """The whole state as portable bytes, about 5 kB."""
        return self.snapshot_of(self.save())

    def snapshot_of(self, state: bytes) -> bytes:
        """The snapshot that has this state, which is a result of `save`."""
        return snapshot.pack(self._facts(), {"state": zlib.compress(state, 1)})

    def restore(self, data: bytes) -> None:
        """Continue from a snapshot.

        Raises:
            TypeError, ValueError: `data` is no snapshot, is damaged, or belongs to another game, core, version or
                options. The game has not changed.
        """
        facts, blobs = snapshot.unpack(data)
        self._check(facts)
        snapshot.require_blobs(blobs, "state")
        try:
            state = zlib.decompressobj().decompress(blobs["state"], 1 << 20)
        except zlib.error as error:
            raise ValueError(f"the snapshot is damaged: {error}") from None
        self.load(state)

    def restore_state(self, state: _emulator.State) -> None:
        """Continue from a state that `clone_state` returned; it is complete, with framebuffer, sound and held action.

        Raises:
            TypeError, ValueError: it is no such state, or belongs to another game.
        """
        if not isinstance(state, _emulator.State):
            raise TypeError(f"restore_state takes what clone_state returned, got {type(state).__name__}")
        super().restore_state(state)

    def with_sound(self) -> Self:
        """This core if it makes sound, else a new one that does, in the same state."""
        if self.sound:
            return self
        core = type(self)(**{**self._arguments(), "sound": True})
        core.writes = self.writes
        core.load(self.save())
        return core

    def _check(self, facts: dict[str, Any]) -> None:
        """Raise an error for a snapshot from which the core cannot continue."""
        snapshot.require(facts, self._facts())

    def _facts(self) -> dict[str, Any]:
        """The facts that must be equal in a snapshot for this core."""
        raise NotImplementedError


class NativeCore(EmulatorCore):
    """A game played by the native emulator. See `Core` for the methods.

    Args:
        game: id of a game ("pong"), or a `Game`. The two-player cartridges run too, without reward, lives and end.
        rom: path of the ROM file; None searches (see `atari.roms`). A `Game` without a hash accepts any image.
        interventions: changes of the game, which its frames and resets apply (see `atari.games.interventions`).

    `AleCore` documents the other arguments and the errors. The core releases Python's global interpreter lock
    while it plays frames. Several threads may use a core; their calls run one at a time. If another thread played a
    core while the process was forked, the core raises RuntimeError in the child process.

    Example:
        >>> import atari
        >>> core = atari.cores.NativeCore("pong", seed=0)
        >>> core.reset()
        >>> reward = core.act(2)
        >>> core.ram().shape, core.screen_rgb().shape, core.episode_frame_number
        ((128,), (210, 160, 3), 1)
        >>> saved = core.snapshot()
        >>> core.restore(saved)
    """

    name = "native"
    _plain = False

    def __init__(
        self,
        game: str | Game,
        *,
        seed: int = 0,
        repeat_action_probability: float = 0.25,
        mode: int | None = None,
        difficulty: int | None = None,
        frame_skip: int = 1,
        max_num_frames_per_episode: int = 0,
        sound: bool = False,
        color_averaging: bool = False,
        rom: str | PathLike[str] | None = None,
        interventions: Sequence[Intervention] = (),
    ) -> None:
        given = locals()
        self.game: Game = games.resolve(game)
        self.interventions = tuple(interventions)
        """The interventions that the core was made with."""
        made = writes.make_writes(self.game, self.interventions)
        self._options = CoreOptions.check(self.game, **given)
        self.sound = self._options.sound
        self.rom = rom
        image = rom_image.read_image(find(self.game, rom))
        self.rom_md5 = rom_image.md5(image)
        super().__init__(
            game=compiled(self.game, image),
            repeat_action_probability=as_ale_reads(self._options.repeat_action_probability),
            frame_skip=self._options.frame_skip,
            max_num_frames_per_episode=self._options.max_num_frames_per_episode,
            sound=self.sound,
            color_averaging=self._options.color_averaging,
            seed=_usable(check_integer("seed", seed, 0, SEED_LIMIT - 1)),
            plain=self._plain,
        )
        if self._options.mode is not None:
            self.set_mode(self._options.mode)
        if self._options.difficulty is not None:
            self.set_difficulty(self._options.difficulty)
        for write in made:
            self.add_write(write)

    def seed(self, seed: int) -> None:
        """Start over with this seed, without loading the game again."""
        super().seed(_usable(check_integer("seed", seed, 0, SEED_LIMIT - 1)))

    def set_mode(self, mode: int) -> None:
        """Play one of the game's modes from the next reset on."""
        super().set_mode(check_mode(self.game, mode))

    def set_difficulty(self, difficulty: int) -> None:
        """Play one of the game's difficulties from the next frame on."""
        super().set_difficulty(check_difficulty(self.game, difficulty))

    def _arguments(self) -> dict[str, Any]:
        own = {"game": self.game, "rom": self.rom, "interventions": self.interventions}
        return {**own, **asdict(self._options)}

    def _facts(self) -> dict[str, Any]:
        return {
            "core": NativeCore.name,  # for `PlainCore` too, whose state is the same to the byte
            "game": self.game.id,
            "rom": self.rom_md5,
            "state version": STATE_VERSION,
            "interventions": writes.fact(self.interventions),
            **asdict(self._options),
        }


class PlainCore(NativeCore):
    """The reference core: our emulator without the fast paths, one instruction and one pixel at a time.

    The fast paths of `NativeCore` are tested against it. Snapshots of either core can be restored by the other.

    Example:
        >>> import atari
        >>> fast, plain = atari.cores.NativeCore("pong", seed=0), atari.cores.PlainCore("pong", seed=0)
        >>> fast.reset()
        >>> plain.reset()
        >>> fast.ram().tolist() == plain.ram().tolist()
        True
    """

    name = "plain"
    _plain = True


def as_ale_reads(probability: float) -> float:
    """The probability that ALE uses: it stores settings as text of six digits and parses them as float32."""
    return float(np.float32(f"{np.float32(probability):g}"))


def _usable(seed: int) -> int:
    """The seed, with 2**32 - 1 replaced by the seed below it as in `AleCore`: ale-py replaces it by the clock."""
    return min(seed, SEED_LIMIT - 2)
