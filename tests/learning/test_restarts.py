"""Restarts near the ends of good games: what is kept, which environments restart, and that a resume is exact."""

import json
import math
import pickle
import zlib
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from small_trainings import make_options  # noqa: E402

import atari  # noqa: E402
from atari.learning import TrainingEnvironments, restarts  # noqa: E402
from atari.learning.agents import find_agent  # noqa: E402
from atari.learning.frontier import write_frontier  # noqa: E402
from atari.learning.restarts import EVERY, KEPT, LEAST, RING  # noqa: E402
from atari.learning.training import Training  # noqa: E402


def environments(**given: Any) -> TrainingEnvironments:
    options = make_options("pqn", "breakout", num_envs=8, workers=1, **given)
    return TrainingEnvironments(options, 8, restart_share=0.25)


def play(envs: TrainingEnvironments, steps: int, rng: np.random.Generator) -> list[Any]:
    actions = len(envs.actions)
    return [envs.step(rng.integers(actions, size=envs.num_envs))[0].copy() for _ in range(steps)]


@pytest.fixture(scope="module")
def played() -> Any:
    """Environments that have restarted, and the observations of all steps."""
    envs = environments()
    first = envs.reset(seed=0)
    rng = np.random.default_rng(0)
    seen = [first.copy()]
    while envs.restarts.count < 20:
        seen += play(envs, 100, rng)
    yield envs, seen
    envs.close()


def test_a_share_of_the_environments_restarts_and_has_no_score(played: Any) -> None:
    envs, _ = played
    assert envs.restarts.restarted.tolist() == [True, False, False, False] * 2
    assert envs.scored.tolist() == [False, True, True, True] * 2


@pytest.mark.parametrize(("others", "num_envs"), [(None, 8), ("freeway", 8), ("freeway,pong,qbert", 16)])
def test_the_share_is_of_the_environments_of_each_game(others: str | None, num_envs: int) -> None:
    options = make_options("pqn", "breakout", num_envs=num_envs, workers=1, more_games=others, actions="full")
    envs = TrainingEnvironments(options, num_envs, restart_share=0.25)
    games = np.arange(num_envs) % len(options.tasks)
    assert {game: envs.restarts.restarted[games == game].mean() for game in games} == dict.fromkeys(games, 0.25)
    assert not (envs.scored & envs.restarts.restarted).any()
    envs.close()


@pytest.mark.parametrize(("others", "num_envs", "count"), [(None, 1, 1), ("freeway", 2, 1), ("freeway", 3, 1)])
def test_a_game_whose_environments_all_restart_is_refused(others: str | None, num_envs: int, count: int) -> None:
    options = make_options("pqn", "breakout", num_envs=12, workers=1, more_games=others, actions="full")
    with pytest.raises(ValueError, match=f"restart_share=0.25 none of the {count} environments of .* plays whole"):
        TrainingEnvironments(options, num_envs, restart_share=0.25)


def test_what_is_kept(played: Any) -> None:
    restarts = played[0].restarts
    (ring,), (lives,) = restarts._rings, restarts._lives
    assert LEAST <= len(ring) <= RING
    assert all(len(trail) <= KEPT for trail in restarts._trails)
    bar = np.quantile(lives, 0.75)
    assert restarts.frontier == np.median([score for _, _, score in ring])
    assert bar > np.median(lives)  # so that it chooses


def test_observations_after_a_restart_are_those_of_the_snapshots(played: Any) -> None:
    """An environment that has just restarted shows what the snapshot's environment saw, and goes on from there."""
    envs, _ = played
    before, restarts = envs.restarts.count, envs.restarts
    rng = np.random.default_rng(1)
    while restarts.count == before:
        observations, *_ = envs.step(rng.integers(len(envs.actions), size=8))
    now, _ = envs._envs.observe()
    np.testing.assert_array_equal(observations, now)
    kept = [image.tobytes() for _, image, _ in restarts._rings[0]]
    assert sum(observations[lane].tobytes() in kept for lane in (0, 4)) >= restarts.count - before


@pytest.mark.parametrize("agent", ["ppo", "pqn"])
def test_a_resumed_training_has_the_same_weights(agent: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, few in (("EVERY", 5), ("LEAST", 2), ("LIVES", 20)):
        monkeypatch.setattr(restarts, name, few)
    options = make_options(agent, "breakout", num_envs=8, workers=1, total_steps=10**6, restart_share=0.25)
    with closing(find_agent(agent)(options)) as first, closing(find_agent(agent)(options)) as second:
        while not any(one.restarts.count for one in first.environments):
            first.update()
        state = pickle.loads(pickle.dumps(first.state()))
        second.restore(state)
        rows = [(first.update(), second.update()) for _ in range(20)]
        assert all(one == other for one, other in rows)
        for one, other in zip(first.network.parameters(), second.network.parameters(), strict=True):
            assert torch.equal(one, other)
        assert first.environments[0].restarts.count == second.environments[0].restarts.count


def test_without_a_share_nothing_restarts() -> None:
    with closing(find_agent("pqn")(make_options("pqn"))) as agent:
        assert agent.environments[0].restarts is None
        assert pickle.loads(zlib.decompress(agent.environments[0].state()))[1] is None


def test_before_the_first_snapshot_there_is_no_frontier() -> None:
    envs = environments()
    assert math.isnan(envs.restarts.frontier)
    envs.close()


@pytest.mark.parametrize("agent", ["ppo", "pqn"])
def test_all_environments_cannot_restart(agent: str) -> None:
    with pytest.raises(ValueError, match="restart_share must be below 1"):
        make_options(agent, restart_share=1.0)


def test_a_snapshot_is_taken_every_hundred_steps() -> None:
    envs = environments()
    envs.reset(seed=0)
    play(envs, EVERY, np.random.default_rng(0))
    assert all(len(trail) <= 1 for trail in envs.restarts._trails)
    envs.close()


@pytest.fixture
def file(tmp_path: Path) -> str:
    """Two states of Breakout with the scores 100 and 102, of an evaluation: its games are whole, and not clipped."""
    task = make_options("pqn", "breakout").task.replace(episodic_life=False, reward_clipping=False, noops=(0, 0))
    path = tmp_path / "breakout.frontier"
    with closing(atari.AtariVectorEnv(task, 2)) as envs:
        envs.reset(seed=3)
        for step in range(12):
            envs.step(np.array([1 + step % 3, 1]))
        write_frontier(path, task, envs.snapshot(), [100, 102])
    return str(path)


@pytest.mark.parametrize("agent", ["ppo", "pqn"])
def test_environments_restart_from_the_states_of_a_file(agent: str, file: str) -> None:
    """All restarts are from the file, whose states stay the only ones; the other environments play whole games."""
    options = make_options(agent, "breakout", num_envs=8, workers=1, restart_share=0.25, restart_from=file)
    envs = TrainingEnvironments(options, 8, restart_share=0.25, restart_from=file)
    envs.reset(seed=0)
    rng, made, seen, scores = np.random.default_rng(0), envs.restarts, set(), set()
    assert made is not None
    while made.count < 20:
        before = made.count
        observations, _, terminations, truncations, _ = envs.step(rng.integers(4, size=8))
        for lane in np.flatnonzero((terminations | truncations) & made.restarted).tolist():
            seen.add(observations[lane].tobytes())
            scores.add(made._scores[lane])
        assert made.count - before == ((terminations | truncations) & made.restarted).sum()
    assert scores == {100, 102}
    assert seen == {image.tobytes() for _, image, _ in made._rings[0]}
    assert made.frontier == 101
    envs.close()


@pytest.mark.parametrize("agent", ["ppo", "pqn"])
def test_a_resumed_training_needs_no_file(agent: str, file: str, tmp_path: Path) -> None:
    """A checkpoint has the states of the file; two trainings that go on from it have equal weights."""
    code = find_agent(agent)
    given = {"num_envs": 8, "workers": 1, "total_steps": 10**6, "restart_share": 0.25, "restart_from": file}
    training = Training.begin(code, make_options(agent, "breakout", **given), tmp_path / "run")
    while training.agent.environments[0].restarts.count < 3:
        training.agent.update()
    training.save()
    rows = [training.agent.update() for _ in range(10)]
    before = training.agent.environments[0].restarts
    training.close()
    assert json.loads((tmp_path / "run" / "config.json").read_text())["options"]["restart_from"] == file
    Path(file).unlink()
    with closing(Training.resume(tmp_path / "run")) as resumed:
        assert [resumed.agent.update() for _ in range(10)] == rows
        again = resumed.agent.environments[0].restarts
        assert (again.count, again.frontier) == (before.count, 101)


@pytest.mark.parametrize("agent", ["ppo", "pqn"])
def test_what_cannot_restart_from_a_file(agent: str, file: str, tmp_path: Path) -> None:
    bad: list[tuple[str, dict[str, Any], type[Exception], str]] = [
        ("breakout", {"restart_from": file}, ValueError, "which is 0; add restart_share=0.25"),
        ("pong", {}, ValueError, "cannot be used by this task: .* with game = 'breakout', but"),
        ("breakout", {"stack_num": 4}, ValueError, "with stack_num = 2, but this environment has 4"),
        ("breakout", {"more_games": "pong", "actions": "full"}, ValueError, "of one game; leave it or more_games out"),
        ("breakout", {"restart_from": str(tmp_path / "none")}, FileNotFoundError, "none"),
    ]
    for game, given, error, text in bad:
        share = {} if given == {"restart_from": file} else {"restart_share": 0.25, "restart_from": file}
        with pytest.raises(error, match=text):
            make_options(agent, game, **{**share, **given})
