"""The contracts of this package as checks, for authors of cores, wrappers, vectors, policies and game files.

Each function plays, and raises `ContractError`, an `AssertionError`, with a message at the first fault.
"""

from atari.testing.contract import ContractError
from atari.testing.core import check_core
from atari.testing.env import check_env
from atari.testing.game_file import check_game_file
from atari.testing.policy import check_policy
from atari.testing.vector import check_vector

__all__ = ["ContractError", "check_core", "check_env", "check_game_file", "check_policy", "check_vector"]
