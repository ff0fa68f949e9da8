"""Observations of any kind, dtype and shape to the policies of networks, in every form: each plays them or says why not."""

import random
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import torch

from atari.learning import load_policy

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
KINDS = ("u1", "i1", "u2", "i4", "i8", "u8", "f2", "f4", "f8", "?", "c8", "O", "U3")


class Net(torch.nn.Module):
    """A network for images of one size."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        super().__init__()
        self.layer = torch.nn.Linear(int(np.prod(shape)), 4)

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        return self.layer(observations.flatten(1).float() / 255)


@cache
def policies() -> tuple[Any, ...]:
    """The policies of run folders, and of networks."""
    folders = sorted(path.parent for path in EXAMPLES.glob("*/policy.pt"))
    return (*map(load_policy, folders), *(load_policy(Net(shape)) for shape in ((128,), (4, 10, 10))))


def given(source: random.Random) -> Any:
    """Observations of some kind."""
    lists: list[Callable[[], Any]] = [list, lambda: None, lambda: "text", lambda: [[1, 2], [3]], lambda: 5, dict]
    if source.random() < 0.15:
        return source.choice(lists)()
    sizes = [source.choice((1, 2, 3, 4, 10, 42, 84, 128)) for _ in range(source.randrange(5))]
    array = np.zeros((source.choice((0, 1, 2, 3)), *sizes), source.choice(KINDS))
    return {"image": array} if source.random() < 0.1 else array


def attack(seed: int) -> None:
    """Call a policy with some observations."""
    source = random.Random(seed)
    for _ in range(20):
        policy, lanes = source.choice(policies()), np.arange(source.choice((1, 2, 3)))
        policy.begin("breakout", ("NOOP", "FIRE", "RIGHT", "LEFT"), lanes, lanes)
        observations = given(source)
        refusal = played(policy, observations, lanes)
        assert policy.name in refusal, f"{policy.name} names neither itself nor what it takes: {refusal}"


def played(policy: Any, observations: Any, lanes: Any) -> str:
    """The name of the policy if it plays, else the text of its refusal."""
    try:
        policy(observations, lanes)
    except (TypeError, ValueError) as error:
        return str(error)
    return str(policy.name)
