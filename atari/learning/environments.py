"""The environments that an agent learns in: a vector environment of the task of the training."""

import pickle
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.learning.options import TrainingOptions
from atari.vector import AtariVectorEnv

ByteArray = npt.NDArray[np.uint8]


class TrainingEnvironments:
    """Environments with SAME_STEP autoreset, and the scores of the whole games that were played in them.

    With several games, environment i plays game i modulo their number.

    Args:
        options: the options of the training.
        num_envs: the number of environments.
        num_threads: threads that play them.
        stacked: whether observations are stacks; otherwise each is a single image or RAM vector.

    Attributes:
        actions: names of the actions by their index in `step`.
        shape: the shape of an observation.

    Example:
        >>> import numpy as np
        >>> from atari.learning import TrainingEnvironments, TrainingOptions
        >>> environments = TrainingEnvironments(TrainingOptions.of("pong", preset="envpool"), num_envs=2)
        >>> environments.reset(seed=0).shape, environments.actions[:3]
        ((2, 4, 84, 84), ('NOOP', 'FIRE', 'RIGHT'))
        >>> observations, rewards, terminations, truncations, info = environments.step(np.array([1, 1]))
        >>> environments.take_games()  # no game has ended yet
        []
        >>> environments.close()
    """

    def __init__(self, options: TrainingOptions, num_envs: int, num_threads: int = 1, stacked: bool = True) -> None:
        played = options.tasks
        if not stacked:
            played = tuple(task.replace(stack_num=None if options.from_ram else 1) for task in played)
        listed = [played[index % len(played)] for index in range(num_envs)]
        self._envs = AtariVectorEnv(listed, autoreset_mode="SameStep", num_threads=num_threads)
        self.actions = tuple(action.name for action in options.task.action_set)
        space: Any = self._envs.single_observation_space
        self.shape: tuple[int, ...] = space.shape
        self.num_envs = num_envs
        self._games: list[tuple[str, float, int]] = []

    def reset(self, seed: int | npt.NDArray[np.int64]) -> ByteArray:
        """Begin new games. Environment i gets the seed `seed + i`, or element i of an array."""
        observations: ByteArray
        observations, info = self._envs.reset(seed=seed)
        self._count_games(info)
        return observations

    def step(
        self, actions: npt.NDArray[np.int64], out: Any = None
    ) -> tuple[ByteArray, Any, Any, Any, Mapping[str, Any]]:
        """Play one step, as `AtariVectorEnv.step`."""
        results = self._envs.step(actions, out=out)
        info = results[4]
        for games in (info.get("final_info", {}), info):  # ended by the step, or inside the reset that follows
            self._count_games(games)
        return results

    def _count_games(self, info: Mapping[str, Any]) -> None:
        if "episode" in info:
            ended, episode = info["_episode"], info["episode"]
            names = [self._envs.games[lane].id for lane in np.flatnonzero(ended)]
            self._games += zip(names, episode["r"][ended].tolist(), episode["l"][ended].tolist(), strict=True)

    def take_games(self) -> list[tuple[str, float, int]]:
        """The name, score and length in frames of each whole game that has ended since the last call."""
        taken, self._games = self._games, []
        return taken

    def state(self) -> dict[str, Any]:
        """The positions in all games, as `restore` takes them."""
        return {"snapshots": pickle.dumps(self._envs.snapshot())}

    def restore(self, state: dict[str, Any]) -> None:
        """Continue from the positions of `state`."""
        self._envs.reset(seed=0)
        self._envs.restore(None, pickle.loads(state["snapshots"]))
        self._games = []

    def close(self) -> None:
        """Close the environments."""
        self._envs.close()
