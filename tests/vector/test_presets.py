"""A preset in the vector environment is the preset's wrappers around single environments, to the byte."""

from typing import Any

import numpy as np
import pytest
from lane_oracle import Lanes

import atari
from atari import wrappers

GAMES = [game.id for game in atari.games.playable()]
SETTINGS: list[dict[str, bool]] = [{}, {"episodic_life": True}, {"episodic_life": False, "reward_clipping": False}]


def compare(name: str, game: str, steps: int, seed: int, **settings: bool) -> int:
    """Assert equality for some steps of random actions; returns the number of episodes that ended."""
    clip = settings.get("reward_clipping")
    singles = [
        wrappers.preset(
            atari.AtariEnv(game, **wrappers.preset_options(name)),
            name,
            episodic_life=settings.get("episodic_life"),
            clip_reward=clip,
        )
        for _ in range(2)
    ]
    lanes = Lanes([atari.Task.of(game, preset=name, **settings)] * 2, "NextStep", singles)  # type: ignore[arg-type]
    generator = np.random.default_rng(seed)
    lanes.reset(seed)
    for _ in range(steps):
        lanes.step(lanes.sample(generator))
    lanes.close()
    return lanes.ends


@pytest.mark.parametrize("settings", SETTINGS)
@pytest.mark.parametrize("name", atari.PRESETS)
def test_every_preset(name: str, settings: dict[str, bool]) -> None:
    ended = compare(name, "breakout", 200, seed=3, **settings)
    assert ended > 2 or not settings.get("episodic_life")
    compare(name, "ms_pacman", 120, seed=4, **settings)


@pytest.mark.parametrize("game", GAMES)
def test_every_game(game: str) -> None:
    names = [name for name in atari.PRESETS if name != "baselines" or game not in UNFIT]
    number = GAMES.index(game)
    compare(names[number % len(names)], game, 40, seed=number, **SETTINGS[number % 3])


# Baselines begins with the third action, which these do not have, or with a step of a NOOP that they do not have.
UNFIT = [game.id for game in atari.games.playable() if len(game.minimal_actions) < 3 or 0 not in game.minimal_actions]


def test_a_limit_of_frames() -> None:
    for name, field in (("envpool", "max_frames"), ("dqn2015", "max_num_frames_per_episode")):
        assert getattr(atari.Task.of("pong", preset=name), field) == 108_000
        limit: Any = {field: 1080}
        envs = atari.AtariVectorEnv("pong", 1, preset=name, obs_type="ram", num_threads=1, **limit)
        envs.reset(seed=0)
        step, truncated = 0, np.zeros(1, bool)
        while not truncated[0] and step < 270:
            _, _, terminated, truncated, info = envs.step(np.zeros(1, int))
            assert not terminated[0]
            step += 1
        assert truncated[0]
        if name == "envpool":  # does not count the frames that begin an episode
            assert step == 270
            assert 1080 < info["episode_frame_number"][0] <= 1111
        else:
            assert step < 270
            assert info["episode_frame_number"][0] == 1080


class TestChoice:
    @pytest.mark.parametrize(
        ("options", "text"),
        [
            ({"preset": "dqn"}, "there is no preset 'dqn'; did you mean 'dqn2015'"),
            ({"img_width": 300}, "img_width must be within 1..160, got 300"),
            ({"padding": "first"}, "padding must be one of 'zero', 'reset', got 'first'"),
            ({"repeat_action_probability": 0.25}, "needs repeat_action_probability=0.0, got 0.25"),
            ({"full_action_space": True}, "needs full_action_space=False, got True"),
            ({"pool_rgb": True, "obs_type": "rgb"}, "pool_rgb=True has no effect"),
        ],
    )
    def test_is_checked(self, options: dict[str, Any], text: str) -> None:
        with pytest.raises(ValueError, match=text):
            atari.AtariVectorEnv("pong", 1, **{"preset": "dqn2015", **options})

    def test_brings_its_options(self) -> None:
        envs = atari.AtariVectorEnv("pong", 1, preset="machado2018")
        assert envs.single_action_space.n == 18  # type: ignore[attr-defined]

    def test_sticky_actions_that_are_not_prescribed_can_be_chosen(self) -> None:
        envs = atari.AtariVectorEnv("pong", 1, preset="gymnasium", repeat_action_probability=0.0, num_threads=1)
        single = wrappers.preset(atari.AtariEnv("pong", frameskip=1, repeat_action_probability=0.0), "gymnasium")
        observation, _ = envs.reset(seed=2)
        expected, _ = single.reset(seed=2)
        for action in (2, 3, 2, 2, 5, 4):
            assert np.array_equal(observation[0], expected)
            observation, *_ = envs.step(np.array([action]))
            expected, *_ = single.step(action)
