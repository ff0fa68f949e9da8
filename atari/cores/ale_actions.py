"""ale-py's enumeration of the actions."""

from enum import Enum

from atari.games import actions


class AleEnum(Enum):
    """A base of ale-py's enumerations, whose members are no numbers: they are true, and equal themselves alone."""

    __repr__ = Enum.__str__


class Action(AleEnum):
    """The actions with ale-py's members, which the methods under ale-py's names return.

    A member is accepted for its number, also by ale-py itself.

    Example:
        >>> import atari.ale_py as ale_py
        >>> list(ale_py.Action)[:2], bool(ale_py.Action.NOOP), ale_py.Action(1).value
        ([Action.NOOP, Action.FIRE], True, 1)
    """

    NOOP = actions.Action.NOOP.value
    FIRE = actions.Action.FIRE.value
    UP = actions.Action.UP.value
    RIGHT = actions.Action.RIGHT.value
    LEFT = actions.Action.LEFT.value
    DOWN = actions.Action.DOWN.value
    UPRIGHT = actions.Action.UPRIGHT.value
    UPLEFT = actions.Action.UPLEFT.value
    DOWNRIGHT = actions.Action.DOWNRIGHT.value
    DOWNLEFT = actions.Action.DOWNLEFT.value
    UPFIRE = actions.Action.UPFIRE.value
    RIGHTFIRE = actions.Action.RIGHTFIRE.value
    LEFTFIRE = actions.Action.LEFTFIRE.value
    DOWNFIRE = actions.Action.DOWNFIRE.value
    UPRIGHTFIRE = actions.Action.UPRIGHTFIRE.value
    UPLEFTFIRE = actions.Action.UPLEFTFIRE.value
    DOWNRIGHTFIRE = actions.Action.DOWNRIGHTFIRE.value
    DOWNLEFTFIRE = actions.Action.DOWNLEFTFIRE.value

    def __index__(self) -> int:
        return self.value
