"""`FrameAgent`: a policy on the frames of a core."""

from typing import Any

import cv2
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from atari.actions import Action
from atari.cores import NativeCore
from atari.learning.frame_agent import FrameAgent


class Recorder:
    """Keeps its observations, and always chooses its second action."""

    name = "recorder"

    def __init__(self, **environment: Any) -> None:
        self.environment = environment
        self.seen: list[Any] = []

    def __call__(self, observations: Any, lanes: Any) -> Any:
        self.seen.append(observations)
        return np.ones(1, np.int64)


def play(policy: Recorder, game: str, frames: int) -> tuple[list[int], list[Any]]:
    core = NativeCore(game, repeat_action_probability=0.0)
    core.reset()
    agent = FrameAgent(policy)
    agent.begin(core)
    actions, screens = [], [core.screen_grayscale()]
    for _ in range(frames):
        actions.append(agent.act(core))
        core.act(actions[-1])
        screens.append(core.screen_grayscale())
    return actions, screens


def test_images_are_pooled_resized_and_stacked() -> None:
    policy = Recorder(preset="baselines", actions=["NOOP", "RIGHT"], img_width=80)
    actions, screens = play(policy, "pong", 17)
    assert actions == [Action.FIRE] * 4 + [Action.RIGHT] * 13
    assert [seen.shape for seen in policy.seen] == [(1, 4, 84, 80)] * 5
    for number, seen in enumerate(policy.seen[1:], 1):
        pooled = np.maximum(screens[4 * number], screens[4 * number - 1])
        assert_array_equal(seen[0, -1], cv2.resize(pooled, (80, 84), interpolation=cv2.INTER_AREA))
        assert_array_equal(seen[0, :-1], policy.seen[number - 1][0, 1:])


def test_ram() -> None:
    policy = Recorder(obs_type="ram", preset="machado2018")
    actions, _ = play(policy, "pong", 8)
    assert actions == [Action.FIRE] * 8  # the second of its minimal actions
    assert [seen.shape for seen in policy.seen] == [(1, 128)] * 2


def test_wrong_actions() -> None:
    policy = Recorder(actions=["NOOP"])
    with pytest.raises(ValueError, match="recorder must return one of 1 actions"):
        play(policy, "pong", 1)


def test_random_plays_every_game_alike() -> None:
    actions = []
    for _ in range(2):
        core = NativeCore("seaquest")
        agent = FrameAgent("random", seed=3)
        agent.begin(core)
        actions.append([agent.act(core) for _ in range(40)])
    assert actions[0] == actions[1]
    assert len(set(actions[0])) > 3
