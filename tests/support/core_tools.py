"""Helpers of the contracts of cores: make a core, play it, and read its visible state."""

import hashlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from atari.cores import CORES, AleCore, Core, NativeCore
from atari.testing.core_play import ARRAYS, some_actions

__all__ = ["ARRAYS", "Maker", "play", "rest_of_a_game", "some_actions", "unchanged", "visible"]


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


def rest_of_a_game(name: str, saved: bytes | None = None) -> tuple[bytes, str]:
    """A snapshot of a core of this name, or `saved`, which it restores; and the digest of what it plays from there."""
    core: Any = CORES[name]("space_invaders", seed=8, sound=True, mode=2, frame_skip=2)
    if saved is None:
        core.reset()
        play(core, some_actions(core, 50))
        saved = core.snapshot()
    else:
        core.restore(saved)
    return saved, hashlib.sha256(repr(play(core, some_actions(core, 40, seed=1))).encode()).hexdigest()


@contextmanager
def unchanged(core: Core) -> Iterator[None]:
    """Check that the block, which is expected to raise, leaves the core unchanged, including its hidden state."""
    seen, saved = visible(core), core.snapshot()
    yield
    assert visible(core) == seen
    assert core.snapshot() == saved
