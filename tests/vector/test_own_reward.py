"""A reward of the task's own: the same numbers from the vector, from single environments and from plain Python."""

import copy
from typing import Any

import numpy as np
import pytest
import reward_reference as reference
from hypothesis import given, settings
from hypothesis import strategies as st
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


class Twins:
    """A single environment and a lane of a vector, with plain Python's reward beside them."""

    def __init__(self, played: atari.Task, seed: int = 3) -> None:
        self.task = played
        self.env = atari.make(played)
        self.envs = atari.AtariVectorEnv(played, 1, num_threads=1, autoreset_mode="NextStep")
        self.env.reset(seed=seed)
        self.envs.reset(seed=seed)
        self.source = np.random.default_rng(seed)
        self.before = self.now()
        self.ended = False

    def now(self) -> reference.Moment:
        core = self.env.unwrapped.core  # type: ignore[attr-defined]
        return reference.Moment(core.ram(), core.lives)

    def step(self) -> float:
        action = int(self.source.integers(self.env.action_space.n))  # type: ignore[attr-defined]
        if self.ended:
            self.env.reset()
            _, rewards, *_ = self.envs.step(np.array([action]))
            self.ended, self.before = False, self.now()
            assert rewards[0] == 0
            return 0.0
        _, reward, terminated, truncated, info = self.env.step(action)
        _, rewards, terminations, truncations, infos = self.envs.step(np.array([action]))
        now = self.now()
        now = reference.after(self.before, now.ram, now.lives, float(info["reward"]))
        expected = reference.value(self.task.game, str(self.task.reward), now, self.before)
        if self.task.reward_clipping:
            expected = min(max(expected, -1.0), 1.0)
        assert (rewards.dtype, rewards.shape) == (np.float64, (1,))
        assert type(reward) is float
        assert reward == rewards[0] == expected
        assert info["reward"] == infos["reward"][0]
        assert (terminated, truncated) == (terminations[0], truncations[0])
        self.ended = truncated or (terminated and (not self.task.life_loss_info or info["terminated"]))
        self.before = now
        return float(reward)


@pytest.mark.parametrize("name", TASKS)
def test_single_environments_vectors_and_plain_python_are_equal(name: str) -> None:
    twins = Twins(task(name))
    paid = {twins.step() for _ in range(250)}
    assert len(paid) > 5
    if "lives" in name:
        assert min(paid) <= -4


@settings(max_examples=12, deadline=None)
@given(data=st.data())
def test_random_expressions(data: st.DataObject) -> None:
    game = data.draw(st.sampled_from(["pong", "montezuma_revenge", "seaquest"]))
    played = atari.Task.of(game, obs_type="ram", reward=data.draw(expressions(game)), noops=(0, 9))
    twins = Twins(played, data.draw(st.integers(0, 99)))
    for step in range(60):
        if step == 30:
            saved = twins.env.snapshot(), twins.envs.snapshot(), copy.deepcopy(twins.source), twins.before  # type: ignore[attr-defined]
            ended, expected = twins.ended, [twins.step() for _ in range(20)]
            twins.env.restore(saved[0])  # type: ignore[attr-defined]
            twins.envs.restore(None, saved[1])
            twins.source, twins.before, twins.ended = *saved[2:], ended
            assert [twins.step() for _ in range(20)] == expected
        twins.step()


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
