"""The native core equals ale-py, frame by frame: RAM, framebuffer, sound, reward, lives, ends, counters.

`atari.cores.verify` is the test itself, which users can run too (`atari verify`); here it runs over some games with sticky
actions. `test_ale_goldens.py` compares all games with check sums of ale-py: the same run, all modes and difficulties,
fractional paddle movement, RAM overwritten at random, and snapshots.
"""

import numpy as np
import pytest
from conformance.ale_goldens import sticky_run

import atari
from atari.cores import AleCore, NativeCore
from atari.cores.verify import verify

GAMES = [game.id for game in atari.games.playable()]


@pytest.mark.parametrize("game", GAMES[::26])
def test_six_hundred_frames_with_sticky_actions(game: str) -> None:
    assert verify(sticky_run(game)) is None


@pytest.mark.parametrize("game", ["pong", "adventure", "ms_pacman", "seaquest"])
def test_color_averaging(game: str) -> None:
    native, ale = (core(game, color_averaging=True, repeat_action_probability=0.0) for core in (NativeCore, AleCore))
    for core in (native, ale):
        core.reset()
    actions = [int(action) for action in np.random.default_rng(6).choice(native.game.minimal_actions, 60)]
    for action in actions:
        native.act(action)
        ale.act(action)
        for name in ("screen", "screen_rgb", "screen_grayscale"):
            assert np.array_equal(getattr(native, name)(), getattr(ale, name)()), name
