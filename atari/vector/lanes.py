"""`Lane`: one environment of a vector."""

import operator
from collections.abc import Callable, Iterable, Sequence
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

import atari._emulator as _emulator
from atari.base.validation import check_name, check_poke
from atari.cores import ByteArray, NativeCore, writes
from atari.cores.ale_interface import AleConsole, AleInterface
from atari.games.game import Game
from atari.games.players import choices


def check_lanes(numbers: Iterable[int], count: int) -> list[int]:
    """The numbers of lanes of a vector of `count` as ints.

    Raises:
        TypeError: they are not integers.
        IndexError: there is no such lane.
    """
    try:
        chosen = [operator.index(number) for number in numbers]
    except TypeError:
        raise TypeError(f"environments are chosen by a list of indices, such as [1, 2], got {numbers!r:.80}") from None
    for number in chosen:
        if not 0 <= number < count:
            raise IndexError(f"there is no environment {number}; choose within 0..{count - 1}")
    return chosen


class AddedWrites:
    """The writes that were added to a lane."""

    def __init__(self, slots: Sequence[_emulator.Write | None] = ()) -> None:
        self.slots = list(slots)
        """The writes by slot, as in the engine after the interventions; None if removed. The last is never None."""
        self.shadows: list[Any] = []
        """Cores that repeat the lane, and get its writes and bytes too."""

    def add(self, write: _emulator.Write) -> int:
        """Record a write that the engine has received; returns its slot."""
        slot = writes.first_free(self.slots)
        self.slots[slot : slot + 1] = [write]
        return slot

    def remove(self, write: _emulator.Write) -> None:
        """Record that the engine has lost a write."""
        self.slots = [None if each is write else each for each in self.slots]
        while self.slots and self.slots[-1] is None:
            self.slots.pop()

    def add_to(self, engine: _emulator.VectorEngine, index: int) -> None:
        """Add the writes to an environment of a new engine, in the same slots: a state lists by slot which are done."""
        if not self.slots:
            return
        last: Any = self.slots[-1]
        for write in self.slots:
            engine.add_write(index, write or last)
        for _ in range(self.slots.count(None)):
            engine.remove_write(index, last)  # removes the first equal write


class Lane:
    """The state of environment `index` of a vector: its numbers, RAM, screen, mode and difficulty.

    Its methods raise RuntimeError between `send` and `recv`, and ClosedEnvironmentError after the vector's `close`.
    """

    def __init__(self, envs: Any, index: int) -> None:  # an AtariVectorEnv, whose module imports this one
        self._envs, self.index = envs, index
        self._engine: Callable[[], _emulator.VectorEngine] = envs._open
        self._lock: _emulator.CallLock = envs._lock
        self.game: Game = envs.games[index]
        self.added: AddedWrites = envs._added[index]

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy is the lane of a copy of the vector."""
        return Lane, (self._envs, self.index)

    def _numbers(self) -> list[int]:
        with self._lock:
            return self._engine().numbers(self.index)

    @property
    def lives(self) -> int:
        """Lives left by the game's rules; with several players, the first player's."""
        return self._numbers()[2]

    @property
    def player_lives(self) -> list[int]:
        """Lives of each player; -1 if the player is out."""
        return self._numbers()[2:]

    @property
    def frame_number(self) -> int:
        """Frames played since the last seed."""
        return self._numbers()[0]

    @property
    def episode_frame_number(self) -> int:
        """Frames played since the game began."""
        return self._numbers()[1]

    @property
    def ended(self) -> bool:
        """Whether the episode has ended: the next step resets the environment, or in DISABLED plays nothing.

        A lost life that `life_loss_info` reports ends no episode.
        """
        with self._lock:
            return self._engine().ended(self.index)

    @property
    def mode(self) -> int:
        """The game's mode; a new value applies from the next reset on."""
        with self._lock:
            return self._engine().mode(self.index)

    @mode.setter
    def mode(self, mode: int) -> None:
        self._choose("mode", mode)

    @property
    def difficulty(self) -> int:
        """The game's difficulty; a new value applies from the next frame on."""
        with self._lock:
            return self._engine().difficulty(self.index)

    @difficulty.setter
    def difficulty(self, difficulty: int) -> None:
        self._choose("difficulty", difficulty)

    def _choose(self, name: str, value: int) -> None:
        checked = self.checked(name, value)
        with self._lock:
            getattr(self._engine(), f"set_{name}")(self.index, checked)
            self._envs.note_choices(self.index)

    @property
    def ale(self) -> AleInterface:
        """The methods of ale-py's `ALEInterface` that a lane has.

        They read lives, frame numbers, RAM, the RGB screen, action sets, modes and difficulties. The others, such as
        `act` and `reset_game`, raise AttributeError: the vector plays the game.
        """
        return AleInterface(cast(AleConsole, SimpleNamespace(emulated=self)))

    def ram(self, out: ByteArray | None = None) -> ByteArray:
        """The bytes of RAM, (128,) uint8, a copy, or `out` filled with them."""
        with self._lock:
            ram = np.frombuffer(bytearray(self._engine().ram(self.index)), np.uint8)
        return _copied(ram, out)

    def set_ram(self, index: int, value: int) -> None:
        """Write one byte of RAM; `index` 0..127, `value` 0..255.

        Raises:
            TypeError, ValueError: one of them is no such integer.
        """
        index, value = check_poke(index, value)
        with self._lock:
            self._engine().set_ram(self.index, index, value)
        for shadow in self.added.shadows:
            shadow.set_ram(index, value)

    def copy_to(self, core: NativeCore) -> None:
        """Give a core of the same game the state of this emulator. The core keeps its sticky actions and its limit.

        Raises:
            TypeError, ValueError: it is no such core, or it plays another game.
        """
        if not isinstance(core, NativeCore):
            raise TypeError(f"copy_to takes a core, such as atari.cores.NativeCore({self.game.id!r}), got {core!r:.80}")
        if core.game != self.game:
            raise ValueError(f"this environment plays {self.game.id}, but the core {core.game.id}; make one of this")
        with self._lock:
            state = self._engine().save_emulator(self.index)
        core.load(state)

    def record_moves(self) -> None:
        """Record what the console gets in each frame, until `take_moves`."""
        with self._lock:
            self._engine().record_moves(self.index)

    def take_moves(self) -> list[tuple[int, float]]:
        """The ALE action and its strength in each frame since `record_moves`, those of resets too."""
        with self._lock:
            return self._engine().take_moves(self.index)

    def screen_rgb(self, out: ByteArray | None = None) -> ByteArray:
        """The screen, (height, 160, 3) uint8, or `out` filled with it."""
        with self._lock:
            screen = self._engine().screen_rgb(self.index)
        return _copied(screen, out)

    render = screen_rgb

    def redraw(self, out: ByteArray | None = None) -> ByteArray:
        """The present RAM rendered by emulating a frame in a copy, (height, 160, 3) uint8, or `out` filled with it."""
        with self._lock:
            screen = self._engine().redraw(self.index)
        return _copied(screen, out)

    @property
    def slots(self) -> Sequence[_emulator.Write | None]:
        """The writes that were added; None where one was removed."""
        return self.added.slots

    def add_write(self, write: _emulator.Write, now: bool = False) -> int:
        """Apply a write at each later frame, and with `now` at once; returns its place in `slots`.

        Raises:
            TypeError, ValueError: it is no write, or there are `_emulator.MOST_WRITES` already.
        """
        _require_write(write)
        with self._lock:
            self._engine().add_write(self.index, write, bool(now))
            slot = self.added.add(write)
        for shadow in self.added.shadows:
            shadow.add_write(write, now)
        return slot

    def remove_write(self, write: _emulator.Write) -> None:
        """End a write, of a closed vector too; does nothing if the write does not exist."""
        _require_write(write)
        with self._lock:
            if not self._envs.closed:
                self._engine().remove_write(self.index, write)
            self.added.remove(write)
        for shadow in self.added.shadows:
            shadow.remove_write(write)

    def get_action_meanings(self) -> list[str]:
        """The names of the game's actions, in the order of the action space unless games differ."""
        return [action.name for action in self._envs.options.action_sets[self.index]]

    def checked(self, name: str, value: Any) -> int:
        """A mode or difficulty that the game has.

        Raises:
            TypeError, ValueError: the game does not have it.
        """
        of_game = choices(self.game, self._envs.options.players)
        offered = of_game[check_name("name", name, of_game)]
        if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
            raise TypeError(f"{name} must be an integer, got {value!r}")
        if value not in offered:
            raise ValueError(f"{self.game.id} has no {name} {value}; it has {', '.join(map(str, offered))}")
        return int(value)


def _require_write(write: Any) -> None:
    if not isinstance(write, _emulator.Write):
        raise TypeError(f"a write is a Freeze's or a Poke's, see atari.lab; got {write!r:.80}")


def _copied(array: ByteArray, out: ByteArray | None) -> ByteArray:
    if out is None:
        return array
    if not isinstance(out, np.ndarray) or out.shape != array.shape or out.dtype != np.uint8:
        raise ValueError(f"out must be a uint8 array of shape {array.shape}")
    out[...] = array
    return out
