"""Helpers of the contracts of cores: make a core, play it, and read its visible state."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from atari.cores import AleCore, Core, NativeCore
from atari.testing.core_play import ARRAYS, some_actions

__all__ = ["ARRAYS", "Maker", "play", "some_actions", "unchanged", "visible"]


class Maker:
    """The base of a core's test class, which sets the class of the core."""

    core_type: type[AleCore] | type[NativeCore]

    def make(self, game: str = "breakout", *, reset: bool = True, **options: Any) -> Core:
        core = self.core_type(game, **options)
        if reset:
            core.reset()
        return core


def visible(core: Core) -> tuple[Any, ...]:
    """The visible state of a core."""
    arrays = tuple(getattr(core, name)().tobytes() for name in ARRAYS)
    return (*arrays, core.lives, core.game_over, core.truncated, core.frame_number, core.episode_frame_number)


def play(core: Core, actions: Iterable[int]) -> list[tuple[Any, ...]]:
    """The visible state of a core after each action, with the reward."""
    return [(core.act(action), *visible(core)) for action in actions]


@contextmanager
def unchanged(core: Core) -> Iterator[None]:
    """Check that the block, which is expected to raise, leaves the core unchanged, including its hidden state."""
    seen, saved = visible(core), core.snapshot()
    yield
    assert visible(core) == seen
    assert core.snapshot() == saved
