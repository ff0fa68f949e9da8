"""Calls of a `ReplayMemory` are atomic: what one thread adds, no other thread sees in part or mixes."""

import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from atari.learning import ReplayMemory

SHAPE = (20, 30)


def together(*works: Callable[[int], Any], rounds: int) -> None:
    """Run functions in a thread each, many times, and raise the first error."""
    errors: list[BaseException] = []
    start = threading.Barrier(len(works))

    def run(work: Callable[[int], Any]) -> None:
        try:
            start.wait()
            for i in range(rounds):
                work(i)
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=run, args=(work,)) for work in works]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if errors:
        raise errors[0]


@pytest.mark.parametrize("file", [False, True])
def test_each_call_is_atomic(tmp_path: Any, file: bool) -> None:
    """The number of an action fills the frames after it, the rewards, and so every sample."""
    path = tmp_path / "replay" if file else None
    memory = ReplayMemory(300, 2, SHAPE, stack_num=1, autoreset_mode="same_step", seed=0, path=path)
    memory.reset(np.zeros((2, *SHAPE), np.uint8))
    no = np.zeros(2, bool)
    numbers = iter(range(1, 10**6))

    def step() -> None:
        number = next(numbers)
        frames = np.full((2, *SHAPE), number % 251, np.uint8)
        memory.add(np.full(2, number), np.full(2, number % 251, float), no, no, observations=frames)

    def add(_: int) -> None:
        step()

    def sample(_: int) -> None:
        batch = memory.sample(16)
        assert (batch.next_observations == batch.next_observations[:, :1, :1]).all()
        assert (batch.observations == batch.observations[:, :1, :1]).all()
        whole = batch.next_observations[:, 0, 0]
        kept = (whole == batch.rewards) | batch.truncations  # a mask reset makes other last observations
        assert kept.all()
        assert (batch.actions % 251 == batch.rewards).all()

    def reset(i: int) -> None:
        if i % 20 == 0:
            memory.reset(np.full((2, *SHAPE), 255, np.uint8), np.array([i % 40 == 0, True]))
            memory.observations()

    def restore(i: int) -> None:
        if i % 100 == 50:
            memory.restore(memory.state())
        assert len(memory) <= memory.count(1) + 300

    step()
    together(add, add, add, sample, sample, reset, restore, rounds=300)
    memory.close()


def test_a_handler_may_use_the_memory_of_its_thread() -> None:
    """A call within a call, as a signal handler makes it, does not wait for itself."""
    memory = ReplayMemory(10, 1, SHAPE)
    with memory._lock:
        memory.reset(np.zeros((1, *SHAPE), np.uint8))
        memory.close()
