"""`AleCore`: ale-py with the interface `Core`, and with checks.

ale-py ends the process on a missing or foreign ROM, crashes on a call before loading, and hangs or fails obscurely on
wrong values. So `AleCore` checks every argument first. ale-py's states are incomplete. So a snapshot is a journal
of calls, which `restore` replays; tests compare the restored core with the saved one in thirteen games.
"""

import hashlib
import re
from collections.abc import Sequence
from dataclasses import asdict
from os import PathLike
from typing import Any

import ale_py
import gymnasium
import numpy as np
from ale_py import ALEInterface, ALEState, LoggerMode

from atari.base.extras import pip_install
from atari.base.validation import check_action, check_integer, check_poke, check_strength
from atari.cores import snapshot
from atari.cores.core import ByteArray
from atari.cores.journal import Journal
from atari.cores.options import SEED_LIMIT, CoreOptions, check_difficulty, check_mode
from atari.cores.snapshot import CopiedBySnapshot
from atari.games.catalog import games
from atari.games.game import Game
from atari.games.interventions import Intervention
from atari.roms import find

ALEInterface.setLoggerMode(LoggerMode.Error)  # process-wide: no banner, no line per load

OLDEST_ALE_PY = "0.12.1"
"""The oldest ale-py that `AleCore` is tested with; 0.8.1 has another interface, without sound."""


class AleState:
    """ale-py's state with the hash of its ROM, a result of `AleCore.clone_state`, or made from `serialize`'s bytes.

    Immutable, with the methods of ale-py's `ALEState`. Two states are equal if their ROMs and ale-py's states are.

    Raises:
        TypeError, ValueError: these are not such bytes.
    """

    def __init__(self, serialized: bytes) -> None:
        facts, blobs = snapshot.unpack(serialized)
        snapshot.require(facts, {"of": "AleState", "ale-py": ale_py.__version__})
        self.rom_md5, self.state = str(facts["rom"]), ALEState(blobs["state"])

    @classmethod
    def of(cls, rom_md5: str, state: ALEState) -> "AleState":
        """A state of ale-py for the game with this ROM."""
        made = cls.__new__(cls)
        made.rom_md5, made.state = rom_md5, state
        return made

    def serialize(self) -> bytes:
        """The state as bytes, for this version of ale-py."""
        facts = {"of": "AleState", "rom": self.rom_md5, "ale-py": ale_py.__version__}
        return snapshot.pack(facts, {"state": self.state.serialize()})

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, AleState):
            return NotImplemented
        return self.rom_md5 == other.rom_md5 and bool(self.state == other.state)

    __hash__ = None  # type: ignore[assignment]

    def equals(self, other: "AleState") -> bool:
        """Whether the states are equal."""
        return self == other

    def __reduce__(self) -> tuple[type["AleState"], tuple[bytes]]:
        return AleState, (self.serialize(),)

    def getFrameNumber(self) -> int:
        """Frames played since loading."""
        return int(self.state.getFrameNumber())

    def getEpisodeFrameNumber(self) -> int:
        """Frames played since the last reset."""
        return int(self.state.getEpisodeFrameNumber())

    def getCurrentMode(self) -> int:
        """The game's mode."""
        return int(self.state.getCurrentMode())

    def getDifficulty(self) -> int:
        """The game's difficulty."""
        return int(self.state.getDifficulty())


class AleCore(CopiedBySnapshot):
    """A game played by ale-py. See `Core` for the methods.

    Args:
        game: id of a playable game, for example "pong", or such a `Game`.
        seed: for ALE's generator (sticky actions), 0 .. 2**32 - 1. ale-py cannot use 2**32 - 1; it becomes 2**32 - 2.
        repeat_action_probability: probability of repeating the previous action, each frame.
        mode, difficulty: among `games[game].modes` and `.difficulties`; None is the default.
        frame_skip: frames for each `act`. As in ALE, it also applies to the actions with which a reset selects the
            mode (in Berzerk, Double Dunk and Video Cube). `AtariEnv` has 1 here and skips frames itself, like ale-py's
            environment. So it resets these games otherwise than a core with the same frame skip.
        max_num_frames_per_episode: frames after which an episode is truncated; 0 means never.
        sound: produce samples for `audio()`.
        color_averaging: average each frame with the one before it (ALE's colour averaging, against flicker).
        rom: path of the ROM file; None searches (see `atari.roms`).
        interventions: none; this core refuses them.

    Raises:
        TypeError, ValueError: an argument is wrong, or the ROM file is not of this game.
        FileNotFoundError: there is no ROM file.
        gymnasium.error.DependencyNotInstalled: the installed ale-py is older than `OLDEST_ALE_PY`.

    Example:
        >>> import atari
        >>> core = atari.cores.AleCore("pong", seed=0)
        >>> core.reset()
        >>> reward = core.act(2)
        >>> core.ram().shape
        (128,)
    """

    name = "ale"

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
        if interventions:
            raise ValueError("ale-py's core cannot write RAM within a frame; use interventions with core='native'")
        if _numbers(ale_py.__version__) < _numbers(OLDEST_ALE_PY):
            raise gymnasium.error.DependencyNotInstalled(
                f"core='ale' needs ale-py {OLDEST_ALE_PY} or newer, and {ale_py.__version__} is installed; "
                f"run `{pip_install('--upgrade', 'ale-py')}`, or use core='native', which needs none"
            )
        self.game: Game = games.find(game)
        if self.game != games.get(self.game.id):
            raise ValueError(f"ale-py has only its own games, not {self.game.id!r}; use core='native'")
        self._options = CoreOptions.check(self.game, **given)
        self._mode, self._difficulty = self._options.mode, self._options.difficulty
        seed = check_integer("seed", seed, 0, SEED_LIMIT - 1)
        self.rom, self._rom = rom, find(self.game.id, rom)
        self._journal: Journal | None
        self.sound = self._options.sound
        # A reset sets everything that ale-py's states leave out, except the sound generator and the variables that the
        # rules of two games keep over a reset. With these, only a journal since loading is complete.
        kept = self.game.rules is not None and bool(self.game.rules.kept_over_reset)
        self._sound_or_rules_outlive_reset = self.sound or kept
        ale = ALEInterface()
        ale.setFloat("repeat_action_probability", self._options.repeat_action_probability)
        ale.setInt("frame_skip", self._options.frame_skip)
        ale.setInt("max_num_frames_per_episode", self._options.max_num_frames_per_episode)
        ale.setBool("sound_obs", self.sound)
        ale.setBool("color_averaging", self._options.color_averaging)
        self._ale: Any = _Unloaded(self, ale)
        self._seed = seed
        self._begin_journal()

    def seed(self, seed: int) -> None:
        """Start over with this seed. ale-py takes its seed from loading, so this loads the game again."""
        self._load(check_integer("seed", seed, 0, SEED_LIMIT - 1))
        self._begin_journal()

    def reset(self) -> None:
        """Start a new game."""
        if not self._sound_or_rules_outlive_reset:
            self._begin_journal(self._ale.cloneSystemState().serialize())
        self._ale.reset_game()
        if self._journal is not None:
            self._journal.reset()

    def act(self, action: int, strength: float = 1.0) -> int:
        """Play `frame_skip` frames of an action and return the reward."""
        if action.__class__ is not int or not 0 <= action <= 17:
            action = check_action(action)
        if strength.__class__ is not float or strength != 1.0:
            strength = check_strength(strength)
        reward: int = self._ale.act(action, strength)
        if self._journal is not None:
            self._journal.act(action, strength)
        return reward

    def set_mode(self, mode: int) -> None:
        """Play one of the game's modes from the next reset on."""
        self._mode = check_mode(self.game, mode)
        self._ale.setMode(self._mode)
        if self._journal is not None:
            self._journal.set_mode(self._mode)

    @property
    def mode(self) -> int:
        """The mode that the next reset plays."""
        return self.game.default_mode if self._mode is None else self._mode

    @property
    def difficulty(self) -> int:
        """The difficulty that the next frame plays."""
        return self._difficulty or 0

    def set_difficulty(self, difficulty: int) -> None:
        """Play one of the game's difficulties from the next frame on."""
        self._difficulty = check_difficulty(self.game, difficulty)
        self._ale.setDifficulty(self._difficulty)
        if self._journal is not None:
            self._journal.set_difficulty(self._difficulty)

    @property
    def lives(self) -> int:
        """Lives left."""
        return int(self._ale.lives())

    @property
    def game_over(self) -> bool:
        """Whether the game has ended by its own rules."""
        return bool(self._ale.game_over(with_truncation=False))

    @property
    def truncated(self) -> bool:
        """Whether the episode has reached its frame limit."""
        return bool(self._ale.game_truncated())

    @property
    def frame_number(self) -> int:
        """Frames played since loading."""
        return int(self._ale.getFrameNumber())

    @property
    def episode_frame_number(self) -> int:
        """Frames played since the last reset."""
        return int(self._ale.getEpisodeFrameNumber())

    def ram(self, out: ByteArray | None = None) -> ByteArray:
        """The 128 bytes of RAM."""
        return _filled(self._ale.getRAM, (128,), out)

    def set_ram(self, index: int, value: int) -> None:
        """Write one byte of RAM."""
        index, value = check_poke(index, value)
        self._ale.setRAM(index, value)
        if self._journal is not None:
            self._journal.poke(index, value)

    def screen(self, out: ByteArray | None = None) -> ByteArray:
        """(height, 160) palette indices."""
        return _filled(self._ale.getScreen, self.game.screen.shape, out)

    def screen_rgb(self, out: ByteArray | None = None) -> ByteArray:
        """(height, 160, 3) red, green, blue."""
        return _filled(self._ale.getScreenRGB, (*self.game.screen.shape, 3), out)

    def screen_grayscale(self, out: ByteArray | None = None) -> ByteArray:
        """(height, 160) luminance."""
        return _filled(self._ale.getScreenGrayscale, self.game.screen.shape, out)

    def redraw(self, out: ByteArray | None = None) -> ByteArray:
        """Raise an error: ale-py's states leave out the framebuffer, so no frame can be undone.

        Raises:
            NotImplementedError: always.
        """
        raise NotImplementedError("ale-py's core cannot take a frame back; use redraw() of core='native'")

    def audio(self, out: ByteArray | None = None) -> ByteArray:
        """(512,) samples of the last act."""
        return _filled(self._ale.getAudio, (512,), out)

    def clone_state(self, include_rng: bool = False) -> AleState:
        """ale-py's own state: quick to restore, but without framebuffer, held action and sound, unlike `snapshot`."""
        return AleState.of(self.game.rom.md5, self._ale.cloneState(include_rng=include_rng))

    def restore_state(self, state: AleState) -> None:
        """Continue from a state that `clone_state` returned.

        As in ale-py, the framebuffer changes only with the next act, the held action stays, and the generator of
        sticky actions continues unless the state includes it. No journal leads to this state of the machine. So
        `snapshot` raises until the next reset (with `sound`, until the next `seed`).

        Raises:
            TypeError, ValueError: it is no such state, or belongs to another game.
        """
        if not isinstance(state, AleState):
            raise TypeError(f"restore_state takes what clone_state returned, got {type(state).__name__}")
        if state.rom_md5 != self.game.rom.md5:
            raise ValueError(f"the state is of another game than {self.game.id}")
        self._ale.restoreState(state.state)
        self._journal = None

    def with_sound(self) -> "AleCore":
        """This core if it makes sound, else a new one that does, brought to the same state by `restore`.

        Raises:
            RuntimeError: see `snapshot`.
        """
        return self if self.sound else self._twin(self._seed, self._complete_journal(), sound=True)

    def snapshot(self) -> bytes:
        """The whole state: the calls since the last reset (with `sound`, since loading).

        Its cost grows with the length of the episode: about a byte for each act.

        Raises:
            RuntimeError: `restore_state` was called, after which ale-py's machine cannot be saved completely.
        """
        journal = self._complete_journal()
        facts = {**self._facts(), "seed": self._seed}
        blobs = {"base": journal.base, "events": bytes(journal.events), "digest": self._digest()}
        return snapshot.pack(facts, blobs)

    def restore(self, data: bytes) -> None:
        """Continue from a snapshot: load the game and replay the calls, in about the time that they took.

        Raises:
            TypeError, ValueError: `data` is no snapshot, is damaged, or belongs to another game, core, ale-py or other
                options; or the calls do not lead to the snapshot's state. The core has not changed.
        """
        facts, blobs = snapshot.unpack(data)
        snapshot.require(facts, self._facts())
        snapshot.require_blobs(blobs, "base", "events", "digest")
        seed = facts.get("seed")
        if type(seed) is not int or not 0 <= seed < SEED_LIMIT:
            raise ValueError(f"the snapshot is damaged: its seed is no integer within 0..{SEED_LIMIT - 1}")
        journal = Journal(blobs["base"], bytearray(blobs["events"]))
        journal.check()
        self._ale.lives()  # raises if this core is closed
        try:
            twin = self._twin(seed, journal)
        except Exception as error:  # ale-py raises errors of several classes, SystemError too, for a damaged state
            raise ValueError(f"ale-py cannot continue from this snapshot of {self.game.id} ({error})") from error
        if twin._digest() != blobs["digest"]:
            raise ValueError(
                f"the calls in this snapshot of {self.game.id} do not lead to the state that it was taken in, so it "
                "was changed; take a new one"
            )
        self._ale, self._seed, self._journal = twin._ale, seed, twin._journal
        self._mode, self._difficulty = twin._mode, twin._difficulty

    def close(self) -> None:
        """Release the emulator."""
        self._ale = _Closed()

    def _arguments(self) -> dict[str, Any]:
        return {"game": self.game, "rom": self.rom, **asdict(self._options)}

    def _load(self, seed: int) -> None:
        """Load the ROM, which also resets ale-py's counters and generators."""
        rom = find(self.game.id, self._rom)  # checked again: ale-py ends the process if the file is missing or wrong
        ale = self._ale.ale if isinstance(self._ale, _Unloaded) else self._ale
        word = min(seed, SEED_LIMIT - 2)  # ale-py replaces 2**32 - 1, which is -1 as int32, by the clock
        ale.setInt("random_seed", word if word < 2**31 else word - 2**32)
        ale.loadROM(rom)
        if self._mode is not None:
            ale.setMode(self._mode)
        if self._difficulty is not None:
            ale.setDifficulty(self._difficulty)
        self._ale, self._seed = ale, seed

    def _begin_journal(self, base: bytes = b"") -> None:
        """Start a journal from this point, with the present mode and difficulty, which may differ from the options."""
        self._journal = Journal(base)
        if self._mode is not None:
            self._journal.set_mode(self._mode)
        if self._difficulty is not None:
            self._journal.set_difficulty(self._difficulty)

    def _complete_journal(self) -> Journal:
        if self._journal is None:
            until = "seed()" if self._sound_or_rules_outlive_reset else "reset()"
            raise RuntimeError(
                f"after restore_state(), a complete snapshot is possible again only after {until}: ale-py's states "
                "leave out part of the machine; use snapshot() and restore() throughout instead"
            )
        return self._journal

    def _twin(self, seed: int, journal: Journal, **options: Any) -> "AleCore":
        """A new core of this game on which a journal has been replayed; `options` override the options of this core."""
        twin = AleCore(self.game, seed=seed, rom=self._rom, **{**asdict(self._options), **options})
        twin._play_again(journal)
        return twin

    def _play_again(self, journal: Journal) -> None:
        """Replay a journal; the game has just been loaded with its seed."""
        if journal.base:
            self._ale.restoreSystemState(ALEState(journal.base))
        for event, first, second in journal.replay():
            if event == "act":
                self._ale.act(first, second)
            elif event == "reset":
                self._ale.reset_game()
            elif event == "mode":
                self._mode = first
                self._ale.setMode(first)
            elif event == "difficulty":
                self._difficulty = first
                self._ale.setDifficulty(first)
            else:
                self._ale.setRAM(first, int(second))
        self._journal = Journal(journal.base, bytearray(journal.events))

    def _facts(self) -> dict[str, Any]:
        """The facts that must be equal in a snapshot for this core."""
        return {
            "core": self.name,
            "game": self.game.id,
            "rom": self.game.rom.md5,
            "ale-py": ale_py.__version__,
            **asdict(self._options),
        }

    def _digest(self) -> bytes:
        """A hash of the visible state of the machine."""
        digest = hashlib.blake2b(digest_size=16)
        for array in (self.ram(), self.screen(), self.audio()):
            digest.update(array.tobytes())
        digest.update(f"{self.lives} {self.frame_number} {self.episode_frame_number}".encode())
        return digest.digest()


class _Unloaded:
    """Loads a core's game at its first use: this takes a tenth of a second, and an earlier seed would repeat it."""

    def __init__(self, core: AleCore, ale: ALEInterface) -> None:
        self.core, self.ale = core, ale

    def __getattr__(self, name: str) -> Any:
        self.core._load(self.core._seed)
        return getattr(self.ale, name)


class _Closed:
    """Stands in for the emulator of a closed core."""

    def __getattr__(self, name: str) -> Any:
        raise RuntimeError("this core is closed; make a new one, or reset its environment")


def _filled(getter: Any, shape: tuple[int, ...], out: ByteArray | None) -> ByteArray:
    """The array that `getter` makes, or `out`, which is checked and then filled by `getter`."""
    if out is None:
        return getter()
    good = isinstance(out, np.ndarray) and out.dtype == np.uint8 and out.shape == shape
    if not (good and out.flags.c_contiguous and out.flags.writeable):
        raise ValueError(f"out must be a writable C-contiguous uint8 array of shape {shape}")
    getter(out)
    return out


def _numbers(version: str) -> tuple[int, ...]:
    """The numbers of a release, "0.12.1" or "0.12.1.dev3", to compare."""
    return tuple(int(number) for number in re.findall(r"\d+", version)[:3])
