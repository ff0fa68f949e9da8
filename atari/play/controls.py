"""Keys and gamepads: what is held is an action, what is pressed may be a command."""

from collections.abc import Iterable
from enum import Enum
from typing import Any

from atari.actions import PLAYER_ACTIONS, Action

_ACTIONS = {(action.vertical, action.horizontal, action.fire): action for action in PLAYER_ACTIONS}
_AXIS_LIMIT = 0.5  # of how far a gamepad's stick goes

HELP = """\
arrows or W A S D   stick            space, ctrl     fire (gamepad: stick or cross, any button)
P                   pause            N               one frame, while paused
backspace (held)    go back in time  R               new game
F5, F9              save, load       F10             begin or end a video
F11                 full screen      M               sound on or off
escape              end"""


class Command(Enum):
    """What a key does that is not played."""

    QUIT = "escape"
    PAUSE = "p"
    FRAME = "n"
    NEW_GAME = "r"
    SAVE = "f5"
    LOAD = "f9"
    FILM = "f10"
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
    """What is held at the moment, from the events of pygame.

    Args:
        pygame: the module.
    """

    def __init__(self, pygame: Any) -> None:
        self._pygame = pygame
        self._held: set[str] = set()  # names of keys, and of what gamepads do
        self._commands = {command.value: command for command in Command}

    def handle(self, event: Any) -> Command | None:
        """Take note of an event; the command that it is, if it is one."""
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
            self._held.clear()  # what is let go of elsewhere is not told here
        return None

    @property
    def rewinding(self) -> bool:
        """Whether the key for going back in time is held."""
        return _REWIND in self._held

    def action(self, legal: Iterable[Action]) -> Action:
        """The action that is held, or what is left of it among the legal ones."""
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
