"""`Controls`: keys and gamepads as actions (while held) and commands (when pressed)."""

from collections.abc import Iterable
from enum import Enum
from typing import Any

from atari.actions import PLAYER_ACTIONS, Action

_ACTIONS = {(action.vertical, action.horizontal, action.fire): action for action in PLAYER_ACTIONS}
_AXIS_LIMIT = 0.5  # of a gamepad stick's full range

HELP = """\
arrows or W A S D   stick            space, ctrl     fire (gamepad: stick or cross, any button)
P                   pause            N               one frame, while paused
backspace (held)    go back in time  R               new game
F5, F9              save, load       F10             begin or end a video
F11                 full screen      M               sound on or off
escape              end"""


class Command(Enum):
    """The commands, by the key that gives them."""

    QUIT = "escape"
    PAUSE = "p"
    FRAME = "n"
    NEW_GAME = "r"
    SAVE = "f5"
    LOAD = "f9"
    VIDEO = "f10"
    FULL_SCREEN = "f11"
    MUTE = "m"


_STICK = {
    "up": ("up", "w", "vertical -1", "hat vertical -1"),
    "down": ("down", "s", "vertical 1", "hat vertical 1"),
    "left": ("left", "a", "horizontal -1", "hat horizontal -1"),
    "right": ("right", "d", "horizontal 1", "hat horizontal 1"),
    "fire": ("space", "left ctrl", "right ctrl"),
}
_REWIND = "backspace"


class Controls:
    """The keys, axes and buttons that are held, from pygame's events.

    Args:
        pygame: the module pygame.
    """

    def __init__(self, pygame: Any) -> None:
        self._pygame = pygame
        self._held: set[str] = set()  # names of keys, gamepad axes and buttons
        self._commands = {command.value: command for command in Command}

    def handle(self, event: Any) -> Command | None:
        """Update what is held by an event, and return the event's command, if it has one."""
        pygame = self._pygame
        if event.type == pygame.QUIT:
            return Command.QUIT
        if event.type == pygame.KEYDOWN:
            name = pygame.key.name(event.key)
            self._held.add(name)
            return self._commands.get(name)
        if event.type == pygame.KEYUP:
            self._held.discard(pygame.key.name(event.key))
        elif event.type == pygame.JOYAXISMOTION and event.axis in (0, 1):
            self._set_axis("horizontal" if event.axis == 0 else "vertical", event.value)
        elif event.type == pygame.JOYHATMOTION:
            self._set_axis("hat horizontal", event.value[0])
            self._set_axis("hat vertical", -event.value[1])
        elif event.type == pygame.JOYBUTTONDOWN:
            self._held.add(f"button {event.button}")
        elif event.type == pygame.JOYBUTTONUP:
            self._held.discard(f"button {event.button}")
        elif event.type == pygame.WINDOWFOCUSLOST:
            self._held.clear()  # no event comes for keys released in another window
        return None

    @property
    def rewinding(self) -> bool:
        """Whether the rewind key is held."""
        return _REWIND in self._held

    def action(self, legal: Iterable[Action]) -> Action:
        """Return the held action; if it is not legal, the legal one with the most of its directions and fire."""
        held = {direction for direction, names in _STICK.items() if self._held.intersection(names)}
        vertical = ("up" in held) - ("down" in held)
        horizontal = ("right" in held) - ("left" in held)
        fire = "fire" in held or any(name.startswith("button ") for name in self._held)
        wanted = [(vertical, horizontal, fire), (vertical, horizontal, False), (0, horizontal, fire)]
        wanted += [(vertical, 0, fire), (0, 0, fire), (0, horizontal, False), (vertical, 0, False), (0, 0, False)]
        allowed = tuple(legal)
        return next((_ACTIONS[motion] for motion in wanted if _ACTIONS[motion] in allowed), allowed[0])

    def _set_axis(self, name: str, value: float) -> None:
        self._held -= {f"{name} -1", f"{name} 1"}
        if abs(value) > _AXIS_LIMIT:
            self._held.add(f"{name} {1 if value > 0 else -1}")
