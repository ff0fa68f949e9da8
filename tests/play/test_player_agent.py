"""`PlayerAgent`: policies of trainings in games of several players, by policies that need no PyTorch."""

from typing import Any

import numpy as np
import pytest

from atari import AtariVectorEnv
from atari.cores import NativeCore
from atari.games.actions import Action
from atari.learning import ScoresPolicy
from atari.learning.frame_agent import FrameAgent
from atari.learning.options import TrainingOptions
from atari.multiplayer import MultiplayerCore
from atari.play.multiplayer_session import MultiplayerSession, PlayerAgent

ACTIONS = ("NOOP", "FIRE", "RIGHT", "LEFT")


def player(scores: Any, **options: Any) -> PlayerAgent:
    task = TrainingOptions.of("pong", **{"actions": ACTIONS, **options}).task
    return PlayerAgent(ScoresPolicy(scores, task=task), 0, MultiplayerCore("pong"), "rgb")


@pytest.mark.parametrize(
    "options",
    [
        *[{"preset": name} for name in ("baselines", "dqn2015", "dopamine", "envpool", "gymnasium", "machado2018")],
        {"preset": "dqn2015", "frameskip": 3, "img_height": 42, "img_width": 40, "stack_num": 2},
        {"preset": "gymnasium", "maxpool": False, "padding": "zero"},
        {"preset": "dqn2015", "obs_type": "ram", "stack_num": 3, "padding": "reset"},
    ],
)
def test_a_player_observes_what_its_training_did(options: dict[str, Any]) -> None:
    """It gets the frames of a one-player game that the environments of trainings play, too."""
    task = TrainingOptions.of("pong", actions=ACTIONS, **options).task
    begun = {"repeat_action_probability": 0.0, "noops": (0, 0), "fire": "never", "episodic_life": False}
    envs = AtariVectorEnv(task.replace(**begun), 1)
    expected, _ = envs.reset(seed=0)
    core = NativeCore("pong", seed=0, repeat_action_probability=0.0)
    core.reset()
    seen: list[Any] = []
    plan = np.random.default_rng(1).integers(4, size=60)

    def scores(observations: Any) -> Any:
        seen.append(observations.copy())
        return plan[len(seen) - 1 :][:1]

    agent = player(scores, **options)
    agent.begin(core)
    for frame in range(int(task.frameskip) * len(plan)):  # type: ignore[arg-type]
        action = agent.act(core)
        if frame % task.frameskip == 0:  # type: ignore[operator]
            assert np.array_equal(seen[-1], expected)
            assert action == Action[ACTIONS[plan[len(seen) - 1]]]
            expected = envs.step(plan[len(seen) - 1 :][:1])[0]
        core.act(action)
    assert len(seen) == len(plan)
    assert len({image.tobytes() for image in seen}) > 30


def test_a_policy_says_what_it_sees_by_an_environment() -> None:
    environment = {"preset": "baselines", "actions": ACTIONS, "channels_last": True}
    seen: list[Any] = []
    policy = ScoresPolicy(lambda images: seen.append(images) or np.array([2]), environment=environment)
    core = MultiplayerCore("pong")
    core.reset()
    agent = PlayerAgent(policy, 1, core, "ram")
    agent.begin(core)
    assert agent.act(core) == Action.RIGHT
    assert seen[0].shape == (1, 84, 84, 4)


def test_a_player_of_ram_acts_every_fourth_frame_and_begins_anew() -> None:
    seen: list[Any] = []
    agent = player(lambda rams: seen.append(rams) or np.array([2]), obs_type="ram")
    core = MultiplayerCore("pong")
    core.reset()
    frames = [0, 1, 2, 3, 4, 5, 2, 3, 4, 5, 6, 0]
    for before, frame in zip([-2, *frames], frames, strict=False):
        core.set_ram(0, frame)
        if frame != before + 1:
            agent.begin(core)
        assert agent.act(core) == Action.RIGHT
    stacks = [[0, 0, 0, 0], [0, 0, 0, 4], [2, 2, 2, 2], [2, 2, 2, 6], [0, 0, 0, 0]]
    assert [rams[0, :, 0].tolist() for rams in seen] == stacks
    assert {rams.shape for rams in seen} == {(1, 4, 128)}


def test_stacks_of_ram_have_no_mirror() -> None:
    core = MultiplayerCore("pong")
    core.reset()
    seen: list[Any] = []
    task = TrainingOptions.of("pong", obs_type="ram").task
    agent = PlayerAgent(ScoresPolicy(lambda rams: seen.append(rams) or np.array([2]), task=task), 1, core, "rgb")
    agent.begin(core)
    for _ in range(5):
        ram = core.ram()
        core.act_players([0, int(agent.act(core))])
    assert np.array_equal(seen[-1][0, -1], ram)


def court(core: MultiplayerCore) -> Any:
    return core.screen_grayscale()[34:194].astype(int)


@pytest.mark.parametrize("mode", [3, 4])
def test_the_paddles_of_pong_move_alike_in_a_mirror(mode: int) -> None:
    """The game reads the two paddles in different frames, so their rows differ by up to 8, for a frame."""
    plan = np.repeat(np.random.default_rng(0).choice([0, 3, 4], 100), 3).tolist()
    first, second = MultiplayerCore("pong", mode=mode), MultiplayerCore("pong", mode=mode)
    first.reset()
    second.reset()
    rows, compared = [], 0
    for action in plan:
        first.act_players([action, 0])
        second.act_players([0, action])
        images = court(first), court(second)[:, ::-1]
        rows.append([np.flatnonzero(abs(image[:, 141] - 147) <= 1)[-1] for image in images])
        if max(image.max() for image in images) < 160:  # no ball
            differing = np.argwhere(abs(images[0] - images[1]) > 1)[:, 1]
            assert {*differing.tolist()} <= {*range(16, 20), *range(140, 144)}
            compared += 1
    differences = np.diff(rows)
    assert abs(differences).max() <= 8
    assert abs(differences.mean()) < 1
    assert np.ptp(rows) > 100
    assert compared > 50


def follow(observations: Any) -> Any:
    """The actions of a policy that has only seen the right paddle: it keeps it at the ball's height, and serves."""
    image = observations[0, -1][14:77]  # the court
    ball = np.argwhere(image[:, :73] > 160)
    paddle = np.argwhere(image[:, 73:76] > 100)
    if not len(ball) or not len(paddle):
        return np.array([1])
    below = ball[:, 0].mean() - paddle[:, 0].mean()
    return np.array([0 if abs(below) < 2 else 3 if below > 0 else 2])


def match(players: dict[int, Any]) -> list[int]:
    session = MultiplayerSession("pong", mode=3, seed=1, policies=players)
    while not session.over:
        session.play()
    return session.scores


def serve(observations: Any) -> Any:
    return [1]


def test_the_mirror_lets_a_policy_of_player_1_play_pong_as_player_2(monkeypatch: pytest.MonkeyPatch) -> None:
    policy = ScoresPolicy(follow, task=TrainingOptions.of("pong", actions=ACTIONS).task)
    assert match({0: policy, 1: serve}) == [21, -21]
    assert match({0: serve, 1: policy}) == [-20, 20]
    monkeypatch.setattr(PlayerAgent, "_screen", FrameAgent._screen)
    assert match({0: serve, 1: policy}) == [21, -21]
