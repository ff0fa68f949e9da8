"""Cases of replay memories: a memory and its naive twin after a random stream, and the comparison of the two."""

import random
from typing import Any

import numpy as np
import pytest
from memory_streams import Stream, everything, row_of, same
from naive_memory import NaiveMemory

from atari.learning import ReplayMemory


def random_case(source: random.Random, seed: int) -> dict[str, Any]:
    """A case for `play`."""
    return {
        "lanes": source.randint(1, 5),
        "capacity": source.randint(1, 80),
        "shape": source.choice([(5, 6), (1, 4, 7), (3, 4, 3), (9,), (source.randint(1, 70),)]),
        "stack": source.randint(1, 5),
        "padding": source.choice(["zero", "reset"]),
        "mode": source.choice(["next_step", "same_step", "disabled"]),
        "compress": source.random() < 0.5,
        "ends": source.choice([0.0, 0.03, 0.2, 0.7]),
        "steps": source.randint(1, 120),
        "resets": source.choice([0.0, 0.0, 0.1]),
        "copied": source.random() < 0.5,
        "threads": source.randint(1, 2),
        "seed": seed,
    }


def play(case: dict, **options: object) -> tuple[ReplayMemory, NaiveMemory, Stream]:
    lanes, shape, mode = case["lanes"], case["shape"], case["mode"]
    memory = ReplayMemory(
        case["capacity"],
        lanes,
        shape,
        stack_num=case["stack"],
        padding=case["padding"],
        autoreset_mode=mode,
        compress=case["compress"],
        final_frames=None if mode == "next_step" else 4 * case["capacity"] + 8 * lanes,
        seed=case["seed"],
        num_threads=case["threads"],
        **options,
    )
    frame = shape[1:] if len(shape) >= 3 and shape[0] == 1 else shape
    naive = NaiveMemory(case["capacity"], lanes, frame, case["stack"], case["padding"], mode)
    stream = Stream(lanes, shape, mode, case["ends"], case["seed"])
    reshaped = Reshaped(naive, (lanes, *frame))
    stream.reset(memory, reshaped, first=True)
    for _ in range(case["steps"]):
        stream.step(memory, reshaped, copied=case["copied"])
        if stream.random.random() < case["resets"]:
            stream.reset(memory, reshaped)
    return memory, naive, stream


class Reshaped:
    """Gives frames without the axis of length 1 to a naive memory."""

    def __init__(self, naive: NaiveMemory, shape: tuple[int, ...]) -> None:
        self.naive, self.shape = naive, shape

    def reset(self, frames: np.ndarray, mask: object = None, first: bool = False) -> None:
        self.naive.reset(frames.reshape(self.shape), mask, first)

    def add(self, *arguments: object) -> None:
        *rest, frames, finals = arguments
        self.naive.add(*rest, frames.reshape(self.shape), finals.reshape(self.shape))


def compare(memory: ReplayMemory, naive: NaiveMemory, n: int, stack: int) -> None:
    wanted = naive.transitions(n, 0.9, stack)
    assert memory.count(n) == len(wanted)
    if not wanted:
        with pytest.raises(ValueError, match="no step to sample"):
            memory.sample(1, n=n)
        return
    found = everything(memory, n=n, gamma=0.9, stack_num=stack)
    assert sorted(found) == [row["indices"] for row in wanted]
    for row in wanted:
        same(found[row["indices"]], row)
    if n == 1:
        compare_shared(memory, {row["indices"]: row for row in wanted}, stack)


def compare_shared(memory: ReplayMemory, wanted: dict[int, dict], stack: int) -> None:
    batch = memory.make_batch(64, stack_num=stack, share=True)
    assert memory.sample(64, n=1, gamma=0.9, out=batch) is batch
    assert np.shares_memory(batch.frames, batch.observations)
    assert np.shares_memory(batch.frames, batch.next_observations)
    for i, index in enumerate(batch.indices):
        same(row_of(batch, i), wanted[int(index)])
