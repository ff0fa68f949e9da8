"""`Journal`: the calls that an emulator received since a known point, to be replayed.

ale-py's own states leave out part of the machine: the framebuffer, the held (sticky) action, the sound generator, the
TIA's unfinished frame. A journal is complete: it has a starting point from which ale-py is exact (a fresh load, or a
state directly before a reset) and every call since. A replay gives the same machine.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field

from atari.base.validation import check_action, check_poke, check_strength
from atari.games.actions import PLAYER_ACTIONS

# Events: one byte for an action of full strength (0..17), else a code and its arguments.
_ACT_WITH_STRENGTH = 0x40
_RESET = 0x41
_POKE = 0x42
_SET_MODE = 0x43
_SET_DIFFICULTY = 0x44
_STRENGTH = struct.Struct("<f")
_CHOICE = struct.Struct("<i")


@dataclass
class Journal:
    """The calls since `base`, a serialised ale-py state with generators (empty: the game as loaded)."""

    base: bytes = b""
    events: bytearray = field(default_factory=bytearray)

    def act(self, action: int, strength: float) -> None:
        """Append a call of `act`."""
        if strength == 1.0:
            self.events.append(action)
        else:
            self.events += bytes((_ACT_WITH_STRENGTH, action)) + _STRENGTH.pack(strength)

    def reset(self) -> None:
        """Append a reset."""
        self.events.append(_RESET)

    def poke(self, index: int, value: int) -> None:
        """Append a write to RAM."""
        self.events += bytes((_POKE, index, value))

    def set_mode(self, mode: int) -> None:
        """Append a change of the mode."""
        self.events += bytes((_SET_MODE,)) + _CHOICE.pack(mode)

    def set_difficulty(self, difficulty: int) -> None:
        """Append a change of the difficulty."""
        self.events += bytes((_SET_DIFFICULTY,)) + _CHOICE.pack(difficulty)

    def check(self) -> None:
        """Check every event; events of a file may be damaged.

        Raises:
            ValueError: an event is unknown, cut short, or has an argument out of range.
        """
        try:
            for event, first, second in self.replay():
                if event == "act":
                    check_action(first)
                    check_strength(second)
                elif event == "poke":
                    check_poke(first, int(second))
        except (IndexError, struct.error):
            raise ValueError("the snapshot's journal ends within an event") from None

    def replay(self) -> Iterator[tuple[str, int, float]]:
        """The events in order: ("act", action, strength), ("reset", 0, 0), ("poke", index, value), ("mode", mode, 0) or
        ("difficulty", difficulty, 0).

        Raises:
            ValueError: an event is unknown.
        """
        events, i = self.events, 0
        while i < len(events):
            code = events[i]
            if code == _RESET:
                yield "reset", 0, 0.0
                i += 1
            elif code == _POKE:
                yield "poke", events[i + 1], events[i + 2]
                i += 3
            elif code == _ACT_WITH_STRENGTH:
                yield "act", events[i + 1], _STRENGTH.unpack_from(events, i + 2)[0]
                i += 6
            elif code in (_SET_MODE, _SET_DIFFICULTY):
                yield "mode" if code == _SET_MODE else "difficulty", _CHOICE.unpack_from(events, i + 1)[0], 0.0
                i += 5
            elif code < len(PLAYER_ACTIONS):
                yield "act", code, 1.0
                i += 1
            else:
                raise ValueError(f"the snapshot's journal holds an unknown event, {code:#04x}")
