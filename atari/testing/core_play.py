"""Functions of the checks of cores: make a core, play it, and read its visible state."""

import random
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from atari.cores import Core
from atari.testing.contract import broken_by, require, require_same

MakeCore = Callable[..., Core]

ARRAYS = ("ram", "screen", "screen_rgb", "screen_grayscale", "audio")
NUMBERS = ("lives", "game_over", "truncated", "frame_number", "episode_frame_number")
NOOP, FIRE = 0, 1


def made(make: MakeCore, **options: Any) -> Core:
    """A core after its first reset."""
    core = new(make, **options)
    core.reset()
    return core


def new(make: MakeCore, **options: Any) -> Core:
    """A core before its first reset."""
    given = ", ".join(f"{name}={value!r}" for name, value in options.items())
    with broken_by(f"make({given})"):
        return make(**options)


def visible(core: Core) -> dict[str, Any]:
    """The visible state of a core."""
    return {name: getattr(core, name)() for name in ARRAYS} | {name: getattr(core, name) for name in NUMBERS}


def play(core: Core, actions: Iterable[int]) -> list[dict[str, Any]]:
    """The reward and the visible state of a core after each action."""
    return [{"reward": core.act(action), **visible(core)} for action in actions]


def players_of(core: Core) -> int:
    """The number of players: an attribute of cores for several players."""
    return getattr(core, "players", 1)


def some_actions(core: Core, count: int, seed: int = 0) -> list[int]:
    """Random actions of the core's game."""
    return [int(one) for one in random.Random(seed).choices(core.game.minimal_actions or range(18), k=count)]


@contextmanager
def unchanged(core: Core, call: str) -> Iterator[None]:
    """Check that the block does not change the core, including its hidden state."""
    seen, saved = visible(core), core.snapshot()
    yield
    require_same(seen, visible(core), "the core", f"{call} must change nothing")
    require(core.snapshot() == saved, f"{call} must change nothing, but the snapshot of the core is another one")


def shape_of(core: Core, array: str) -> tuple[int, ...]:
    """The shape of an array of `ARRAYS`."""
    shapes = {"ram": (128,), "audio": (512,), "screen_rgb": (*core.game.screen.shape, 3)}
    return shapes.get(array, core.game.screen.shape)
