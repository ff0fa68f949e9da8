"""`TrainingOptions`: accepted values, errors for all others, and the task that they make."""

import pickle
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import atari
from atari.learning.options import TrainingOptions, option_from_text
from atari.task import Task


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("total_steps", "1e6", 1_000_000),
        ("stop_score", "18", 18.0),
        ("stop_score", "none", None),
        ("normalize", "true", True),
        ("network", "small", "small"),
        ("bfloat16", "auto", "auto"),
        ("bfloat16", "false", False),
    ],
)
def test_parse(name: str, text: str, value: object) -> None:
    assert option_from_text(TrainingOptions, name, text) == value


@pytest.mark.parametrize(("name", "text"), [("total_steps", "1.5"), ("normalize", "yes"), ("gamma", "x")])
def test_parse_refuses(name: str, text: str) -> None:
    with pytest.raises(ValueError, match=r"must be (a whole number|true or false|a number), got"):
        option_from_text(TrainingOptions, name, text)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"num_envs": 0}, "num_envs must be within 1..65536, got 0"),
        ({"num_envs": 3, "workers": 2}, "num_envs must be a multiple of workers"),
        ({"obs_type": "ram", "network": "small"}, "network 'small' is not for obs_type 'ram'"),
        ({"network": "mlp"}, "images need nature or small"),
        ({"obs_type": "sound"}, "obs_type must be one of"),
        ({"obs_type": "rgb"}, "an agent learns from obs_type='grayscale' or 'ram', and the task has 'rgb'"),
        ({"obs_type": "dict"}, "the task has 'dict'; add obs_type='grayscale'"),
        ({"stack_num": None}, "add stack_num=4, or 1"),
        ({"continuous": True, "third_action": False}, "continuous=True; leave it out"),
        ({"network": "resnet"}, "network must be one of nature, small"),
        ({"gamma": 1.5}, "gamma must be"),
        ({"bfloat16": "yes"}, "bfloat16 must be one of auto, true, false, got 'yes'"),
        ({"obs_type": "ram", "stack_num": None}, "add stack_num=4, or 1"),
        ({"obs_type": "ram", "stack_num": 0}, "stack_num must be"),
        ({"obs_type": "ram", "padding": "one"}, "padding must be one of"),
        ({"seed": 2**32}, "seed must be within 0..4294967295, got 4294967296"),
        ({"seed": -1}, "seed must be within"),
        ({"preset": "dqn2015", "repeat_action_probability": 0.25}, "needs repeat_action_probability=0.0"),
        ({"preset": "dqn2015", "actions": "full"}, "preset 'dqn2015' needs actions='minimal'"),
        ({"preset": "dqn2015", "actions": ["UP"]}, "preset 'dqn2015' needs actions='minimal'"),
        ({"preset": "dqn"}, "did you mean 'dqn2015'?"),
    ],
)
def test_wrong_options(given: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=re.escape(text)):
        TrainingOptions.of("pong", **given)


def test_options_of_the_wrong_type() -> None:
    for given, text in (
        ({"learning_rat": 1}, "TrainingOptions has no option 'learning_rat'; did you mean 'learning_rate'"),
        ({"img_hight": 1}, "did you mean 'img_height'?"),
    ):
        with pytest.raises(TypeError, match=re.escape(text)):
            TrainingOptions.of("pong", **given)
    with pytest.raises(
        TypeError, match=r"task must be an atari.Task, got 'pong'; TrainingOptions.of\(GAME\) makes one"
    ):
        TrainingOptions(task="pong")  # type: ignore[arg-type]


@pytest.mark.parametrize("preset", atari.PRESETS)
def test_the_task_says_what_the_learner_is_paid_and_where_its_episodes_end(preset: str) -> None:
    task = TrainingOptions.of("breakout", preset=preset).task
    assert task == Task.of("breakout", preset=preset, reward_clipping=True, seamless_lives=False)
    assert TrainingOptions.of("breakout", preset=preset, episodic_life=True).task.seamless_lives is False
    assert TrainingOptions.of("breakout", preset=preset, clip_reward=False).task.reward_clipping is False
    assert TrainingOptions.of("breakout", preset="envpool", episodic_life=True, seamless_lives=True).task.seamless_lives


def test_a_task_is_played_as_it_is() -> None:
    task = Task.of("breakout", preset="envpool", episodic_life=True, mode=4)
    assert TrainingOptions.of(task).task == TrainingOptions(task=task).task == task
    assert TrainingOptions.of(task, stack_num=2).task == task.replace(stack_num=2)
    assert TrainingOptions.of(task, preset="dqn2015").task.reward_clipping is True


@pytest.mark.parametrize(
    ("env_id", "sticky", "obs_type"),
    [
        ("ALE/Pong-v5", 0.25, "grayscale"),
        ("PongNoFrameskip-v4", 0.0, "grayscale"),
        ("Pong-ram-v4", 0.0, "ram"),
        ("Pong-ram-v0", 0.25, "ram"),
    ],
)
def test_an_id_decides_sticky_actions_and_ram(env_id: str, sticky: float, obs_type: str) -> None:
    options = TrainingOptions.of(env_id)
    played = options.task
    assert (played.repeat_action_probability, played.obs_type) == (sticky, obs_type)
    assert (played.frameskip, played.fire, played.noops) == (4, "after_noops", (1, 30))
    assert (options.network, options.task.stack_num) == (("mlp", 4) if options.from_ram else ("nature", 4))


def test_names_of_actions_go_with_any_preset() -> None:
    actions = ["NOOP", "RIGHT", "LEFT"]
    for preset in atari.PRESETS:
        expected = Task.of("pong", preset=preset, reward_clipping=True, seamless_lives=False).replace(actions=actions)
        assert TrainingOptions.of("pong", preset=preset, actions=actions).task == expected


def test_ram() -> None:
    options = TrainingOptions.of("pong", obs_type="ram")
    assert (options.task.stack_num, options.task.padding) == (4, "reset")
    given = TrainingOptions.of("Pong-ram-v4", stack_num=3, padding="zero").task
    assert (given.stack_num, given.padding) == (3, "zero")
    assert TrainingOptions.of(given, network="mlp").task == given
    with pytest.raises(ValueError, match="the task has stack_num=None; add stack_num=4"):
        TrainingOptions.of(given.replace(stack_num=None))
    assert pickle.loads(pickle.dumps(options)) == replace(options) == options


def test_seeds_of_environments() -> None:
    options = TrainingOptions.of("pong", num_envs=4)
    assert options.environment_seeds(2**31 - 4, 4).tolist() == [2**31 - 4 + index for index in range(4)]
    assert options.environment_seeds(2**32 - 4, 4)[-1] == 2**32 - 1
    drawn = options.environment_seeds(2**32 - 3, 4)
    assert drawn.tolist() == np.random.SeedSequence(2**32 - 3).generate_state(4).tolist()
    assert len(set(drawn.tolist())) == 4
