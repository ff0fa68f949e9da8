"""Replay memories against a naive one: modes, orders of resets, files, compression, priorities, threads."""

import random
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from memory_cases import compare, play, random_case

from atari.learning import ReplayMemory


def attack(seed: int) -> None:
    source = random.Random(seed)
    attack_stream(source, seed)
    attack_priorities(source, seed)
    if seed % 4 == 0:
        attack_threads(source)


def attack_stream(source: random.Random, seed: int) -> None:
    """A random stream: the memory, its copy, and its file that is opened again, equal the naive one."""
    case = random_case(source, seed)
    n, stack = source.choice([1, 2, 3, 7, 40]), source.randint(1, case["stack"])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "replay")
        options = {"path": path, "margin": source.randint(0, 40)} if source.random() < 0.5 else {}
        memory, naive, _ = play(case, **options)
        compare(memory, naive, n, stack)
        if memory.steps:
            other, _, _ = play(
                {**case, "steps": 1},
                **({"path": path.with_name("other"), "margin": options["margin"]} if options else {}),
            )
            other.restore(memory.state())
            compare(other, naive, n, stack)
            other.close()
        if options:
            memory.flush()
            memory.close()
            with ReplayMemory.open(path) as memory:
                compare(memory, naive, n, stack)
        memory.close()


def attack_priorities(source: random.Random, seed: int) -> None:
    """Priorities of any size: draws stay finite, and steps are drawn by their shares."""
    lanes, exponent = source.randint(1, 3), source.choice([0.0, 0.5, 1.0, 3.0])
    memory = ReplayMemory(40, lanes, (4,), stack_num=1, priority_exponent=exponent, seed=seed)
    no, zeros = np.zeros(lanes, bool), np.zeros(lanes, int)
    memory.reset(np.zeros((lanes, 4), np.uint8))
    for _ in range(30):
        memory.add(zeros, np.zeros(lanes), no, no, observations=np.zeros((lanes, 4), np.uint8))
        batch = memory.sample(8, beta=source.random())
        assert np.isfinite(batch.weights).all()
        assert (batch.weights > 0).all()
        most = 100 / max(exponent, 1)
        values = [source.choice([0.0, 1.0, 10 ** source.uniform(-most, most), source.random()]) for _ in range(8)]
        memory.update_priorities(batch.indices, np.array([*values[:-1], 1.0]))
    for bad in (-1.0, float("nan"), float("inf"), 1e308):
        before = memory.state()["block"]
        try:
            memory.update_priorities(batch.indices[:1], np.array([bad]))
        except ValueError:
            assert (memory.state()["block"] == before).all()
        else:
            raise AssertionError(f"the priority {bad} was taken")


def attack_threads(source: random.Random) -> None:
    """Threads that add, sample, copy and restore: every step has the frame of its own call."""
    memory = ReplayMemory(400, 2, (50,), stack_num=1, autoreset_mode="disabled", seed=0)
    no = np.zeros(2, bool)
    memory.reset(np.zeros((2, 50), np.uint8))

    def work(value: int) -> None:
        own = random.Random(value)
        for _ in range(60):
            frames = np.full((2, 50), value, np.uint8)
            memory.add(np.full(2, value), np.full(2, value), no, no, observations=frames)
            match own.randrange(6):
                case 0:
                    memory.reset(frames, np.array([True, False]))
                case 1:
                    memory.restore(memory.state())
                case _:
                    check(memory.sample(8))

    with ThreadPoolExecutor(3) as pool:
        list(pool.map(work, source.sample(range(1, 200), 3)))


def check(batch: Any) -> None:
    for frame, action, reward in zip(batch.next_observations, batch.actions, batch.rewards, strict=True):
        values = np.unique(frame)
        assert len(values) == 1, "a frame of two threads"
        assert action == reward, "an action and a reward of two threads"
