import numpy as np

from atari.wrappers import DqnPreprocessing, RamObservation


def test_ram_beside_the_image(game_env):
    env, plain = RamObservation(game_env("breakout")), game_env("breakout")
    assert set(env.observation_space.spaces) == {"image", "ram"}
    observation, _ = env.reset(seed=0)
    image, _ = plain.reset(seed=0)
    seen = set()
    for action in (1, 2, 3, 0) * 3:
        assert observation in env.observation_space
        np.testing.assert_array_equal(observation["image"], image)
        np.testing.assert_array_equal(observation["ram"], plain.core.ram())
        seen.add(observation["ram"].tobytes())
        observation = env.step(action)[0]
        image = plain.step(action)[0]
    assert len(seen) == 12


def test_outside_of_preprocessing(game_env):
    env = RamObservation(DqnPreprocessing(game_env("breakout")))
    env.reset(seed=0)
    observation = env.step(1)[0]
    assert observation["image"].shape == (4, 84, 84)
    np.testing.assert_array_equal(observation["ram"], env.unwrapped.core.ram())


def test_joins_sound(game_env):
    env = RamObservation(game_env("breakout", sound_obs=True))
    assert set(env.observation_space.spaces) == {"image", "sound", "ram"}
    assert env.reset(seed=0)[0] in env.observation_space
