"""A reward of the task's own: the same numbers from the vector, from single environments and from plain Python."""

from typing import Any

import gymnasium
import numpy as np
import pytest
import reward_reference as reference
from hypothesis import given, settings
from hypothesis import strategies as st
from lane_oracle import Lanes
from reward_strategies import expressions

import atari
from atari.lab import Ram

REWARD = "reward - 5 * lives_lost + 0.1 * (player_x - before.player_x) + 0.001 * before.ram[0xC6]"
TASKS: dict[str, dict[str, Any]] = {
    "frames": {"frameskip": 1},
    "skip": {"frameskip": (2, 5), "noops": (1, 8)},
    "lives": {
        "preset": "baselines",
        "episodic_life": True,
        "img_height": 42,
        "img_width": 42,
        "reward_clipping": False,
    },
    "lives go on": {"preset": "dqn2015", "img_height": 42, "img_width": 42, "reward_clipping": False},
    "clipped": {"preset": "dqn2015", "img_height": 42, "img_width": 42},
    "ale": {"preset": "ale_vector", "img_height": 42, "img_width": 42, "reward_clipping": False},
    "reported lives": {"life_loss_info": True, "obs_type": "ram", "max_episode_steps": 40},
}


def task(name: str, game: str = "breakout", reward: str = REWARD) -> atari.Task:
    return atari.Task.of(game, reward=reward, **TASKS[name])


class PaidByPython(gymnasium.Wrapper[Any, Any, Any, Any]):
    """A single environment whose rewards are those of plain Python."""

    def __init__(self, played: atari.Task) -> None:
        super().__init__(atari.make(played))
        self.played = played

    def now(self) -> reference.Moment:
        core = self.env.unwrapped.core  # type: ignore[attr-defined]
        return reference.Moment(core.ram(), core.lives)

    def reset(self, **arguments: Any) -> Any:
        result = self.env.reset(**arguments)
        self.before = self.now()
        return result

    def step(self, action: Any) -> Any:
        observation, reward, *ends, info = self.env.step(action)
        now = self.now()
        now = reference.after(self.before, now.ram, now.lives, float(info["reward"]))
        expected = reference.value(self.played.game, str(self.played.reward), now, self.before)
        assert type(reward) is float
        assert reward == (min(max(expected, -1.0), 1.0) if self.played.reward_clipping else expected)
        self.before = now
        return observation, reward, *ends, info

    def snapshot(self) -> Any:
        return self.env.snapshot(), self.before  # type: ignore[attr-defined]

    def restore(self, saved: Any) -> None:
        self.env.restore(saved[0])  # type: ignore[attr-defined]
        self.before = saved[1]


def paid(played: atari.Task, seed: int, steps: int) -> set[float]:
    """The rewards of random steps of a lane of a vector beside a single environment; halfway both return to a snapshot."""
    lanes, generator, seen = Lanes([played], "NextStep", [PaidByPython(played)]), np.random.default_rng(seed), set()
    lanes.reset(seed)
    for step in range(steps):
        lanes.step(lanes.sample(generator))
        seen.add(lanes.lanes[0].reward)
        if step == steps // 3:
            lanes.save()
        if step == steps // 2:
            lanes.restore([0])
    lanes.close()
    return seen


@pytest.mark.parametrize("name", TASKS)
def test_single_environments_vectors_and_plain_python_are_equal(name: str) -> None:
    rewards = paid(task(name), 3, 250)
    assert len(rewards) > 5
    if "lives" in name:
        assert min(rewards) <= -4


@settings(max_examples=12, deadline=None)
@given(data=st.data())
def test_random_expressions(data: st.DataObject) -> None:
    game = data.draw(st.sampled_from(["pong", "montezuma_revenge", "seaquest"]))
    played = atari.Task.of(game, obs_type="ram", reward=data.draw(expressions(game)), noops=(0, 9))
    paid(played, data.draw(st.integers(0, 99)), 80)


def test_a_snapshot_of_another_reward_is_refused() -> None:
    envs = [atari.AtariVectorEnv("pong", 1, reward=reward) for reward in ("reward", "lives", None)]
    for one in envs:
        one.reset(seed=0)
    for source in envs:
        for other in envs:
            if source is other:
                other.restore(None, source.snapshot())
            else:
                with pytest.raises(ValueError, match="taken with reward = "):
                    other.restore(None, source.snapshot())


def test_true_scores_stay_in_info() -> None:
    envs = atari.AtariVectorEnv("pong", 4, reward="-1", preset="dqn2015", autoreset_mode="SameStep")
    plain = atari.AtariVectorEnv("pong", 4, preset="dqn2015", autoreset_mode="SameStep")
    assert not envs.reset(seed=0)[1].keys() ^ plain.reset(seed=0)[1].keys()
    scores: list[list[float]] = [[], []]
    while not scores[0]:
        for one, found in zip((envs, plain), scores, strict=True):
            _, rewards, *_, info = one.step(np.zeros(4, int))
            assert one is plain or (rewards == -1).all()
            if "final_info" in info and "episode" in info["final_info"]:
                found += info["final_info"]["episode"]["r"].tolist()
    assert scores[0] == scores[1]
    assert min(scores[0]) <= -20


def test_games_of_a_vector_have_their_own_labels() -> None:
    envs = atari.AtariVectorEnv(["pong", "breakout"], reward="player_x", reward_clipping=False)
    envs.reset(seed=0)
    _, rewards, *_ = envs.step(np.zeros(2, int))
    assert rewards.tolist() == [Ram(envs, index=lane)["player_x"] for lane in range(2)]
    assert rewards[0] != rewards[1]
    with pytest.raises(ValueError, match=r"'enemy_y'.*RAM labels of breakout"):
        atari.AtariVectorEnv(["pong", "breakout"], reward="enemy_y")


def test_several_players_have_none() -> None:
    with pytest.raises(ValueError, match="reward='lives' is for one player; leave it or players=2 out"):
        atari.AtariVectorEnv("pong", 1, players=2, reward="lives")


@pytest.mark.parametrize("wrong", [5, b"reward", ["reward"], True])
def test_a_reward_is_a_text(wrong: Any) -> None:
    with pytest.raises(TypeError, match="reward must be None, for the game's own, or an expression"):
        atari.AtariVectorEnv("pong", 1, reward=wrong)


def test_torch_and_float32() -> None:
    torch = pytest.importorskip("torch")
    from atari.integrations.torch import TorchEnvs

    envs = TorchEnvs(atari.AtariVectorEnv("pong", 2, reward="0.1"))
    envs.reset(seed=0)
    _, rewards, *_ = envs.step(torch.zeros(2, dtype=torch.int64))
    assert rewards.tolist() == [0.1, 0.1]
