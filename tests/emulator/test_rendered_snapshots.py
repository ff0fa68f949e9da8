"""A snapshot has the logs of its last two frames in place of their pixels, also of frames that were rendered."""

import numpy as np
import pytest

from atari.cores import NativeCore

GAMES = ("breakout", "pitfall", "ms_pacman", "montezuma_revenge", "riverraid", "hero", "adventure", "skiing")


@pytest.mark.parametrize("game", GAMES)
def test_a_restored_core_has_both_framebuffers(game: str) -> None:
    core, other = NativeCore(game, seed=1), NativeCore(game, seed=2)
    for each in (core, other):
        each.reset()
    rng = np.random.default_rng(0)
    states = []
    for frame in range(400):
        if core.game_over:
            core.reset()
        core.act(int(rng.integers(18)))
        if rng.random() < 0.6:
            core.screen()
        if frame % 9 == 0:
            state = core.clone_state(include_rng=True)
            states.append((state, core.save(), core.screen()))
    for number in rng.permutation(len(states)).tolist():
        state, saved, screen = states[number]
        for each in (other, core):
            each.restore_state(state)
            if rng.random() < 0.5:  # once more, before anything is rendered again
                again = each.clone_state(include_rng=True)
                each.act(0)
                each.screen()
                each.restore_state(again)
            if rng.random() < 0.5:  # bytes have no logs
                each.act(0)
                each.screen()
                each.load(saved)
                each.restore_state(each.clone_state(include_rng=True))
            if rng.random() < 0.5:
                assert np.array_equal(each.screen(), screen)
            assert each.save() == saved
        for action in rng.integers(18, size=4).tolist():
            assert core.act(action) == other.act(action)
        assert np.array_equal(core.screen(), other.screen())
        assert core.save() == other.save()
