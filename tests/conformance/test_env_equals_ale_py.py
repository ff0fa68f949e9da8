"""`AtariEnv` equals ale-py's environment of the same name: every game, to the byte.

Both are made with the same options, seeded alike and given the same actions; after every call
all results are compared. The number of emulated frames compared is recorded as the property "frames" of each test.

Deliberate differences, tested in `tests/test_env.py`: an action outside the space raises (ale-py takes negative
indices), so does a step before the first reset; `metadata["render_fps"]` is the true rate, rounded.
"""

import copy
import itertools
from typing import Any

import ale_py.env
import numpy as np
import pytest

import atari
from atari import AtariEnv

GAMES = [game.id for game in atari.games.playable()]


class Pair:
    """Our environment and ale-py's, called alike and compared after every call."""

    def __init__(self, game: str, core: str = "native", **options: Any) -> None:
        self.ours = AtariEnv(game, core=core, **options)
        self.theirs = ale_py.env.AtariEnv(game, **options)
        self.rng = np.random.default_rng(list(game.encode()))
        self.frames = 0
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
            before = self.ours.core.frame_number
            ended = self.step(action)
            self.frames += self.ours.core.frame_number - before
            if ended:
                self.reset()

    def sample(self) -> Any:
        space: Any = self.ours.action_space
        if self.ours.continuous:
            return np.asarray(self.rng.uniform(space.low, space.high), np.float32)
        return int(self.rng.integers(space.n))

    def _same(self, ours: tuple[Any, ...], theirs: tuple[Any, ...]) -> None:
        self.calls += 1
        where = f"{self.ours.game.id}, call {self.calls}"
        assert equal(ours[0], theirs[0]), f"{where}: the observation differs"
        assert ours[1:] == theirs[1:], where
        assert list(map(type, ours[1:-1])) == list(map(type, theirs[1:-1])), where
        assert self.ours.np_random.bit_generator.state == self.theirs.np_random.bit_generator.state, where


def equal(ours: Any, theirs: Any) -> bool:
    if isinstance(theirs, dict):
        return list(ours) == list(theirs) and all(equal(ours[key], theirs[key]) for key in theirs)
    return ours.dtype == theirs.dtype and np.array_equal(ours, theirs)


@pytest.mark.parametrize("game", GAMES)
def test_pixels_with_the_default_options_also_from_a_copy(game: str, record_property: Any) -> None:
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
    record_property("frames", pair.frames)


@pytest.mark.parametrize("game", GAMES)
def test_ram_with_a_random_frameskip_all_actions_last_mode_and_a_limit(game: str, record_property: Any) -> None:
    facts = atari.games[game]
    assert facts.rules is not None
    pair = Pair(
        game,
        core="ale",  # the states of this core leave out the same parts as ale-py's
        mode=facts.modes[-1],
        difficulty=facts.difficulties[-1],
        obs_type="ram",
        frameskip=(2, 5),
        repeat_action_probability=0.0,
        full_action_space=True,
        max_num_frames_per_episode=max(300, facts.rules.selection_frames),
    )
    assert pair.ours.observation_space == pair.theirs.observation_space
    assert pair.ours.action_space == pair.theirs.action_space
    assert pair.ours.get_action_meanings() == pair.theirs.get_action_meanings()
    pair.reset(seed=2**40 + 1)
    pair.play(160)
    ours, theirs = pair.ours.clone_state(include_rng=True), pair.theirs.clone_state(include_rng=True)
    pair.play(10)
    pair.ours.restore_state(ours)
    pair.theirs.restore_state(theirs)
    pair.play(20)
    record_property("frames", pair.frames)


@pytest.mark.parametrize("game", GAMES)
def test_grayscale_with_sound_and_continuous_actions(game: str, record_property: Any) -> None:
    pair = Pair(
        game,
        obs_type="grayscale",
        frameskip=1,
        repeat_action_probability=0.5,
        continuous=True,
        continuous_action_threshold=0.3,
        sound_obs=True,
    )
    assert pair.ours.observation_space == pair.theirs.observation_space
    assert pair.ours.action_space == pair.theirs.action_space
    pair.reset(seed=0)
    pair.play(150)
    pair.reset()
    pair.play(100)
    record_property("frames", pair.frames)


def settings(game: str) -> list[tuple[int, int]]:
    """Each mode with one of the difficulties, and each difficulty with one of the modes."""
    modes, difficulties = atari.games[game].modes, atari.games[game].difficulties
    count = max(len(modes), len(difficulties))
    return list(itertools.islice(zip(itertools.cycle(modes), itertools.cycle(difficulties), strict=False), count))


SOME = 20
SELECTIONS = [(game, first) for game in GAMES for first in range(0, len(settings(game)), SOME) if settings(game)[1:]]


@pytest.mark.filterwarnings("ignore:.*after the episode had ended")  # three modes of Demon Attack are over at once
@pytest.mark.parametrize(("game", "first"), SELECTIONS)
def test_every_mode_and_difficulty(game: str, first: int) -> None:
    """The reset and six steps. ale-py is slow to load a ROM, so its side restores the state after loading."""
    seed = 3 if "rng()" in str(atari.games[game].rules) else None  # where a reset draws random words, draw the same
    options: dict[str, Any] = {"obs_type": "grayscale", "repeat_action_probability": 0.0, "frameskip": 2}
    theirs = ale_py.env.AtariEnv(game, **options)
    theirs.seed_game(seed)
    theirs.load_game()
    loaded = theirs.ale.cloneSystemState()
    for mode, difficulty in settings(game)[first : first + SOME]:
        where = f"mode {mode}, difficulty {difficulty}"
        ours = AtariEnv(game, mode=mode, difficulty=difficulty, **options)
        theirs.ale.restoreSystemState(loaded)
        theirs.ale.setMode(mode)
        theirs.ale.setDifficulty(difficulty)
        mine, other = ours.reset(seed=seed), theirs.reset()
        mine[1].pop("seeds", None)
        assert np.array_equal(mine[0], other[0]), where
        assert mine[1] == other[1], where
        for action in (1, 2, 0, 3, 1, 0):
            action %= len(ours.get_action_meanings())
            step, expected = ours.step(action), theirs.step(action)
            assert np.array_equal(step[0], expected[0]), where
            assert step[1:] == expected[1:], where
