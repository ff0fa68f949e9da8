"""`NativeCore`: our own emulator, in C++ (`atari/emulator/`), with the interface `Core`.

Bit-exact with ale-py: RAM, framebuffer, sound, reward, lives, ends, counters, and the decisions of sticky actions.
`clone_state` returns the state in memory, `snapshot` as portable bytes.
"""

import zlib
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from functools import lru_cache
from os import PathLike
from typing import Any

import numpy as np
from typing_extensions import Self

import atari._emulator as _emulator
from atari.base.validation import check_integer, check_poke
from atari.cores import copies, snapshot, writes
from atari.cores.options import SEED_LIMIT, CoreOptions, check_difficulty, check_mode
from atari.cores.readable import with_readable_errors
from atari.games.catalog import games
from atari.games.compiler import CompiledRules, compile_rules
from atari.games.game import Game
from atari.games.interventions import Intervention
from atari.roms import find
from atari.roms import image as rom_image

STATE_VERSION: int = _emulator.STATE_VERSION
"""The version of the layout of saved states: `Machine` and `EnvironmentState` of the C++ headers, as in memory."""

_F8_SWAPPED = {"bc24440b59092559a1ec26055fd1270e", "75ee371ccfc4f43e7d9b8f24e1266b55"}
_NO_RULES = CompiledRules(
    variables=4, initial=[], kept=[], outputs=[1, 3, 0, 2], step=[_emulator.END, 0], select_mode=[_emulator.END, 0]
)
"""The rules of a game without single-player rules: no reward, no lives, no end."""


@with_readable_errors
class EmulatorCore(_emulator.Emulator):
    """The emulator with checked pokes, copies, and snapshots as portable bytes; the base of our cores."""

    sound: bool

    def set_ram(self, index: int, value: int) -> None:
        """Write one byte of RAM."""
        super().set_ram(*check_poke(index, value))

    def snapshot(self) -> bytes:
        """The whole state as portable bytes, about 5 kB."""
        return snapshot.pack(self._facts(), {"state": zlib.compress(self.save(), 1)})

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

    def __getstate__(self) -> dict[str, Any]:
        """Pickling and copying keep the position in the game, and the writes of `Freeze` and `Poke`."""
        return copies.save(self)

    def __setstate__(self, state: dict[str, Any]) -> None:
        copies.load(self, state)

    def _arguments(self) -> dict[str, Any]:
        """The arguments that make such a core."""
        raise NotImplementedError

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
        self.game: Game = games.resolve(game)
        self.interventions = tuple(interventions)
        """The interventions that the core was made with."""
        made = writes.make_writes(self.game, self.interventions)
        self._options = CoreOptions.check(
            self.game,
            repeat_action_probability=repeat_action_probability,
            mode=mode,
            difficulty=difficulty,
            frame_skip=frame_skip,
            max_num_frames_per_episode=max_num_frames_per_episode,
            sound=sound,
            color_averaging=color_averaging,
        )
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


@lru_cache(maxsize=128)
def compiled(game: Game, image: bytes) -> _emulator.Game:
    """The game for the emulator, built once and shared by all cores of the game."""
    return make_game(
        game,
        image,
        compile_rules(game.rules) if game.rules else _NO_RULES,
        legal_actions=game.legal_actions or range(18),
        starting_actions=game.starting_actions,
        default_mode=game.default_mode,
    )


def make_game(
    game: Game,
    image: bytes,
    rules: CompiledRules,
    *,
    legal_actions: Iterable[int],
    starting_actions: Iterable[int],
    default_mode: int,
    paddle_range: tuple[int, int] | None = None,
) -> _emulator.Game:
    """A game for the emulator, with rules for one or for several players."""
    controllers = game.controllers
    switches = 0x3F | (controllers.left_difficulty == "A") << 6 | (controllers.right_difficulty == "A") << 7
    swapped = rom_image.md5(image) in _F8_SWAPPED and not game.rom.cartridge
    return _emulator.make_game(
        image=image,
        cartridge="F8 SWAPPED" if swapped else game.rom.cartridge,
        format=game.screen.format,
        detect_format=game.screen.format_detected,
        first_line=game.screen.first_line,
        height=game.screen.height,
        hmove_blanks=game.screen.hmove_blanks,
        paddles=(controllers.left == "paddles", controllers.right == "paddles"),
        swap_ports=controllers.swap_ports,
        swap_paddles=controllers.swap_paddles,
        paddle_range=paddle_range or controllers.paddle_range or (27450, 790196),
        power_on_switches=switches,
        legal_actions=[int(action) for action in legal_actions],
        starting_actions=[int(action) for action in starting_actions],
        default_mode=default_mode,
        variables=rules.variables,
        initial=rules.initial,
        kept=rules.kept,
        outputs=rules.outputs,
        step=rules.step,
        select_mode=rules.select_mode,
    )
