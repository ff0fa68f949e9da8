"""`evaluate` with workers and in parts: the same scores to the bit as in this process; on Ray in tests/distributed."""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import pytest

from atari.learning import PROTOCOLS, evaluate

PROTOCOL = replace(PROTOCOLS["dqn2015"], name="short", max_frames=300, epsilon=0.3)


class Here:
    """Does tasks in this process, and counts them."""

    def __init__(self):
        self.sizes = []

    def map(self, function, tasks):
        for task in tasks:
            self.sizes.append(len(task.seeds))
            yield function(task)


def test_other_processes_give_the_same_result():
    given = ({"pong": "noop", "breakout": "random"}, ["pong", "breakout"], PROTOCOL)
    here = evaluate(*given, episodes=4, seed=3)
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        assert evaluate(*given, episodes=4, seed=3, workers=pool, parts=2) == here


@pytest.mark.parametrize("parts", [1, 2, 3, 5])
def test_parts_do_not_matter(parts):
    def play(**options):
        return evaluate("random", ["pong", "breakout"], PROTOCOL, episodes=5, seed=1, **options)

    here, workers = play(), Here()
    assert play(parts=parts) == play(parts=parts, workers=workers, num_envs=2) == here
    assert sorted(workers.sizes) == sorted([len(range(part, 5, parts)) for part in range(parts)] * 2)


def test_without_parts_a_policy_sees_the_same_batches():
    seen = []

    def policy(observations, lanes):
        seen.append((observations.copy(), lanes.copy()))
        return [0] * len(lanes)

    for workers in (None, Here()):
        evaluate(policy, "pong", PROTOCOL, episodes=5, num_envs=2, workers=workers)
    half = len(seen) // 2
    assert [observations.tobytes() for observations, _ in seen[:half]] == [part.tobytes() for part, _ in seen[half:]]
    assert [lanes.tolist() for _, lanes in seen[:half]] == [lanes.tolist() for _, lanes in seen[half:]]


def test_progress_is_reported_after_each_task():
    reported = []
    options = {"episodes": 5, "workers": Here(), "parts": 2}
    evaluate("noop", ["pong", "qbert"], PROTOCOL, progress=lambda *counts: reported.append(counts), **options)
    assert reported == [(0, 10), (3, 10), (5, 10), (8, 10), (10, 10)]


def test_workers_with_another_version_are_refused():
    class Old(Here):
        def map(self, function, tasks):
            return super().map(function, [replace(task, version="0.0.1") for task in tasks])

    with pytest.raises(RuntimeError, match=r"begun with 0\.0\.1"):
        evaluate("noop", "pong", PROTOCOL, episodes=1, workers=Old())


@pytest.mark.parametrize(
    ("wrong", "error"),
    [({"workers": "dask"}, ValueError), ({"workers": 3}, TypeError), ({"parts": 0}, ValueError), ({"parts": 3}, ValueError)],
)  # fmt: skip
def test_wrong_workers_are_refused(wrong, error):
    with pytest.raises(error):
        evaluate("noop", "pong", PROTOCOL, episodes=2, **wrong)
