"""Each of the 952 IDs makes an environment of its game, which resets and steps."""

import warnings

import gymnasium
import pytest

import atari
from atari import AtariEnv
from atari.task import env_ids

GAMES = [game.id for game in atari.games.playable()]


@pytest.mark.parametrize("game", GAMES)
def test_each_id_of_a_game_makes_it(game: str) -> None:
    mine = [(env_id, family) for env_id, (family, of) in env_ids.ids().items() if of == game]
    assert len(mine) == (14 if game in env_ids.LEGACY_GAMES else 2)
    for env_id, family in mine:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message=".*is out of date", category=DeprecationWarning)  # v0 beside v4
            env = gymnasium.make(env_id)
        unwrapped = env.unwrapped
        assert isinstance(unwrapped, AtariEnv)
        observation, info = env.reset()
        shape = (128,) if family.ram else (*atari.games[game].screen.shape, 3)
        assert observation.shape == env.observation_space.shape == shape
        env.step(env.action_space.sample())
        played = unwrapped.core.frame_number - info["frame_number"]
        skip = family.options(game)["frameskip"]
        assert played == skip if isinstance(skip, int) else skip[0] <= played < skip[1]
        env.close()
