"""The six IDs in Gymnasium, as OpenAI Gym published them."""

import warnings
from typing import Any

import gymnasium
import pytest
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env

import atari
from atari import classic
from atari.classic import algorithmic
from atari.registry.registration import register_algorithmic

TASKS = {
    "Copy-v0": (algorithmic.CopyEnv, 25.0, (2, 2, 5)),
    "DuplicatedInput-v0": (algorithmic.DuplicatedInputEnv, 9.0, (2, 2, 5)),
    "RepeatCopy-v0": (algorithmic.RepeatCopyEnv, 75.0, (2, 2, 5)),
    "Reverse-v0": (algorithmic.ReverseEnv, 25.0, (2, 2, 2)),
    "ReversedAddition-v0": (algorithmic.ReversedAdditionEnv, 25.0, (4, 2, 3)),
    "ReversedAddition3-v0": (algorithmic.ReversedAdditionEnv, 25.0, (4, 2, 3)),
}
GROWTH = {"RepeatCopy-v0": (2, 50), "Reverse-v0": (1, 50)}  # the others: (2, 10)


@pytest.mark.parametrize("env_id", TASKS)
def test_an_id_stands_for_the_published_task(env_id: str) -> None:
    kind, threshold, actions = TASKS[env_id]
    env = gymnasium.make(env_id)
    assert type(env.unwrapped) is kind
    assert env.spec is not None
    assert (env.spec.reward_threshold, env.spec.max_episode_steps) == (threshold, 200)
    assert not env.spec.nondeterministic
    assert env.action_space == spaces.Tuple([spaces.Discrete(count) for count in actions])
    assert env.observation_space == spaces.Discrete(actions[2] + 1)
    inner: Any = env.unwrapped
    assert (inner.min_length, inner.window) == GROWTH.get(env_id, (2, 10))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        register_algorithmic()
        check_env(inner)


def test_three_rows_are_three() -> None:
    rows = [gymnasium.make(env_id).reset()[1]["input"].count("\n") + 1 for env_id in list(TASKS)[-2:]]
    assert rows == [2, 3]


def test_options_go_through_make() -> None:
    env = gymnasium.make("Copy-v0", base=26, min_length=30)
    assert len(env.reset(seed=0)[1]["input"]) >= 30
    assert env.action_space[2].n == 26  # type: ignore[index]


@pytest.mark.parametrize("env_id", TASKS)
def test_they_play_through_the_interface_of_their_time(env_id: str, capsys: pytest.CaptureFixture[str]) -> None:
    _, threshold, actions = TASKS[env_id]
    env = classic.make(env_id)
    assert str(env.action_space) == f"Tuple({', '.join(f'Discrete({count})' for count in actions)})"
    assert env.spec is not None
    assert (env.spec.reward_threshold, env.spec.max_episode_steps) == (threshold, 200)
    env.seed(1)
    assert env.reset() in range(actions[2])
    for _ in range(50):
        _, reward, done, info = env.step(env.action_space.sample())
        assert reward in (1.0, 0.0, -0.5, -1.0)
        if done:
            break
    assert done
    env.render()
    assert capsys.readouterr().out == f"{env.render(mode='ansi')}\n"
    assert f"step: {info['time']}\n" in env.render(mode="ansi")


def test_atari_make_accepts_them_but_not_with_a_preset() -> None:
    assert isinstance(atari.make("Copy-v0").unwrapped, algorithmic.CopyEnv)
    with pytest.raises(ValueError, match="a preset is for Atari games, and 'Copy-v0' is none"):
        atari.make("Copy-v0", preset="dqn2015")
