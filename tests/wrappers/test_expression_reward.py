"""`ExpressionReward`: the reward of a single environment as an expression."""

from pathlib import Path
from typing import Any

import gymnasium
import pytest

import atari
from atari.recording import RecordReplay, Replay
from atari.wrappers import ClipReward, ExpressionReward, FrameSkip


def rewards(env: Any, count: int = 120) -> list[float]:
    paid = []
    for step in range(count):
        _, reward, terminated, truncated, _ = env.step(1 + step % 3)
        paid.append(reward)
        if terminated or truncated:
            env.reset()
    return paid


TEXT = "reward - 5 * lives_lost + 0.5 * (player_x - before.player_x)"


def test_the_wrapper_pays_what_the_task_pays() -> None:
    alone = ExpressionReward(FrameSkip(atari.make("BreakoutNoFrameskip-v4"), 4), TEXT)
    made = atari.make("BreakoutNoFrameskip-v4", frameskip=4, reward=TEXT)
    for env in (alone, made):
        env.reset(seed=1)
    paid = rewards(alone)
    assert paid == rewards(made)
    assert min(paid) < -4
    assert all(type(reward) is float for reward in paid)


def test_the_games_reward_is_in_the_info() -> None:
    env = ExpressionReward(gymnasium.make("ALE/Breakout-v5"), "100 * reward + 1")
    env.reset(seed=1)
    for step in range(200):
        _, reward, terminated, truncated, info = env.step(1 + step % 3)
        assert reward == 100 * info["reward"] + 1
        assert not terminated
        assert not truncated


@pytest.mark.parametrize("core", ["native", "plain", "ale"])
def test_the_cores_pay_the_same(core: str) -> None:
    env = atari.make("breakout", reward=TEXT, core=core)
    env.reset(seed=1)
    other = atari.make("breakout", reward=TEXT)
    other.reset(seed=1)
    assert rewards(env) == rewards(other)


def test_clipping_comes_after() -> None:
    env = atari.make("breakout", reward="5 + reward", reward_clipping=True)
    env.reset(seed=0)
    assert env.step(0)[1] == 1.0
    env = ClipReward(ExpressionReward(atari.make("breakout"), "5 + reward"), -2, 2)
    env.reset(seed=0)
    assert env.step(0)[1] == 2.0


def test_gymnasium_makes_it_again_from_its_spec() -> None:
    env = gymnasium.make("ALE/Breakout-v5", reward=f"  {TEXT}\n")
    assert env.unwrapped.whole_task == atari.Task.of("breakout", reward=TEXT)  # type: ignore[attr-defined]
    again = gymnasium.make(env.spec)  # type: ignore[arg-type]
    for one in (env, again):
        one.reset(seed=3)
    assert rewards(env) == rewards(again)


def test_a_snapshot_of_another_expression_is_refused() -> None:
    made: list[Any] = [atari.make("breakout", reward=text, reward_clipping=True) for text in ("reward", "lives", None)]
    for env in made:
        env.reset(seed=1)
    with pytest.raises(ValueError, match="taken with reward = 'reward', but this environment has 'lives'"):
        made[1].restore(made[0].snapshot())
    with pytest.raises(ValueError, match="taken with reward = None, but this environment has 'reward'"):
        made[0].restore(made[2].snapshot())
    alone = [ExpressionReward(atari.make("breakout"), text) for text in ("reward", "lives")]
    for one in alone:
        one.reset(seed=1)
    with pytest.raises(ValueError, match="other arguments of ExpressionReward"):
        alone[1].restore(alone[0].snapshot())


def test_a_replay_has_the_expression_and_the_games_own_rewards(tmp_path: Path) -> None:
    env = RecordReplay(atari.make("breakout", reward="-1", reward_clipping=True), tmp_path / "game.a26r")
    env.reset(seed=1)
    assert set(rewards(env, 60)) == {-1.0}
    env.close()
    replay = Replay.load(tmp_path / "game.a26r")
    assert replay.task == atari.Task.of("breakout", reward="-1", reward_clipping=True)
    assert {frame.reward for frame in replay.frames()} <= {0, 1}
