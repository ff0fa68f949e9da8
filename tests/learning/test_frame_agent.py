"""`FrameAgent`: a policy on a core gets the observations of `AtariVectorEnv`, and begins games as its task does."""

import re
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from atari import AtariVectorEnv
from atari.cores import NativeCore
from atari.games.actions import Action
from atari.learning.frame_agent import FrameAgent
from atari.learning.frame_episode import PlayedFrames
from atari.task import Task

SEED = 5


class Recorder:
    """Keeps its observations, and draws actions."""

    name = "recorder"

    def __init__(self, **attributes: Any) -> None:
        vars(self).update(attributes)
        self.seen: list[Any] = []
        self.random = np.random.default_rng(1)

    def begin(self, game: str, actions: tuple[str, ...], lanes: Any, seeds: Any) -> None:
        self.actions = actions

    def __call__(self, observations: Any, lanes: Any) -> Any:
        self.seen.append(observations)
        return self.random.integers(len(self.actions), size=1)


def follow(policy: Recorder, game: str, steps: int) -> None:
    """Play with a policy until it has chosen a number of actions, or the game is over."""
    core = NativeCore(game, repeat_action_probability=0.0)
    core.reset()
    agent = FrameAgent(policy, SEED)
    agent.begin(core)
    while len(policy.seen) < steps and not core.game_over:
        core.act(agent.act(core))


def watch(task: Task, steps: int, **layout: Any) -> list[Any]:
    """The observations of a vector of one environment with a policy that draws the same actions, until the game is over."""
    task = task.replace(repeat_action_probability=0.0)
    envs, random = AtariVectorEnv(task, 1, autoreset_mode="Disabled", **layout), np.random.default_rng(1)
    observations, _ = envs.reset(seed=SEED)
    seen = [observations]
    while len(seen) < steps:
        actions = random.integers(len(task.action_set), size=1)
        observations, _, terminations, truncations, info = envs.step(actions)
        if info["terminated"][0]:
            break
        if (terminations | truncations)[0]:
            observations, _ = envs.reset(options={"reset_mask": np.ones(1, np.bool_)})
        seen.append(observations)
    envs.close()
    return seen


def compare(policy: Recorder, expected: list[Any]) -> None:
    """The last observation of a game may be of its end, where the policy's action has no effect."""
    assert len(policy.seen) in (len(expected), len(expected) + 1)
    for ours, theirs in zip(policy.seen, expected, strict=False):
        own, wanted = (seen if isinstance(seen, dict) else {"": seen} for seen in (ours, theirs))
        assert own.keys() == wanted.keys()
        for name, array in wanted.items():
            assert_array_equal(own[name], array, strict=True)


PRESETS = "baselines dqn2015 dopamine gymnasium machado2018 envpool atari100k ale_vector".split()
TASKS: dict[str, dict[str, Any]] = {
    **{name: {"preset": name} for name in PRESETS},
    "ram": {"preset": "baselines", "obs_type": "ram"},
    "stacks of ram": {"preset": "envpool", "obs_type": "ram", "stack_num": 3, "episodic_life": True},
    "ram of dqn2015": {"preset": "dqn2015", "obs_type": "ram"},
    "lives of envpool": {"preset": "envpool", "episodic_life": True, "seamless_lives": False},
    "seamless": {"preset": "envpool", "episodic_life": True},
    "frame of NOOP": {"preset": "dopamine", "episodic_life": True, "on_reset": "noop"},
    "FIRE for a step": {"preset": "dqn2015", "fire": "after_noops", "fire_unit": "skip", "third_action": True},
    "lives for a step": {"preset": "dqn2015", "fire": "before_noops", "lives_unit": "skip", "on_reset": "noop"},
    "small": {"preset": "baselines", "img_height": 42, "img_width": 50, "stack_num": 2},
    "colours": {"preset": "gymnasium", "obs_type": "rgb", "stack_num": 2},
    "one screen": {"preset": "gymnasium", "img_height": None, "img_width": None, "stack_num": None},
    "both": {"preset": "baselines", "obs_type": "dict"},
    "skips": {"preset": "gymnasium", "frameskip": (2, 5)},
    "no pooling": {"preset": "envpool", "frameskip": 3, "maxpool": False},
}


@pytest.mark.parametrize("name", TASKS)
@pytest.mark.parametrize("game", ["breakout", "ms_pacman"])
def test_a_policy_sees_what_a_vector_shows(game: str, name: str) -> None:
    task = Task.of(game, **TASKS[name])
    policy = Recorder(task=task)
    follow(policy, game, 200)
    compare(policy, watch(task, 200))
    assert len({seen["ram"].tobytes() if isinstance(seen, dict) else seen.tobytes() for seen in policy.seen}) > 30


@pytest.mark.parametrize("layout", [{"channels_last": True}, {"dtype": "float32"}])
def test_the_layout_is_the_policys(layout: dict[str, Any]) -> None:
    policy = Recorder(environment={"preset": "baselines", **layout})
    follow(policy, "breakout", 20)
    compare(policy, watch(Task.of("breakout", preset="baselines"), 20, **layout))


def test_an_agent_without_fire_begins_with_it() -> None:
    policy = Recorder(task=Task.of("breakout", preset="baselines", actions=["LEFT", "NOOP", "RIGHT"]))
    core = NativeCore("breakout", repeat_action_probability=0.0)
    core.reset()
    agent = FrameAgent(policy, SEED)
    agent.begin(core)
    actions = []
    while not policy.seen:
        actions.append(agent.act(core))
        core.act(actions[-1])
    noops = actions.index(Action.FIRE)
    assert 1 <= noops <= 30
    assert actions[noops:-1] == [Action.FIRE] * 4 + [Action.RIGHT] * 4
    assert policy.actions == ("LEFT", "NOOP", "RIGHT")


def test_an_agent_that_goes_on_in_a_game_presses_fire_alone() -> None:
    core = NativeCore("breakout", repeat_action_probability=0.0)
    core.reset()
    core.act(0)
    agent = FrameAgent(Recorder(task=Task.of("breakout", preset="envpool")), SEED)
    agent.begin(core)
    assert agent.act(core) == Action.FIRE
    assert agent.task_in(core.game).fire == "after_noops"


@pytest.mark.parametrize("on_reset", ["noop", "continue"])
def test_a_life_that_is_lost_in_the_noops_after_a_lost_life(on_reset: str) -> None:
    task = Task.of("ms_pacman", noops=(700, 700), episodic_life=True, on_reset=on_reset, obs_type="ram")
    policy = Recorder(task=task)
    follow(policy, "ms_pacman", 100)
    compare(policy, watch(task, 100))


def test_ten_thousand_noops_are_played_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    """Once for their actions, and once for the observation."""
    played, act = [0], PlayedFrames.act

    def counted(frames: PlayedFrames, action: int, strength: float) -> int:
        played[0] += 1
        return act(frames, action, strength)

    monkeypatch.setattr(PlayedFrames, "act", counted)
    follow(Recorder(task=Task.of("breakout", noops=(10_000, 10_000), obs_type="ram")), "breakout", 1)
    assert 20_000 <= played[0] <= 20_004  # the actions of the next step are known, too


@pytest.mark.parametrize(("on_reset", "calls"), [("new_game", True), ("continue", False)])
def test_a_policy_hears_of_new_stacks_after_lost_lives(on_reset: str, calls: bool) -> None:
    begun: list[Any] = []
    task = Task.of("breakout", preset="envpool", episodic_life=True, on_reset=on_reset)
    follow(Recorder(task=task, begin_episodes=begun.append), "breakout", 200)
    assert bool(begun) is calls


def test_actions_are_those_of_the_task() -> None:
    policy = Recorder(environment={"preset": "machado2018"})
    follow(policy, "pong", 2)
    assert len(policy.actions) == 18
    policy = Recorder(environment={"preset": "dqn2015", "actions": ["NOOP", "LEFT"]})
    follow(policy, "pong", 2)
    assert policy.actions == ("NOOP", "LEFT")


def test_a_policy_of_another_game_keeps_what_it_sees() -> None:
    policy = Recorder(task=Task.of("pong", preset="dopamine", img_height=40, img_width=42, mode=1))
    follow(policy, "breakout", 2)
    assert [seen.shape for seen in policy.seen] == [(1, 4, 40, 42)] * 2


def test_wrong_actions() -> None:
    policy = Recorder(environment={"actions": ["NOOP"]})
    policy.random = type("Wrong", (), {"integers": lambda *_, **__: np.ones(1, np.int64)})()  # type: ignore[assignment]
    with pytest.raises(ValueError, match="policy recorder returned action 1; in pong it has 1 actions"):
        follow(policy, "pong", 1)


@pytest.mark.parametrize(
    ("environment", "text"),
    [
        ({"sound_obs": True}, "the environment of the policy: sound_obs=True is for"),
        ({"task": Task.of("pong", sound_obs=True)}, "recorder has sound_obs=True, and an agent hears no sound"),
        ({"continuous": True}, "recorder has continuous=True, and an agent chooses"),
        ({"players": 2}, "recorder has players=2, and the game is played by 1; give a policy whose task has players=1"),
        ({"rom": "pong.bin"}, "recorder has rom='pong.bin', and the core has its ROM; leave it out"),
        ({"colour": 1}, "the environment of the policy: it has no option 'colour'"),
        ([], "the environment of the policy: it must be a mapping"),
    ],
)
def test_environments_that_it_does_not_play(environment: Any, text: str) -> None:
    with pytest.raises(ValueError, match=re.escape(text)):
        follow(Recorder(environment=environment), "pong", 1)


def test_random_plays_every_game_alike() -> None:
    actions = []
    for _ in range(2):
        core = NativeCore("seaquest")
        agent = FrameAgent("random", seed=3)
        agent.begin(core)
        played = []
        for _ in range(80):
            played.append(agent.act(core))
            core.act(played[-1])
        actions.append(played)
    assert actions[0] == actions[1]
    assert len(set(actions[0])) > 3
