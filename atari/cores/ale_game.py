"""`AleGame`: a loaded game that closes, opens again and takes settings like a game of ale-py."""

import copy
from contextlib import suppress
from os import PathLike
from typing import Any

from atari.cores import writes
from atari.cores.ale_interface import AleSettings
from atari.cores.assigned_ale import AssignedAle
from atari.cores.core import Core
from atari.games.game import Game
from atari.games.interventions import Intervention


class AleGame:
    """A core with the settings that its next load applies. After `close`, `reopen` continues from the same state.

    Args:
        kind: the class of the core.
        game: the game.
        settings: the first settings; the core is made with them.
        mode, difficulty: the numbers to play after each load; None is the game's default.
        rom: path of the ROM file; None searches.
        interventions: changes of the game.

    Raises:
        TypeError, ValueError, FileNotFoundError: see the core.
    """

    core: Core
    """The core that is played and read: the emulator core, or an `AssignedAle` around it.

    Another object of the same kind may replace the emulator core at a load, and after `make_sound`.
    """

    def __init__(
        self,
        kind: Any,
        game: Game,
        settings: AleSettings,
        *,
        mode: int | None,
        difficulty: int | None,
        rom: str | PathLike[str] | None,
        interventions: tuple[Intervention, ...],
    ) -> None:
        self.game = game
        self.ale_settings = settings
        self.rom = rom
        self.core_options = settings.core_options()
        """The settings that the core was made with."""
        self._kind = kind
        self._arguments: dict[str, Any] = {
            "mode": mode,
            "difficulty": difficulty,
            "rom": rom,
            "interventions": interventions,
        }
        self._closed_state: Any = None
        self.core = self._make_core()

    @property
    def emulated(self) -> Core:
        """The emulator core."""
        return self.core.emulated if isinstance(self.core, AssignedAle) else self.core

    @emulated.setter
    def emulated(self, core: Core) -> None:
        if isinstance(self.core, AssignedAle):
            self.core.emulated = core
        else:
            self.core = core

    def play_through(self, ale: Any) -> None:
        """Play and read the game through an object with the methods of ale-py's `ALEInterface`; None ends this.

        Raises:
            TypeError: the object cannot play.
        """
        forwards = hasattr(type(ale), "__getattr__")  # a look-up would run the user's code
        if ale is not None and not forwards and not callable(getattr(ale, "act", None)):
            raise TypeError(
                f"ale must be an object with the methods of ale-py's ALEInterface, and {ale!r} has no method act; "
                "wrap the former env.ale"
            )
        self.core = self.emulated if ale is None else AssignedAle(self.emulated, ale)

    def game_was_reset(self) -> None:
        """Note that the emulator was reset."""

    @property
    def closed(self) -> bool:
        """Whether `close` was called after the last `reopen`."""
        return self._closed_state is not None

    def load_game(self) -> None:
        """Load the game again: with the seed and the settings of `ale_settings`, and with the first mode.

        Raises:
            RuntimeError: a setting was changed while a replay is recorded.
        """
        if self.ale_settings.stale:
            self._apply_settings()
        self.core.seed(self.ale_settings.seed())

    def make_sound(self) -> None:
        """Switch the emulator's sound on. `core` becomes another object, in the same state."""
        self.emulated = self.emulated.with_sound()

    def close(self) -> None:
        """Release the emulator."""
        if self._closed_state is None:
            with suppress(RuntimeError):  # the core was closed already
                self._closed_state = self.core.clone_state(include_rng=True)
        self.core.close()

    def reopen(self) -> None:
        """Continue from the state at `close`."""
        sound = self.core.sound
        self._replace_core()
        if sound:
            self.make_sound()
        self.core.restore_state(self._closed_state)
        self._closed_state = None

    def settings_state(self) -> dict[str, Any]:
        """The settings, for `restore_settings`, with the core's settings and the writes of `Freeze` and `Poke`."""
        return {
            "ale_settings": copy.deepcopy(self.ale_settings),
            "core_options": self.core_options,
            "sound": self.core.sound,
            "mode": self.core.mode,
            "difficulty": self.core.difficulty,
            "writes": writes.definitions(writes.slots(self.core)),
        }

    def restore_settings(self, state: dict[str, Any]) -> None:
        """Restore a result of `settings_state` of a game with the same arguments; other keys are ignored.

        Raises:
            ValueError: it is none; nothing has changed.
        """
        if missing := [name for name in self.settings_state() if name not in state]:
            raise ValueError(f"restore_settings takes a result of settings_state, and {missing[0]!r} is missing")
        self.ale_settings = state["ale_settings"]
        if self.core_options != state["core_options"]:
            self.core_options = state["core_options"]
            self.emulated = self._make_core()
        if state["sound"]:
            self.make_sound()
        if state["mode"] != self.core.mode:
            self.core.set_mode(state["mode"])
        if state["difficulty"] != self.core.difficulty:
            self.core.set_difficulty(state["difficulty"])
        writes.restore(self.core, state["writes"])

    def _make_core(self) -> Core:
        return self._kind(self.game, seed=self.ale_settings.seed(), **self._arguments, **self.core_options)

    def _replace_core(self) -> None:
        if type(self.emulated) is not self._kind:
            raise RuntimeError("a replay of this environment is being recorded; close the recorder first")
        self.emulated.close()
        self.emulated = self._make_core()

    def _apply_settings(self) -> None:
        """Apply the settings made since the last load, and the mode and difficulty of a load."""
        options, before = self.ale_settings.core_options(), self.core_options
        choices = self.ale_settings.choices
        mode, difficulty = ({**self._arguments, **choices}[name] for name in ("mode", "difficulty"))
        difficulty = difficulty or 0
        if options != before or difficulty not in self.game.difficulties:  # backgammon's list lacks its default
            self.core_options = options
            added = writes.slots(self.core)
            state = self.core.save() if added else None  # type: ignore[attr-defined]  # with which writes are done
            try:
                self._replace_core()
            except RuntimeError:
                self.core_options = before
                raise
            if added:
                self.core.writes = added  # type: ignore[attr-defined]
                self.core.load(state)  # type: ignore[attr-defined]
            chosen = bool(choices)
        else:
            chosen = True
        if chosen:
            self.core.set_mode(self.game.default_mode if mode is None else mode)
            if difficulty in self.game.difficulties:
                self.core.set_difficulty(difficulty)
        self.ale_settings.stale = False
