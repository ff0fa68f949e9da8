"""`spread`: where the environments stand afterwards, what decides it, and what it refuses."""

import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest

import atari
from atari import AtariVectorEnv
from atari.lab import Ram, spread

GAME = 200
"""Steps of a game in `limited`."""


def limited(count: int, **options: Any) -> AtariVectorEnv:
    """Games of Freeway that all end after `GAME` steps of four frames."""
    envs = AtariVectorEnv("freeway", count, preset="dqn2015", noops=(0, 0), max_frames=4 * GAME, **options)
    envs.reset(seed=0)
    return envs


def states(envs: AtariVectorEnv) -> list[bytes]:
    return [pickle.dumps(one.state) for one in envs.snapshot()]


def test_every_moment_of_a_game_is_equally_probable() -> None:
    envs = limited(400, obs_type="ram")
    info = spread(envs, 0)[1]
    steps = info["episode_frame_number"] // 4
    counts = np.histogram(steps, bins=10, range=(0, GAME))[0]
    assert counts.sum() == 400
    assert ((counts - 40) ** 2 / 40).sum() < 27.9  # chi-square, nine degrees of freedom, one in a thousand
    assert len(np.unique(steps)) > 120


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
@pytest.mark.parametrize("options", [{"preset": "dqn2015", "episodic_life": True}, {}, {"game": ["pong", "breakout"]}])
def test_games_go_on_from_there_in_each_mode(mode: str, options: dict[str, Any]) -> None:
    game = options.get("game", "breakout")
    given = {name: value for name, value in options.items() if name != "game"}
    envs = AtariVectorEnv(game if isinstance(game, str) else game * 4, 8, autoreset_mode=mode, **given)
    envs.reset(seed=0)
    info = spread(envs, 3)[1]
    assert len(np.unique(info["episode_frame_number"])) > 4
    assert not any(lane.ended for lane in envs.lanes)
    if "preset" in options:
        assert len(np.unique(info["lives"])) > 1  # over whole games, not within the first life
    before = info["episode_frame_number"]
    after = envs.step(np.zeros(8, np.int64))[4]["episode_frame_number"]
    assert ((after > before) & (after <= before + 4)).all()


def test_the_seed_decides_and_not_the_number_of_threads() -> None:
    first, second, third = (limited(12, num_threads=threads) for threads in (1, 3, 2))
    (one, _), (two, _), (other, _) = spread(first, 5), spread(second, 5), spread(third, 6)
    assert (one == two).all()
    assert states(first) == states(second) != states(third)
    assert (one != other).any()
    for _ in range(20):
        actions = np.arange(12) % 3
        assert (first.step(actions)[0] == second.step(actions)[0]).all()


def test_snapshots_and_copies_stand_there_too() -> None:
    envs = limited(4)
    observations, _ = spread(envs, 1)
    copy, kept = pickle.loads(pickle.dumps(envs)), envs.snapshot()
    assert (copy.observe()[0] == observations).all()
    envs.step(np.zeros(4, np.int64))
    envs.restore(None, kept)
    assert (envs.observe()[0] == observations).all()
    assert (envs.step(np.ones(4, np.int64))[0] == copy.step(np.ones(4, np.int64))[0]).all()


def test_a_policy_plays_up_to_the_moments() -> None:
    """UP alone crosses the road; random actions hardly do."""
    begun: list[tuple[str, int, int]] = []

    class Up:
        def begin(self, game: str, actions: tuple[str, ...], lanes: Any, seeds: Any) -> None:
            begun.append((game, len(lanes), len(seeds)))
            self.up = actions.index("UP")

        def __call__(self, observations: Any, lanes: Any) -> Any:
            assert len(observations) == len(lanes)
            return np.full(len(lanes), self.up)

    walked, random = limited(32), limited(32)
    spread(walked, 0, policy=Up())
    spread(random, 0)
    assert begun == [("freeway", 32, 32)]
    assert Ram(walked)["score_player"].sum() > Ram(random)["score_player"].sum() + 10


def test_a_policy_is_told_of_episodes_after_lost_lives() -> None:
    lives: dict[int, int] = {}

    class Watching:
        def begin_episodes(self, lanes: Any) -> None:
            for lane in lanes.tolist():
                lives[lane] = lives.get(lane, 0) + 1

        def __call__(self, observations: Any) -> Any:
            return np.ones(len(observations), np.int64)  # FIRE

    envs = AtariVectorEnv("breakout", 3, preset="dqn2015", episodic_life=True)
    envs.reset(seed=0)
    spread(envs, 0, policy=Watching())
    assert lives == dict.fromkeys(range(3), 4)


def test_an_error_of_the_policy_leaves_the_states() -> None:
    envs = limited(3)
    envs.step(np.ones(3, np.int64))
    before, calls = states(envs), iter(range(30))

    def policy(observations: Any) -> Any:
        next(calls)
        return np.zeros(len(observations), np.int64)

    with pytest.raises(StopIteration):
        spread(envs, 0, policy=policy)
    assert states(envs) == before
    with pytest.raises(ValueError, match=r"returned action 9; in freeway it has 3 actions"):
        spread(envs, 0, policy=lambda observations: [9] * len(observations))
    assert states(envs) == before


def test_steps_limit_the_moments_of_long_games() -> None:
    numbers = spread(limited(64), 0, steps=30)[1]["episode_frame_number"]
    assert 60 < numbers.max() <= 120


def test_a_wrapper_that_restores_is_played_itself() -> None:
    class Recorder(gymnasium.vector.VectorWrapper):
        def __init__(self, envs: Any) -> None:
            super().__init__(envs)
            self.calls: list[str] = []

        def step(self, actions: Any, **given: Any) -> Any:
            self.calls.append("step")
            return self.env.step(actions, **given)

        def snapshot(self, indices: Any = None) -> Any:
            return self.env.snapshot(indices)  # type: ignore[attr-defined]

        def restore(self, indices: Any, snapshots: Any) -> None:
            self.calls.append("restore")
            self.env.restore(indices, snapshots)  # type: ignore[attr-defined]

    wrapped, plain = Recorder(limited(4)), limited(4)
    assert (spread(wrapped, 2)[0] == spread(plain, 2)[0]).all()
    assert wrapped.calls == ["step"] * (GAME + 1) + ["restore"]  # the last step begins the next game


@pytest.mark.parametrize(
    ("given", "error", "match"),
    [
        ({"seed": -1}, ValueError, "seed"),
        ({"seed": 1.5}, TypeError, "seed"),
        ({"steps": 0}, ValueError, "steps"),
        ({"policy": 3}, TypeError, "a policy is a function"),
    ],
)
def test_wrong_arguments_change_nothing(given: dict[str, Any], error: type[Exception], match: str) -> None:
    envs = limited(2)
    before = states(envs)
    with pytest.raises(error, match=match):
        spread(envs, **{"seed": 0, **given})
    assert states(envs) == before


def test_other_environments_are_refused() -> None:
    with pytest.raises(TypeError, match="spread takes an AtariVectorEnv, got AtariEnv"):
        spread(atari.AtariEnv("pong"), 0)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"RecordEpisodeStatistics would not notice; give envs\.unwrapped"):
        spread(gymnasium.wrappers.vector.RecordEpisodeStatistics(limited(2)), 0)
    with pytest.raises(ValueError, match="got batch_size=2"):
        spread(AtariVectorEnv("pong", 4, batch_size=2), 0)
    with pytest.raises(ValueError, match="got continuous=True"):
        spread(AtariVectorEnv("pong", 2, continuous=True), 0)
    with pytest.raises(ValueError, match="got players=2"):
        spread(AtariVectorEnv("joust", 2, players=2), 0)
    with pytest.raises(gymnasium.error.ResetNeeded):
        spread(AtariVectorEnv("pong", 2), 0)
    several = AtariVectorEnv(["pong", "breakout"])
    several.reset(seed=0)
    with pytest.raises(ValueError, match="a policy plays one game, and the vector has pong, breakout"):
        spread(several, 0, policy=lambda observations: [0] * len(observations))
    sent = limited(2)
    sent.send(np.zeros(2, np.int64))
    with pytest.raises(RuntimeError):
        spread(sent, 0)
