"""A replay memory that stores whole stacks, and every transition of every n: slow, and simple enough to check.

It has the arguments of `ReplayMemory` that tests use, and lists instead of arrays.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

Frame = np.ndarray


@dataclass
class Step:
    """A step of a lane, with the stacks before and after it."""

    index: int
    stack: Frame
    action: int
    reward: np.float32
    next_stack: Frame
    terminated: bool
    truncated: bool
    later: "Step | None" = None  # the next step of the episode
    cut: bool = False  # a reset followed before the episode had ended


@dataclass
class Lane:
    """An environment: the stack that an agent would see, and its steps."""

    frames: list[Frame] = field(default_factory=list)  # the frames of the episode
    waiting: bool = False
    steps: list[Step] = field(default_factory=list)
    last: Step | None = None  # the last step of the present episode


class NaiveMemory:
    def __init__(self, capacity: int, num_envs: int, shape: tuple[int, ...], stack: int, padding: str, mode: str):
        self.rows = -(-capacity // num_envs)
        self.shape, self.stack_num, self.padding, self.mode = shape, stack, padding, mode
        self.lanes = [Lane() for _ in range(num_envs)]
        self.row = 0

    def stack(self, frames: list[Frame], stack: int) -> Frame:
        frames = frames[-stack:]
        first = frames[0] if self.padding == "reset" else np.zeros_like(frames[0])
        return np.stack([first] * (stack - len(frames)) + frames)

    def observations(self) -> Frame:
        return np.stack([self.stack(lane.frames, self.stack_num) for lane in self.lanes])

    def reset(self, observations: Frame, mask: Any = None, first: bool = False) -> None:
        for i, lane in enumerate(self.lanes):
            if mask is not None and not mask[i]:
                continue
            if lane.last is not None and not lane.waiting:
                lane.last.cut = True
            lane.frames, lane.waiting, lane.last = [observations[i].copy()], False, None
        if mask is None and not first:
            self.row += 1

    def add(self, actions: Any, rewards: Any, terminated: Any, truncated: Any, observations: Any, finals: Any) -> None:
        for i, lane in enumerate(self.lanes):
            if lane.waiting:
                if self.mode == "next_step":
                    lane.frames, lane.waiting, lane.last = [observations[i].copy()], False, None
                else:
                    lane.frames.append(observations[i].copy())
                continue
            ended = bool(terminated[i] or truncated[i])
            after = finals[i] if ended and self.mode == "same_step" else observations[i]
            before = list(lane.frames)
            frames = [*before, after.copy()]
            index = self.row * len(self.lanes) + i
            step = Step(index, before, actions[i], np.float32(rewards[i]), frames, terminated[i], truncated[i])
            if lane.last is not None:
                lane.last.later = step
            lane.steps.append(step)
            if not ended:
                lane.frames, lane.last = list(frames), step
            elif self.mode == "same_step":
                lane.frames, lane.last = [observations[i].copy()], None
            else:
                lane.frames, lane.waiting, lane.last = list(frames), True, None
        self.row += 1

    def transition(self, step: Step, n: int, gamma: float, stack: int) -> dict[str, Any] | None:
        """The step in the form of `sample`, or None if n steps are not known."""
        total, discount, now = 0.0, 1.0, step
        for count in range(1, n + 1):
            total += discount * float(now.reward)
            discount *= gamma
            if now.terminated or now.truncated or now.cut or count == n:
                break
            if now.later is None:
                return None
            now = now.later
        return {
            "indices": step.index,
            "observations": self.stack(step.stack, stack),
            "actions": step.action,
            "rewards": np.float32(total),
            "next_observations": self.stack(now.next_stack, stack),
            "discounts": np.float32(0.0 if now.terminated else discount),
            "terminations": now.terminated,
            "truncations": bool(now.truncated or (now.cut and not now.terminated)),
        }

    def transitions(self, n: int, gamma: float, stack: int) -> list[dict[str, Any]]:
        """All transitions that can be sampled, in the order of their indices."""
        oldest = (self.row - self.rows) * len(self.lanes)
        steps = sorted((s for lane in self.lanes for s in lane.steps if s.index >= oldest), key=lambda s: s.index)
        found = [self.transition(step, n, gamma, stack) for step in steps]
        return [transition for transition in found if transition is not None]

    def sequence(self, index: int, length: int, stack: int) -> dict[str, Any]:
        lane = self.lanes[index % len(self.lanes)]
        step: Step | None = next(step for step in lane.steps if step.index == index)
        zero = np.zeros((stack, *self.shape), np.uint8)
        rows: list[dict[str, Any]] = []
        observations = [self.stack(step.stack, stack)] if step else []
        while step is not None and len(rows) < length:
            rows.append(self.transition(step, 1, 1.0, stack) or {})
            observations.append(rows[-1]["next_observations"])
            ended = step.terminated or step.truncated or step.cut
            step = None if ended else step.later
        missing = length - len(rows)
        return {
            "observations": np.stack(observations + [zero] * missing),
            "actions": [row["actions"] for row in rows] + [0] * missing,
            "rewards": [row["rewards"] for row in rows] + [0.0] * missing,
            "terminations": [row["terminations"] for row in rows] + [False] * missing,
            "truncations": [row["truncations"] for row in rows] + [False] * missing,
            "mask": [True] * len(rows) + [False] * missing,
        }
