"""`RolloutActors` on a cluster: what is delivered, also when actors and nodes are lost."""

import copy
import logging
import os
import pickle
import signal
from typing import Any

import numpy as np
import pytest

import atari

ray = pytest.importorskip("ray", reason="Ray requires a Gymnasium of its own; run ./scripts/test --ray")
pytestmark = pytest.mark.ray

from atari.integrations.ray.rollout_actors import RolloutActors  # noqa: E402

SETTINGS: dict[str, Any] = {"steps": 32, "seed": 7, "preset": "dqn2015", "in_order": True, "snapshot_every": 3}


def policy() -> Any:
    """A maker of policies, sent by value: actors cannot import this module."""

    class Drawn:
        def __init__(self) -> None:
            self.offset = 0
            self.calls = 0

        def __call__(self, observations: Any, lanes: Any) -> Any:
            self.calls += 1
            actions = (self.random.integers(4, size=len(observations)) + self.offset) % 4
            return actions, {"pid": np.full(len(actions), os.getpid()), "calls": np.full(len(actions), self.calls)}

        def load(self, weights: Any) -> None:
            assert not weights["offset"].flags.writeable
            self.offset = int(weights["offset"][0])

        def begin(self, game: str, actions: Any, lanes: Any, seeds: Any) -> None:
            self.random = np.random.default_rng(seeds)

        def state(self) -> Any:
            return self.calls, self.random

        def restore(self, state: Any) -> None:
            self.calls, self.random = state

    return Drawn


def contents(rollout: Any) -> list[bytes]:
    names = ("observations_table", "actions", "rewards", "terminations", "truncations", "valid", "scores", "lengths")
    return [np.array(getattr(rollout, name)).tobytes() for name in names] + [rollout.extras["calls"].tobytes()]


def play(batches: int, kill: Any = None, **changes: Any) -> tuple[list[tuple[int, int, int]], list[list[bytes]], int]:
    """Keys and contents of some batches. After batch n, kill(n, rollout) may kill; weights change after 7 and 14."""
    keys, all_contents = [], []
    with RolloutActors("breakout", 2, 4, policy(), **{**SETTINGS, **changes}) as actors:
        for number in range(batches):
            rollout = next(actors)
            keys.append((rollout.actor, rollout.number, rollout.version))
            all_contents.append(contents(rollout))
            if number % 7 == 6:
                actors.set_weights({"offset": np.array([number])})
            if kill:
                kill(number, rollout)
        return keys, all_contents, actors.lost


def kill_minus_9(*numbers: int) -> Any:
    def kill(number: int, rollout: Any) -> None:
        if number in numbers:
            os.kill(int(rollout.extras["pid"][0, 0]), signal.SIGKILL)

    return kill


def test_batches_are_those_of_one_process(cluster: Any) -> None:
    keys, _, lost = play(12)
    assert lost == 0
    assert [key[:2] for key in keys] == [(number % 2, number // 2) for number in range(12)]
    with RolloutActors("breakout", 2, 4, policy(), **SETTINGS) as actors:
        rollouts = [rollout for rollout, _ in zip(actors, range(4), strict=False)]
        assert not rollouts[0].observations_table.flags.writeable  # a view of the object store
        for actor in range(2):
            envs = atari.AtariVectorEnv("breakout", 4, preset="dqn2015")
            seen, _ = envs.reset(seed=7 + 4 * actor)
            for rollout in rollouts[actor::2]:
                for row, actions in zip(rollout.observations, rollout.actions, strict=False):
                    assert (row == seen).all()
                    seen = envs.step(actions)[0]


def test_kill_minus_9_changes_nothing(cluster: Any, caplog: pytest.LogCaptureFixture) -> None:
    """Also of the successor of a killed actor, before its first batch, and between snapshots."""
    keys, expected, _ = play(24)
    assert len(set(keys)) == 24
    assert {version for *_, version in keys} == {0, 1, 2}
    with caplog.at_level(logging.WARNING, "atari.integrations.ray"):
        killed_keys, killed, lost = play(24, kill_minus_9(0, 5, 10, 16, 17))
    assert lost == 5
    assert killed_keys == keys  # none twice, none missing
    assert killed == expected
    messages = [record.getMessage() for record in caplog.records]
    assert len(messages) == 5
    assert "actor 0 was lost" in messages[0]
    assert "batches 1 to 2 (128 steps each) had not been delivered and are played again" in messages[0]
    assert "from their reset, with the actions of 1 delivered batches" in messages[0]
    assert "from the snapshot after batch" in messages[-1]


def test_a_lost_node_changes_nothing(cluster: Any) -> None:
    """Its actors and what lay in its object store are gone."""
    doomed = {"num_cpus": 1, "resources": {"doomed": 1}, "object_store_memory": 100 * 2**20}
    nodes = [cluster.add_node(**doomed)]
    options = {"actor_options": {"num_cpus": 0, "resources": {"doomed": 0.5}}}

    def kill(number: int, rollout: Any) -> None:
        if number == 5:
            nodes.append(cluster.add_node(**doomed))
            cluster.remove_node(nodes[0], allow_graceful=False)

    keys, expected, _ = play(12)
    lost_keys, after, lost = play(12, kill, **options)
    assert lost == 2
    cluster.remove_node(nodes[1])
    assert (lost_keys, after) == (keys, expected)


def test_batches_come_when_they_are_ready_and_each_once(cluster: Any) -> None:
    keys, _, _ = play(30, kill_minus_9(4, 11), in_order=False)
    assert len(set(keys)) == 30
    for actor in range(2):
        numbers = [number for index, number, _ in keys if index == actor]
        assert numbers == list(range(len(numbers)))


def test_no_more_batches_are_played_than_in_flight(cluster: Any, tmp_path: Any) -> None:
    class Counting:
        def __init__(self) -> None:
            self.file = open(tmp_path / str(os.getpid()), "ab", buffering=0)  # noqa: SIM115

        def __call__(self, observations: Any, lanes: Any) -> Any:
            self.file.write(b".")
            return np.zeros(len(observations), int)

    def played() -> int:
        return sum(file.stat().st_size for file in tmp_path.iterdir())

    with RolloutActors("pong", 1, 1, Counting, steps=10, in_flight=3) as actors:
        for number in range(1, 5):
            next(actors)
            ray.get([order.result for order in actors._seats[0].orders])
            assert played() == 10 * (number + 3)


def test_an_error_and_the_death_of_a_policy_are_raised(cluster: Any) -> None:
    def broken(observations: Any, lanes: Any) -> Any:
        raise ZeroDivisionError("of the policy")

    def deadly(observations: Any, lanes: Any) -> Any:
        os._exit(1)

    for policy, error, text in (
        (broken, ZeroDivisionError, "of the policy"),
        (deadly, RuntimeError, "was lost 6 times"),
    ):
        with RolloutActors("pong", 1, 1, policy) as actors, pytest.raises(error, match=text):
            next(actors)


def test_actors_refuse_to_be_copied(cluster: Any) -> None:
    with RolloutActors("pong", 1, 1, "noop", steps=4) as actors:
        for duplicate in (copy.deepcopy, pickle.dumps):
            with pytest.raises(TypeError, match="RolloutActors own processes on a cluster and cannot be copied"):
                duplicate(actors)


def test_arguments_are_checked_before_anything_starts(cluster: Any) -> None:
    for wrong, error in (
        ({"num_actors": 0}, ValueError),
        ({"policy": 3}, TypeError),
        ({"steps": 0}, ValueError),
        ({"in_flight": 0}, ValueError),
        ({"snapshot_every": 0}, ValueError),
        ({"seed": 2**32}, ValueError),
        ({"presett": "dqn2015"}, TypeError),
        ({"game": "no_such_game"}, ValueError),
    ):
        arguments = {"game": "pong", "num_actors": 2, "num_envs": 4, "policy": policy(), **wrong}
        with pytest.raises(error):
            RolloutActors(**arguments)


def test_snapshots_travel_between_workers(cluster: Any) -> None:
    """A state from one worker, by the object store, continues on another to the bit, as in this process."""

    @ray.remote(num_cpus=1, scheduling_strategy="SPREAD")
    class Explorer:
        def __init__(self) -> None:
            self.envs = atari.AtariVectorEnv("montezuma_revenge", 2, num_threads=1)
            self.envs.reset(seed=os.getpid())

        def explore(self, snapshots: Any, seed: int) -> Any:
            if snapshots is not None:
                self.envs.restore(None, snapshots)
            random = np.random.default_rng(seed)
            seen = [self.envs.step(random.integers(18, size=2))[:4] for _ in range(50)]
            return self.envs.snapshot(), pickle.dumps(seen), ray.get_runtime_context().get_node_id()

    explorers = [Explorer.remote() for _ in range(3)]
    start, _, _ = ray.get(explorers[0].explore.remote(None, 0))
    reference = ray.put(start)
    results = ray.get([explorer.explore.remote(reference, 1) for explorer in explorers])
    assert len({node for *_, node in results}) > 1
    envs = atari.AtariVectorEnv("montezuma_revenge", 2)
    envs.reset(seed=0)
    envs.restore(None, start)
    random = np.random.default_rng(1)
    here = pickle.dumps([envs.step(random.integers(18, size=2))[:4] for _ in range(50)])
    assert {seen for _, seen, _ in results} == {here}
