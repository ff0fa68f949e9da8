"""The eighteen joystick actions of the Arcade Learning Environment, by name and number."""

from enum import IntEnum


class Action(IntEnum):
    """An ALE action: what the stick and the fire button do during one frame.

    `RESET` is the console's switch. It appears in the starting sequences of some games; an agent cannot press it.
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
    RESET = 40

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


PLAYER_ACTIONS: tuple[Action, ...] = tuple(action for action in Action if action is not Action.RESET)
"""The 18 actions an agent can take, in ALE's order; the number of an action is its place here."""
