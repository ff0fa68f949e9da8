"""`AtariEnv` on the core of ale-py equals ale-py's environment of the same name, to the byte, also after its states.

`test_ale_goldens.py` compares `AtariEnv` on our core in every game: colours, RAM, grayscale, sound, continuous actions,
all modes and all difficulties.

Deliberate differences, tested in `tests/env/test_env.py`: an action outside the space raises (ale-py takes negative
indices), so does a step before the first reset; `metadata["render_fps"]` is the true rate, rounded.
"""

import ale_py.env
import pytest
from conformance.ale_goldens import GAMES, Play, ram_options

from atari import AtariEnv


@pytest.mark.parametrize("game", GAMES[::26])
def test_states_of_the_core_of_ale_py(game: str) -> None:
    """The states of this core leave out the same parts as ale-py's."""
    options = ram_options(game)
    plays = [Play(AtariEnv(game, core="ale", **options)), Play(ale_py.env.AtariEnv(game, **options))]
    for play in plays:
        play.reset(seed=2**40 + 1)
        play.steps(160)
        state = play.env.clone_state(include_rng=True)
        play.steps(10)
        play.env.restore_state(state)
        play.steps(20)
    assert str(plays[0].sum) == str(plays[1].sum)
