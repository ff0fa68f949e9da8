"""The environments that an agent learns in: a vector environment of the task of the training."""

import pickle
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.learning.options import TrainingOptions
from atari.vector import AtariVectorEnv
from atari.vector.results import ends_of_stacks

ByteArray = npt.NDArray[np.uint8]


class TrainingEnvironments:
    """Environments with SAME_STEP autoreset, and the scores of the whole games that were played in them.

    Args:
        options: of the training.
        num_envs: how many environments.
        num_threads: threads that play them.
        stacked: whether observations are stacks; otherwise each is a single image or RAM vector.

    Attributes:
        actions: names of the actions; action i of `step` is the i-th of them.
        shape: of an observation.
    """

    def __init__(self, options: TrainingOptions, num_envs: int, num_threads: int = 1, stacked: bool = True) -> None:
        self._task = played = options.task
        if not stacked and not options.from_ram:
            played = played.replace(stack_num=1)
        self._envs = AtariVectorEnv(played, num_envs, autoreset_mode="SameStep", num_threads=num_threads)
        self.actions = tuple(action.name for action in options.task.action_set)
        stacks_ram = options.from_ram and stacked
        self._ram = RamStack(num_envs, options.stack, options.padding) if stacks_ram else None
        space: Any = self._envs.single_observation_space
        self.shape: tuple[int, ...] = space.shape if self._ram is None else self._ram.shape
        self.num_envs = num_envs
        self.games: list[tuple[float, int]] = []

    def reset(self, seed: int | npt.NDArray[np.int64]) -> ByteArray:
        """Begin new games; environment i is seeded with seed + i, or with its own of several."""
        observations, info = self._envs.reset(seed=seed)
        self._count_games(info)
        return observations if self._ram is None else self._ram.push(observations, np.ones(self.num_envs, np.bool_))

    def step(
        self, actions: npt.NDArray[np.int64], out: Any = None
    ) -> tuple[ByteArray, Any, Any, Any, Mapping[str, Any]]:
        """Play one step; rewards are clipped. See `AtariVectorEnv.step`."""
        observations, rewards, terminations, truncations, info = self._envs.step(actions, out=out)
        self._count_games(info.get("final_info", {}))
        if self._ram is not None:
            games = info.get("final_info", {})
            observations = self._ram.push(observations, ends_of_stacks(self._task, terminations, truncations, games))
        return observations, rewards, terminations, truncations, info

    def final_observations(self, info: Mapping[str, Any]) -> ByteArray:
        """The last observations of the episodes that have ended in a step with this `info`; zero elsewhere."""
        final: ByteArray = info["final_obs"]
        return final if self._ram is None else self._ram.final(final)

    def _count_games(self, info: Mapping[str, Any]) -> None:
        if "episode" in info:
            ended = info["_episode"]
            self.games += zip(info["episode"]["r"][ended].tolist(), info["episode"]["l"][ended].tolist(), strict=True)

    def take_games(self) -> list[tuple[float, int]]:
        """Score and length in frames of the whole games that have ended since the last call."""
        taken, self.games = self.games, []
        return taken

    def state(self) -> dict[str, Any]:
        """The positions in all games, as `restore` takes them."""
        return {
            "snapshots": pickle.dumps(self._envs.snapshot()),
            "ram": None if self._ram is None else self._ram.rows.copy(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from the positions of `state`."""
        self._envs.reset(seed=0)
        self._envs.restore(None, pickle.loads(state["snapshots"]))
        if self._ram is not None:
            self._ram.rows = state["ram"]
        self.games = []

    def close(self) -> None:
        """Close the environments."""
        self._envs.close()


class RamStack:
    """The last RAM vectors of some environments, (environments, size, 128) uint8, the oldest first.

    At the beginning of an episode the others are zero, or with the padding "reset" the first one.
    """

    def __init__(self, num_envs: int, size: int, padding: str = "reset") -> None:
        self.shape = (size, 128)
        self._pads_zero = padding == "zero"
        self.rows = self._before = np.zeros((num_envs, size, 128), np.uint8)

    def push(
        self, ram: ByteArray, started: npt.NDArray[np.bool_], lanes: npt.NDArray[np.int64] | None = None
    ) -> ByteArray:
        """Add a vector to all environments, or to some `lanes`, and return their stacks, a new array.

        In those that have `started`, the vector is the first.
        """
        self._before = self.rows if lanes is None else self.rows[lanes]
        rows = self.final(ram)
        rows[started, :-1] = 0 if self._pads_zero else ram[started, None]
        if lanes is None:
            self.rows = rows
        else:
            self.rows[lanes] = rows
        return rows

    def final(self, ram: ByteArray) -> ByteArray:
        """The stacks that the last `push` would have given with these vectors, had nothing started."""
        return np.concatenate([self._before[:, 1:], ram[:, None]], 1)

    def resize(self, num_envs: int) -> None:
        """Make room for more environments."""
        missing = max(0, num_envs - len(self.rows))
        self.rows = np.concatenate([self.rows, np.zeros((missing, *self.shape), np.uint8)])
