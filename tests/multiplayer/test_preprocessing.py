"""`PreprocessedEnv` gives what a reference in NumPy and OpenCV makes of all frames."""

from typing import Any

import cv2
import numpy as np
import pytest

pytest.importorskip("pettingzoo")
from pettingzoo.test import api_test, parallel_api_test

from atari.multiplayer import env, parallel_env
from atari.multiplayer.parallel import MultiplayerEnv
from atari.multiplayer.preprocessing import PreprocessedEnv, preprocessed


def scaled(frames: list[Any]) -> Any:
    pooled = np.max([frame[..., 0] for frame in frames], axis=0)
    return cv2.resize(pooled, (84, 84), interpolation=cv2.INTER_AREA)


@pytest.mark.parametrize("name", ["joust", "warlords", "pong", "maze_craze"])
def test_observations_rewards_and_ends_are_those_of_the_reference(name: str) -> None:
    source = np.random.default_rng(3)
    game, plain = preprocessed(name, player_indicator=True), MultiplayerEnv(name, obs_type="grayscale_image")
    agents = plain.possible_agents
    observations, _ = game.reset(seed=5)
    stack = [scaled([plain.reset(seed=5)[0]["first_0"]])] * 4
    for _ in range(400):
        for agent in game.agents:
            indicator = [np.full((84, 84), 255 * (agent == other), np.uint8) for other in agents]
            assert np.array_equal(observations[agent], np.stack([*stack, *indicator], axis=-1))
        actions = {agent: int(source.integers(game.action_space(agent).n)) for agent in agents}
        living, frames, totals, over = list(plain.agents), [], dict.fromkeys(plain.agents, 0), {}
        for _ in range(4):
            seen, rewards, ends, *_ = plain.step(actions)
            frames.append(seen[next(iter(seen))])
            over |= ends
            for agent, reward in rewards.items():
                totals[agent] += int(reward)
            if not plain.agents:
                break
        stack = [*stack[1:], scaled(frames[-2:])]
        observations, rewards, ends, truncated, _ = game.step(actions)
        assert list(observations) == living
        assert (rewards, ends, game.agents) == (totals, over, plain.agents)
        assert not any(truncated.values())
        if not plain.agents:
            stack = [scaled([plain.reset()[0]["first_0"]])] * 4
            observations, _ = game.reset()


def test_without_an_indicator_all_agents_see_the_stack() -> None:
    game = preprocessed("boxing", frame_skip=1, stack=2, shape=(110, 80))
    observations, _ = game.reset(seed=1)
    assert observations["first_0"].shape == (110, 80, 2) == game.observation_space("second_0").shape
    assert np.array_equal(observations["first_0"], observations["second_0"])


def test_a_snapshot_continues_with_its_stack() -> None:
    game = preprocessed("boxing")
    game.reset(seed=1)
    for _ in range(20):
        game.step({"first_0": 3, "second_0": 4})
    state = game.snapshot()
    after = [game.step({"first_0": 4, "second_0": 3})[0]["first_0"] for _ in range(5)]
    game.restore(state)
    again = [game.step({"first_0": 4, "second_0": 3})[0]["first_0"] for _ in range(5)]
    assert np.array_equal(after, again)


def test_pettingzoos_tests_pass_with_the_preset() -> None:
    parallel_api_test(parallel_env("warlords", preset="dqn", player_indicator=True), num_cycles=100)
    api_test(env("joust", preset="dqn", stack=3), num_cycles=30)


def test_truncation_ends_a_step_early() -> None:
    game = preprocessed("boxing", max_cycles=6)
    game.reset(seed=1)
    assert not any(game.step({})[3].values())
    assert all(game.step({})[3].values())
    assert game.env.frame == 6


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"preset": "atari"}, ValueError, "preset must be one of 'dqn'"),
        ({"preset": "dqn", "obs_type": "ram"}, ValueError, "leave obs_type out"),
        ({"preset": "dqn", "stack": 0}, ValueError, "stack"),
        ({"preset": "dqn", "shape": 84}, TypeError, "two integers"),
        ({"preset": "dqn", "player_indicator": 1}, TypeError, "must be True or False"),
        ({"stack": 4}, TypeError, "stack"),
    ],
)
def test_a_wrong_option_is_one_sentence(options: dict[str, Any], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        parallel_env("boxing", **options)


def test_other_observations_are_refused() -> None:
    with pytest.raises(ValueError, match="obs_type='grayscale_image'"):
        PreprocessedEnv(MultiplayerEnv("boxing", obs_type="ram"))
