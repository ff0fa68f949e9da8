"""The text over the first screen: the keys that a game uses, and the action that each plays."""

from collections.abc import Iterator, Mapping, Sequence

from atari.games.actions import Action
from atari.games.game import Game
from atari.play.controls import Keys

_STICK = {Action.UP: ("up",), Action.DOWN: ("down",), Action.LEFT: ("left",), Action.RIGHT: ("right",)}
_PADDLE = {Action.RIGHT: ("right", "up"), Action.LEFT: ("left", "down")}


def first_screen(game: Game, actions: Sequence[Action], layouts: Mapping[int, Keys]) -> str:
    """The lines over the first screen.

    Args:
        game: the game.
        actions: its minimal actions. Their directions and FIRE are what the game uses; a paddle turns right and left.
        layouts: the keys of each human player, see `SharedControls`.
    """
    lines = [game.title]
    for player, keys in layouts.items():
        used = [*_used(keys, actions, game.controllers.paddles)] if keys else ["a gamepad"]
        lines += used if len(layouts) == 1 else [f"player {player}   {'   '.join(used)}"]
    return "\n".join([*lines, "press a key to begin, or H to see all keys"])


def _used(keys: Keys, actions: Sequence[Action], paddles: bool) -> Iterator[str]:
    """The keys that a player of a game uses, with their actions."""
    for direction, sides in (_PADDLE if paddles else _STICK).items():
        if paddles or any(_points(action, direction) for action in actions):
            with_fire = Action[f"{direction.name}FIRE"]
            only_with_fire = direction not in actions and with_fire in actions
            names = _names([key for side in sides for key in keys[side]])
            yield f"{names} with FIRE: {with_fire.name}" if only_with_fire else f"{names}: {direction.name}"
    fires = any(action.fire for action in actions)
    yield f"{_names(keys['fire'])}: FIRE" if fires else "this game does not use FIRE"


def _points(action: Action, direction: Action) -> bool:
    """Whether an action pushes the stick in a direction, diagonally too."""
    return direction.name in action.name


def _names(keys: Sequence[str]) -> str:
    arrows = ("up", "down", "left", "right")
    return ", ".join(f"{key} arrow" if key in arrows else key.upper() if len(key) == 1 else key for key in keys)
