"""`AtariEnv` equals ale-py's environment of the same name, to the byte.

Both are made with the same options, seeded alike and given the same actions; after every call all results are compared.
`test_ale_goldens.py` compares every game with check sums of ale-py's environment: colours, RAM, grayscale, sound,
continuous actions, all modes and all difficulties.

Deliberate differences, tested in `tests/env/test_env.py`: an action outside the space raises (ale-py takes negative
indices), so does a step before the first reset; `metadata["render_fps"]` is the true rate, rounded.
"""

import copy
from typing import Any

import ale_py.env
import numpy as np
import pytest
from conformance.ale_goldens import ram_options

import atari
from atari import AtariEnv

GAMES = [game.id for game in atari.games.playable()]


class Pair:
    """Our environment and ale-py's, called alike and compared after every call."""

    def __init__(self, game: str, core: str = "native", **options: Any) -> None:
        self.ours = AtariEnv(game, core=core, **options)
        self.theirs = ale_py.env.AtariEnv(game, **options)
        self.rng = np.random.default_rng(list(game.encode()))
        self.calls = 0

    def reset(self, seed: int | None = None) -> None:
        self._same(self.ours.reset(seed=seed), self.theirs.reset(seed=seed))

    def step(self, action: Any) -> bool:
        """Step both; whether the episode has ended."""
        ours, theirs = self.ours.step(action), self.theirs.step(action)
        self._same(ours, theirs)
        return bool(ours[2] or ours[3])

    def play(self, steps: int) -> None:
        """Play with random actions, each held for some steps, over several episodes."""
        action, left = self.sample(), 0
        for _ in range(steps):
            if left == 0:
                action, left = self.sample(), int(self.rng.choice((1, 1, 2, 4, 8)))
            left -= 1
            if self.step(action):
                self.reset()

    def sample(self) -> int:
        space: Any = self.ours.action_space
        return int(self.rng.integers(space.n))

    def _same(self, ours: tuple[Any, ...], theirs: tuple[Any, ...]) -> None:
        self.calls += 1
        where = f"{self.ours.game.id}, call {self.calls}"
        assert equal(ours[0], theirs[0]), f"{where}: the observation differs"
        assert ours[1:] == theirs[1:], where
        assert list(map(type, ours[1:-1])) == list(map(type, theirs[1:-1])), where
        assert self.ours.np_random.bit_generator.state == self.theirs.np_random.bit_generator.state, where


def equal(ours: Any, theirs: Any) -> bool:
    return bool(ours.dtype == theirs.dtype and np.array_equal(ours, theirs))


@pytest.mark.parametrize("game", GAMES[::26])
def test_pixels_with_the_default_options_also_from_a_copy(game: str) -> None:
    """A deep copy plays the second half; it must continue exactly as the original would."""
    pair = Pair(game, render_mode="rgb_array")
    assert pair.ours.observation_space == pair.theirs.observation_space
    assert pair.ours.action_space == pair.theirs.action_space
    assert pair.ours.get_action_meanings() == pair.theirs.get_action_meanings()
    assert pair.ours.get_keys_to_action() == pair.theirs.get_keys_to_action()
    pair.reset(seed=7)
    pair.play(60)
    pair.reset()
    pair.play(40)
    pair.ours = copy.deepcopy(pair.ours)
    assert equal(pair.ours.render(), pair.theirs.render())
    pair.play(40)
    pair.reset()
    pair.play(10)


@pytest.mark.parametrize("game", GAMES[::26])
def test_states_of_the_core_of_ale_py(game: str) -> None:
    """The states of this core leave out the same parts as ale-py's."""
    pair = Pair(game, core="ale", **ram_options(game))
    pair.reset(seed=2**40 + 1)
    pair.play(160)
    ours, theirs = pair.ours.clone_state(include_rng=True), pair.theirs.clone_state(include_rng=True)
    pair.play(10)
    pair.ours.restore_state(ours)
    pair.theirs.restore_state(theirs)
    pair.play(20)
