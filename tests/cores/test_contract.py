"""Every core keeps the contract of cores, `atari.testing.check_core`.

Beside it, `core_contract.py` has what our cores say in errors, and what they must do in some games.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import core_tools
import pytest
from env_tools import needs_new_ale_py
from own_process import run_program

from atari.cores import CORES, AleCore, Core, NativeCore, PlainCore
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


def test_snapshots_continue_exactly_in_another_process(tmp_path: Path) -> None:
    expected = {}
    for name in CORES:
        saved, expected[name] = core_tools.rest_of_a_game(name)
        (tmp_path / name).write_bytes(saved)
    printed = run_program(f"""
        import sys
        from pathlib import Path
        sys.path.append({str(Path(core_tools.__file__).parent)!r})
        from core_tools import rest_of_a_game
        for file in map(Path({str(tmp_path)!r}).joinpath, {list(CORES)}):
            print(file.name, rest_of_a_game(file.name, file.read_bytes())[1])
    """)
    assert printed == "".join(f"{name} {digest}\n" for name, digest in expected.items())
