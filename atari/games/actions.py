"""The eighteen joystick actions of the Arcade Learning Environment, action spaces, and continuous actions."""

from collections.abc import Sequence
from enum import IntEnum
from typing import Any, Literal

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from atari.base.typed_table import check_type


class Action(IntEnum):
    """An ALE action: what the stick and the fire button do during one frame.

    Example:
        >>> import atari
        >>> atari.Action.UPRIGHTFIRE.horizontal, atari.Action.UPRIGHTFIRE.vertical, atari.Action.UPRIGHTFIRE.fire
        (1, 1, True)
        >>> [action.name for action in atari.games["breakout"].minimal_actions]
        ['NOOP', 'FIRE', 'RIGHT', 'LEFT']
    """

    NOOP = 0
    FIRE = 1
    UP = 2
    RIGHT = 3
    LEFT = 4
    DOWN = 5
    UPRIGHT = 6
    UPLEFT = 7
    DOWNRIGHT = 8
    DOWNLEFT = 9
    UPFIRE = 10
    RIGHTFIRE = 11
    LEFTFIRE = 12
    DOWNFIRE = 13
    UPRIGHTFIRE = 14
    UPLEFTFIRE = 15
    DOWNRIGHTFIRE = 16
    DOWNLEFTFIRE = 17

    @property
    def vertical(self) -> int:
        """1 for up, -1 for down, 0 for neither."""
        return ("UP" in self.name) - ("DOWN" in self.name)

    @property
    def horizontal(self) -> int:
        """1 for right, -1 for left, 0 for neither."""
        return ("RIGHT" in self.name) - ("LEFT" in self.name)

    @property
    def fire(self) -> bool:
        """Whether the fire button is pressed."""
        return "FIRE" in self.name


class Switch(IntEnum):
    """A switch of the console in the starting sequence of a game, with ALE's number. An agent cannot press it.

    Example:
        >>> import atari
        >>> atari.games["keystone_kapers"].starting_actions
        (<Switch.RESET: 40>,)
    """

    RESET = 40


PLAYER_ACTIONS: tuple[Action, ...] = tuple(Action)
"""The 18 actions in ALE's order; the number of an action is its index here."""


def make_action_space(actions: Sequence[Action], continuous: bool) -> spaces.Space[Any]:
    """The indices of `actions`, or (radius, angle, fire), three float32."""
    if continuous:
        low, high = np.array([0, -np.pi, 0], np.float32), np.array([1, np.pi, 1], np.float32)
        return spaces.Box(low, high, dtype=np.float32)
    return spaces.Discrete(len(actions))


def actions_by_motion() -> NDArray[np.int64]:
    """The numbers of the actions, (3, 3, 2): by the stick's 1 + horizontal and 1 + vertical position, and by fire."""
    numbers = np.zeros((3, 3, 2), np.int64)
    for action in Action:
        numbers[1 + action.horizontal, 1 + action.vertical, int(action.fire)] = action
    return numbers


_ACTIONS_BY_MOTION = actions_by_motion()


def nearest_action(vertical: int, horizontal: int, fire: bool, legal: Sequence[Action]) -> Action | None:
    """The legal action with the most of a stick's position, -1..1 each, and of the button; None if none has any."""
    wanted = [(vertical, horizontal, fire), (vertical, horizontal, False), (0, horizontal, fire), (vertical, 0, fire)]
    wanted += [(0, 0, fire), (0, horizontal, False), (vertical, 0, False), (0, 0, False)]
    actions = (Action(_ACTIONS_BY_MOTION[1 + x, 1 + y, int(pressed)]) for y, x, pressed in wanted)
    return next((action for action in actions if action in legal), None)


def in_continuous_space(radius: Any, angle: Any, fire: Any) -> Any:
    """Whether a continuous action is in its space: radius and fire 0..1, angle -pi..pi; NaN is not."""
    pi = np.float32(np.pi)
    return (radius >= 0) & (radius <= 1) & (angle >= -pi) & (angle <= pi) & (fire >= 0) & (fire <= 1)


def joystick_action(radius: Any, angle: Any, fire: Any, threshold: np.float32) -> Any:
    """The ALE action number of a continuous action (Farebrother and Castro 2024, "CALE"); its strength is the radius.

    Args:
        radius, angle, fire: float32 scalars or arrays of one shape. The arithmetic is float32, as in ALE.
        threshold: the least deflection of the stick, or pressure on fire, that counts.

    Returns:
        int64, of the shape of the arguments.
    """
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    horizontal = np.int64(x > threshold) - np.int64(x < -threshold)
    vertical = np.int64(y > threshold) - np.int64(y < -threshold)
    return _ACTIONS_BY_MOTION[1 + horizontal, 1 + vertical, np.int64(fire > threshold)]


def parse_actions(names: "Literal['all'] | list[str]") -> tuple[Action, ...]:
    """The actions with these names; "all" means all eighteen."""
    if names != "all" and isinstance(names, list) and not Switch.__members__.keys().isdisjoint(map(str, names)):
        raise ValueError(f"[actions] {', '.join(Switch.__members__)} can only be in starting")
    return tuple(Action(action) for action in parse_starting_actions(names))


def parse_starting_actions(names: "Literal['all'] | list[str]") -> tuple[Action | Switch, ...]:
    """The actions with these names, and the switches of the console."""
    if names == "all":
        return PLAYER_ACTIONS
    check_type(names, "[actions] a list of actions", tuple[str, ...])
    known: dict[str, Action | Switch] = {**Action.__members__, **Switch.__members__}
    unknown = [name for name in names if name not in known]
    if unknown:
        raise ValueError(f"[actions] unknown action {unknown[0]!r}")
    return tuple(known[name] for name in names)
