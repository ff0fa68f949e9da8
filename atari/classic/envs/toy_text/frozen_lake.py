"""`FrozenLakeEnv`: cross a frozen lake with holes."""

from collections.abc import Sequence

from gymnasium.envs import toy_text
from gymnasium.envs.toy_text.frozen_lake import DOWN, LEFT, MAPS, RIGHT, UP, generate_random_map, is_valid

from atari.classic.envs.toy_text.adapted import ToyText

__all__ = ["DOWN", "LEFT", "MAPS", "RIGHT", "UP", "FrozenLakeEnv", "generate_random_map", "is_valid"]


class FrozenLakeEnv(ToyText):
    """Gymnasium's environment with the old interface.

    Args:
        desc: the rows of the map, of S (start), F (frozen), H (hole) and G (goal); None means `map_name`.
        map_name: "4x4" or "8x8"; None means a random map.
        is_slippery: two moves of three go sideways.

    Example:
        >>> from atari import classic
        >>> env = classic.envs.toy_text.FrozenLakeEnv(is_slippery=False)
        >>> env.reset(), env.step(1)[:3]
        (0, (4, 0, False))
    """

    original = toy_text.FrozenLakeEnv
    cracked_hole_img = elf_images = goal_img = start_img = None  # Gym's pictures; Gymnasium draws others

    def __init__(
        self, desc: Sequence[str] | None = None, map_name: str | None = "4x4", is_slippery: bool = True
    ) -> None:
        super().__init__(desc=desc, map_name=map_name, is_slippery=is_slippery)
