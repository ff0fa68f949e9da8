"""The environments that an agent learns in: a vector environment of the task of the training."""

import pickle
import zlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from atari.learning.options import TrainingOptions
from atari.learning.restarts import Restarts
from atari.vector import AtariVectorEnv

if TYPE_CHECKING:
    from atari.learning.intrinsic import IntrinsicRewards

ByteArray = npt.NDArray[np.uint8]

_GREEDY = 0.01
"""Environments with an epsilon below this play greedily: their games are the score of a training."""


class TrainingEnvironments:
    """Environments with SAME_STEP autoreset, and the scores of the whole games that were played in them.

    With several games, environment i plays game i modulo their number.

    Args:
        options: the options of the training.
        num_envs: the number of environments.
        num_threads: threads that play them.
        stacked: whether observations are stacks; otherwise each is a single image or RAM vector.
        restart_share: the share of the environments that `Restarts` begins near the ends of good games.
        restart_from: a file with the states from which `Restarts` begins them instead.

    Attributes:
        actions: names of the actions by their index in `step`.
        shape: the shape of an observation.
        restarts: what restarts environments; None without a share.
        intrinsic: what adds intrinsic rewards; None without the option `intrinsic_reward`.
        scored: bool (num_envs,), the environments whose games `take_games` returns: those that play whole games, unless
            an agent leaves more of them out.

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

    def __init__(
        self,
        options: TrainingOptions,
        num_envs: int,
        num_threads: int = 1,
        stacked: bool = True,
        *,
        restart_share: float = 0.0,
        restart_from: str | None = None,
    ) -> None:
        played = options.tasks
        if not stacked:
            played = tuple(task.replace(stack_num=None if options.from_ram else 1) for task in played)
        listed = [played[index % len(played)] for index in range(num_envs)]
        self._envs = AtariVectorEnv(listed, autoreset_mode="SameStep", num_threads=num_threads)
        self.actions = tuple(action.name for action in options.task.action_set)
        space: Any = self._envs.single_observation_space
        self.shape: tuple[int, ...] = space.shape
        self.num_envs = num_envs
        self.restarts: Restarts | None = None
        if restart_share:
            self.restarts = Restarts(self._envs, restart_share, options.seed, restart_from)
        self.intrinsic: IntrinsicRewards | None = None
        if options.intrinsic_reward is not None:
            from atari.learning import intrinsic  # it needs PyTorch

            self.intrinsic = intrinsic.IntrinsicRewards(options.intrinsic_reward, self._envs, options.seed)
        self.scored = np.ones(num_envs, np.bool_)
        if self.restarts is not None:
            self._score_only(~self.restarts.restarted, f"restart_share={restart_share:g}", "plays whole games")
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
        """Play one step, as `AtariVectorEnv.step`; rewards include the intrinsic rewards."""
        observations, rewards, terminations, truncations, info = self._envs.step(actions, out=out)
        for games in (info.get("final_info", {}), info):  # ended by the step, or inside the reset that follows
            self._count_games(games)
        if self.intrinsic is not None:
            rewards = self.intrinsic.add_to(rewards, observations, actions, info)
        if self.restarts is not None:
            ends, overs = terminations | truncations, info["terminated"] | truncations
            observations = self.restarts.after_step(observations, ends, overs, info["reward"])
        return observations, rewards, terminations, truncations, info

    def _count_games(self, info: Mapping[str, Any]) -> None:
        if "episode" in info:
            ended, episode = info["_episode"] & self.scored, info["episode"]
            names = [self._envs.games[lane].id for lane in np.flatnonzero(ended)]
            self._games += zip(names, episode["r"][ended].tolist(), episode["l"][ended].tolist(), strict=True)

    def lane_epsilons(self, greatest: float) -> npt.NDArray[np.float32]:
        """An epsilon for each environment, (num_envs,), as in Ape-X (Horgan et al. 2018); the greedy ones are scored.

        Environment i of N has `greatest ** (1 + 7 i / (N - 1))`: the first explores most, and the last almost never. So
        in all of a training each place of a game is reached by environments that play greedily, and explored by others.

        Raises:
            ValueError: in one of the games no environment that plays whole games has an epsilon below 0.01.
        """
        count = self.num_envs
        epsilons = (greatest ** (1 + 7 * np.arange(count) / max(count - 1, 1))).astype(np.float32)
        self._score_only(epsilons < _GREEDY, f"lane_epsilon={greatest:g}", "that play whole games is greedy")
        return epsilons

    def _score_only(self, lanes: npt.NDArray[np.bool_], option: str, what: str) -> None:
        """Leave the score to some of the scored environments.

        Raises:
            ValueError: a game would have no score.
        """
        self.scored &= lanes
        games = np.array([game.id for game in self._envs.games])
        for game in dict.fromkeys(games.tolist()):
            if not self.scored[games == game].any():
                raise ValueError(
                    f"with {option} none of the {(games == game).sum()} environments of {game} {what}, so there would "
                    f"be no score; give more environments for each worker, or a smaller {option.partition('=')[0]}"
                )

    def take_games(self) -> list[tuple[str, float, int]]:
        """The name, score and length in frames of each whole game that has ended since the last call."""
        taken, self._games = self._games, []
        return taken

    def state(self) -> bytes:
        """The positions in all games, as `restore` takes them: 90 MB of 256 environments that restart become 5."""
        restarts = None if self.restarts is None else self.restarts.state()
        intrinsic = () if self.intrinsic is None else (self.intrinsic.state(),)
        return zlib.compress(pickle.dumps((self._envs.snapshot(), restarts, *intrinsic)))

    def restore(self, state: bytes) -> ByteArray:
        """Continue from the positions of `state`; returns the observations there."""
        snapshots, restarts, *intrinsic = pickle.loads(zlib.decompress(state))
        self._envs.reset(seed=0)
        self._envs.restore(None, snapshots)
        self._games = []
        if self.restarts is not None:
            self.restarts.restore(restarts)
        if self.intrinsic is not None:
            self.intrinsic.restore(*intrinsic)
        observations: ByteArray = self._envs.observe()[0]
        return observations

    def close(self) -> None:
        """Close the environments."""
        self._envs.close()
