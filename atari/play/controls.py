"""`Controls`: keys and gamepads as actions (while held) and commands (when pressed); `first_screen` names the keys."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import Enum
from typing import Any

from atari.games.actions import Action, nearest_action
from atari.games.game import Game

_AXIS_LIMIT = 0.5  # a part of a gamepad stick's full range

_ONE_PLAYER = """\
arrows or W A S D   stick (gamepad: stick or cross)
space, ctrl         fire (gamepad: any button)"""
_SEVERAL_PLAYERS = """\
first player        W A S D; fire: space, left shift
second player       arrows; fire: right ctrl, right shift, return
gamepads            stick or cross, any button; to players without keys first"""
_PADDLES = "paddles             up turns right, and down turns left"
_COMMANDS = """\
P                   pause
N                   one frame, while paused
+, -                faster, slower
backspace (held)    go back in time
R                   new game
F5, F9              save, load
F10                 begin or end a video
F11                 full screen
M                   sound on or off
I, then a number    interventions
H or F1             help
escape              end"""

HELP = f"{_ONE_PLAYER}\n{_PADDLES}\n{_COMMANDS}"
"""The keys of one player."""
HELP_SEVERAL = f"{_SEVERAL_PLAYERS}\n{_PADDLES}\n{_COMMANDS}"
"""The keys of two players."""


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
    HELP = "h"
    INTERVENTIONS = "i"
    FASTER = "+"
    SLOWER = "-"


_COMMAND_KEYS = {
    **{command.value: command for command in Command},
    "f1": Command.HELP,
    "=": Command.FASTER,  # the key of + where + needs shift
    "[+]": Command.FASTER,
    "[-]": Command.SLOWER,
}
_REWIND = "backspace"
_GAMEPAD = {
    "up": ("vertical -1", "hat vertical -1"),
    "down": ("vertical 1", "hat vertical 1"),
    "left": ("horizontal -1", "hat horizontal -1"),
    "right": ("horizontal 1", "hat horizontal 1"),
}
Keys = Mapping[str, tuple[str, ...]]
"""The keys of a player, by direction and for fire."""

ALL_KEYS: Keys = {
    "up": ("up", "w"),
    "down": ("down", "s"),
    "left": ("left", "a"),
    "right": ("right", "d"),
    "fire": ("space", "left ctrl", "right ctrl"),
}
LEFT_KEYS: Keys = {
    "up": ("w",), "down": ("s",), "left": ("a",), "right": ("d",), "fire": ("space", "left shift"),
}  # fmt: skip
RIGHT_KEYS: Keys = {
    "up": ("up",), "down": ("down",), "left": ("left",), "right": ("right",),
    "fire": ("right ctrl", "right shift", "return"),
}  # fmt: skip
NO_KEYS: Keys = {}

_STICK = {Action.UP: ("up",), Action.DOWN: ("down",), Action.LEFT: ("left",), Action.RIGHT: ("right",)}
_PADDLE = {Action.RIGHT: ("right", "up"), Action.LEFT: ("left", "down")}


SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
"""The speeds that two keys choose; 1 is the console's."""


class Speed:
    """The number of frames that each tick plays, where ticks have the console's rate."""

    def __init__(self) -> None:
        self._index, self._due = SPEEDS.index(1.0), 0.0

    def __str__(self) -> str:
        return f"speed {SPEEDS[self._index]:g}"

    @property
    def usual(self) -> bool:
        """Whether it is the console's speed, at which sound is played."""
        return SPEEDS[self._index] == 1

    def change(self, command: Command | None) -> bool:
        """Run FASTER or SLOWER, and return whether the command is one of them."""
        step = {Command.FASTER: 1, Command.SLOWER: -1}.get(command, 0) if command else 0
        self._index = min(max(self._index + step, 0), len(SPEEDS) - 1)
        return step != 0

    def frames(self) -> int:
        """The frames of the next tick."""
        self._due += SPEEDS[self._index]
        frames = int(self._due)
        self._due -= frames
        return frames


def command_of(pygame: Any, event: Any) -> Command | None:
    """The command of an event, or None."""
    if event.type == pygame.QUIT:
        return Command.QUIT
    return _COMMAND_KEYS.get(pygame.key.name(event.key)) if event.type == pygame.KEYDOWN else None


class Controls:
    """The keys, axes and buttons that one player holds, from pygame's events.

    Args:
        pygame: the module pygame.
        keys: the player's keys.
        paddle: whether the player turns a paddle. It has one axis: up is right, and down is left.
    """

    def __init__(self, pygame: Any, keys: Keys = ALL_KEYS, *, paddle: bool = False) -> None:
        self._pygame, self._paddle = pygame, paddle
        directions = ("up", "down", "left", "right", "fire")
        self._names = {name: {*keys.get(name, ()), *_GAMEPAD.get(name, ())} for name in directions}
        self._held: set[str] = set()  # names of keys, gamepad axes and buttons

    def handle(self, event: Any) -> Command | None:
        """Record a pressed or released key, axis or button, and return the event's command, or None."""
        pygame = self._pygame
        if event.type == pygame.KEYDOWN:
            self._held.add(pygame.key.name(event.key))
        elif event.type == pygame.KEYUP:
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
        return command_of(pygame, event)

    def digit(self, event: Any) -> int | None:
        """The digit whose key an event presses, or None."""
        name = self._pygame.key.name(event.key) if event.type == self._pygame.KEYDOWN else ""
        return int(name) if name in tuple("0123456789") else None

    def presses(self, event: Any) -> bool:
        """Whether an event presses a key or a button, or moves the stick or the cross of a gamepad."""
        pygame = self._pygame
        if event.type == pygame.JOYAXISMOTION:
            return event.axis in (0, 1) and abs(event.value) > _AXIS_LIMIT
        return event.type in (pygame.KEYDOWN, pygame.JOYBUTTONDOWN, pygame.JOYHATMOTION)

    @property
    def rewinding(self) -> bool:
        """Whether the rewind key is held."""
        return _REWIND in self._held

    def action(self, legal: Iterable[Action]) -> Action:
        """Return the held action; if it is not legal, the legal one with the most of its directions and fire."""
        held = {direction for direction, names in self._names.items() if self._held.intersection(names)}
        vertical = ("up" in held) - ("down" in held)
        horizontal = ("right" in held) - ("left" in held)
        if self._paddle:
            vertical, horizontal = 0, (horizontal + vertical > 0) - (horizontal + vertical < 0)
        fire = "fire" in held or any(name.startswith("button ") for name in self._held)
        allowed = tuple(legal)
        found = nearest_action(vertical, horizontal, fire, allowed)
        return allowed[0] if found is None else found

    def release(self) -> None:
        """Release all keys, axes and buttons."""
        self._held.clear()

    def _set_axis(self, name: str, value: float) -> None:
        self._held -= {f"{name} -1", f"{name} 1"}
        if abs(value) > _AXIS_LIMIT:
            self._held.add(f"{name} {1 if value > 0 else -1}")


class SharedControls(Controls):
    """The controls of one or several players: two at the keyboard, and a gamepad for each.

    Gamepads go to the players in the order in which they are found, first to players without keys. If a gamepad is
    removed, its player gets the next one. Without a free player, a gamepad does nothing.

    Args:
        pygame: the module pygame.
        players: the numbers of the human players, from 1; a single person has all keys and all gamepads.
        paddles: whether the players turn paddles, see `Controls`.
    """

    def __init__(self, pygame: Any, players: Sequence[int], *, paddles: bool = False) -> None:
        super().__init__(pygame, NO_KEYS)
        layouts = [ALL_KEYS] if len(players) == 1 else [LEFT_KEYS, RIGHT_KEYS, NO_KEYS, NO_KEYS]
        self.layouts = dict(zip(players, layouts, strict=False))
        """The keys of each human player."""
        self._seats = {player: Controls(pygame, keys, paddle=paddles) for player, keys in self.layouts.items()}
        self._gamepads: dict[int, int] = {}  # the player of each gamepad
        self.help = HELP if len(players) == 1 else HELP_SEVERAL

    def handle(self, event: Any) -> Command | None:
        """Pass a gamepad's event to its player, or another event to all players, and return the event's command."""
        gamepad = getattr(event, "instance_id", None)
        if gamepad is None:
            for seat in self._seats.values():
                seat.handle(event)
            return super().handle(event)
        player = self._gamepads.get(gamepad)
        if player is not None:
            self._seats[player].handle(event)
            if event.type == self._pygame.JOYDEVICEREMOVED:
                self._seats[player].release()
                del self._gamepads[gamepad]
        return None

    def add_gamepad(self, gamepad: int) -> str:
        """Give a gamepad, by its instance id, to a player, and return a message that names the player."""
        if gamepad in self._gamepads:
            return ""
        order = [*list(self._seats)[2:], *list(self._seats)[:2]]
        free = [player for player in order if player not in self._gamepads.values()]
        if len(self._seats) > 1 and not free:
            return "every player has a gamepad"
        self._gamepads[gamepad] = player = (free or order)[0]
        return f"gamepad: player {player}"

    @property
    def note(self) -> str:
        """A message that names the players with neither keys nor a gamepad."""
        waiting = [str(player) for player in list(self._seats)[2:] if player not in self._gamepads.values()]
        return f"player {' and '.join(waiting)}: connect a gamepad" if waiting else ""

    def actions(self, legal: Iterable[Action]) -> list[Action]:
        """The action of each player, see `Controls.action`."""
        allowed = tuple(legal)
        return [seat.action(allowed) for seat in self._seats.values()]


def first_screen(game: Game, actions: Sequence[Action], layouts: Mapping[int, Keys], interventions: int = 0) -> str:
    """The lines over the first screen.

    Args:
        game: the game.
        actions: its minimal actions. Their directions and FIRE are what the game uses; a paddle turns right and left.
        layouts: the keys of each human player, see `SharedControls`.
        interventions: the number of interventions that a key switches.
    """
    lines = [game.title]
    for player, keys in layouts.items():
        used = [*_used(keys, actions, game.controllers.paddles)] if keys else ["a gamepad"]
        lines += used if len(layouts) == 1 else [f"player {player}   {'   '.join(used)}"]
    if interventions:
        lines.append(f"I: {interventions} interventions, which change the game")
    return "\n".join([*lines, "press a key to begin, or H to see all keys"])


def _used(keys: Keys, actions: Sequence[Action], paddles: bool) -> Iterator[str]:
    """The keys that a player of a game uses, with their actions."""
    for direction, sides in (_PADDLE if paddles else _STICK).items():
        if paddles or any(direction.name in action.name for action in actions):
            with_fire = Action[f"{direction.name}FIRE"]
            only_with_fire = direction not in actions and with_fire in actions
            names = _names([key for side in sides for key in keys[side]])
            yield f"{names} with FIRE: {with_fire.name}" if only_with_fire else f"{names}: {direction.name}"
    fires = any(action.fire for action in actions)
    yield f"{_names(keys['fire'])}: FIRE" if fires else "this game does not use FIRE"


def _names(keys: Sequence[str]) -> str:
    arrows = ("up", "down", "left", "right")
    return ", ".join(f"{key} arrow" if key in arrows else key.upper() if len(key) == 1 else key for key in keys)
