"""Every core keeps the contract of cores, `atari.testing.check_core`.

Beside it, `core_contract.py` has what our cores say in errors, and what they must do in some games.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import pytest
from env_tools import needs_new_ale_py

from atari.cores import AleCore, Core, NativeCore, PlainCore
from atari.testing import check_core

# Games of different kinds: paddles, PAL, a state that ale-py's own states leave out, rules with variables kept over a
# reset, a cartridge with RAM, resets that draw random numbers and play, actions that the game forbids.
GAMES = "breakout adventure qbert video_checkers klax double_dunk seaquest skiing journey_escape combat".split()


@pytest.mark.parametrize("game", GAMES)
def test_our_cores(game: str) -> None:
    """The native core beside the reference core."""
    check_core(partial(NativeCore, game), reference=partial(PlainCore, game))


@pytest.mark.parametrize("game", ["adventure", "klax", "double_dunk", "journey_escape"])
def test_the_reference_core(game: str) -> None:
    """It is slow, so it plays less, and fewer games: every check of the native core compares it, too."""
    check_core(partial(PlainCore, game), steps=16)


@needs_new_ale_py
def test_the_core_of_ale_py() -> None:
    """Every core that is made loads the ROM, which takes ale-py a tenth of a second, so this is one game."""
    check_core(partial(AleCore, "breakout"), reference=partial(NativeCore, "breakout"))


def test_a_core_passed_as_a_partial_and_as_a_function_is_the_same() -> None:
    make: Callable[..., Core] = lambda **options: NativeCore("pong", **options)  # noqa: E731
    check_core(make, steps=12)
    options: dict[str, Any] = {"color_averaging": True}
    check_core(partial(NativeCore, "pong", **options), steps=12)
