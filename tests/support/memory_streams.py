"""Streams of experience that vector environments could give, with random ends, for a memory and its naive twin."""

from typing import Any

import numpy as np

from atari.learning import ReplayMemory


class Stream:
    """Plays random steps into a memory, and its naive twin. `ends` is the probability of an end at each step."""

    def __init__(self, lanes: int, shape: tuple[int, ...], mode: str, ends: float, seed: int) -> None:
        self.lanes, self.shape, self.mode, self.ends = lanes, shape, mode, ends
        self.random = np.random.default_rng(seed)
        self.waiting = np.zeros(lanes, bool)

    def frames(self) -> np.ndarray:
        """Frames with few values and repeated rows, like those that compression receives."""
        frames = self.random.integers(0, 4, (self.lanes, *self.shape)).astype(np.uint8)
        if self.random.random() < 0.5:
            frames[...] = frames[..., :1]
        return frames

    def reset(self, memory: ReplayMemory, naive: Any = None, first: bool = False) -> None:
        frames = self.frames()
        memory.reset(frames)
        if naive is not None:
            naive.reset(frames, first=first)
        self.waiting[:] = False

    def step(self, memory: ReplayMemory, naive: Any = None, copied: bool = False) -> None:
        random, lanes = self.random, self.lanes
        actions, frames, finals = random.integers(0, 18, lanes), self.frames(), self.frames()
        rewards = random.normal(size=lanes).astype(np.float32)
        terminated, truncated = random.random(lanes) < self.ends, random.random(lanes) < self.ends / 2
        info = {"final_obs": finals} if self.mode == "same_step" else {}
        if copied:
            memory.add(actions, rewards, terminated, truncated, info, observations=frames)
        else:
            memory.frames()[...] = frames
            memory.add(actions, rewards, terminated, truncated, info)
        if naive is not None:
            naive.add(actions, rewards, terminated, truncated, frames, finals)
        ended = (terminated | truncated) & ~self.waiting
        if self.mode == "next_step":
            self.waiting = ended
        if self.mode == "disabled":
            self.waiting |= ended
        if self.mode != "next_step":
            for mask in self.masks():
                frames = self.frames()
                memory.reset(frames, mask)
                if naive is not None:
                    naive.reset(frames, mask)
                self.waiting &= ~mask

    def masks(self) -> list[np.ndarray]:
        """The resets before the next step, in any order of lanes: after ends, and of lanes that have not ended."""
        random, lanes = self.random, self.lanes
        chosen = self.waiting & (random.random(lanes) < 0.7)
        if random.random() < 0.1:
            chosen |= random.random(lanes) < 0.4
        order = random.permutation(np.flatnonzero(chosen))
        groups = np.split(order, np.sort(random.integers(0, len(order) + 1, random.integers(0, 3))))
        if random.random() < 0.1 and len(order):
            groups.append(order[:1])  # a lane that was reset already
        return [np.isin(np.arange(lanes), group) for group in groups if len(group)]


def everything(memory: ReplayMemory, **options: Any) -> dict[int, dict[str, Any]]:
    """All transitions that can be sampled, by index: draws until each has occurred."""
    found: dict[int, dict[str, Any]] = {}
    wanted = memory.count(options.get("n", 1))
    for _ in range(200):
        if len(found) == wanted:
            return found
        batch = memory.sample(4 * wanted + 16, **options)
        for i, index in enumerate(batch.indices):
            found.setdefault(int(index), row_of(batch, i))
    raise AssertionError(f"found {len(found)} of {wanted} steps")


FIELDS = (
    "observations",
    "actions",
    "rewards",
    "next_observations",
    "discounts",
    "terminations",
    "truncations",
    "indices",
)


def row_of(batch: Any, i: int) -> dict[str, Any]:
    return {name: getattr(batch, name)[i].copy() for name in FIELDS}


def same(found: dict[str, Any], wanted: dict[str, Any]) -> None:
    for name, value in wanted.items():
        got = np.asarray(found[name])
        assert np.array_equal(got, np.asarray(value).reshape(got.shape)), name
