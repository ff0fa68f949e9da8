"""`Restarts`: some environments of a training begin where good games were lost, in place of the games' beginnings."""

from collections import deque
from contextlib import closing
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from atari.env.lane_snapshot import LaneSnapshot
from atari.learning.frontier import read_frontier
from atari.learning.options import TrainingOptions
from atari.task import Task
from atari.task.task import GameLike
from atari.vector import AtariVectorEnv

EVERY, KEPT = 100, 3
"""Steps between two snapshots of an environment, and how many it keeps: the oldest is 200 to 300 steps old."""
RING, LEAST = 256, 32
"""The most snapshots of a game, and the number from which on environments begin from them."""
LIVES, BEST = 500, 0.75
"""The number of last lives whose scores are compared, and the part of them that a good one is not below."""

_Options = TypeVar("_Options", bound="RestartOptions")


@dataclass(frozen=True, kw_only=True)
class RestartOptions(TrainingOptions):
    """The options of agents whose environments can restart, see `Restarts`.

    Attributes:
        restart_share: the share of the environments that, after an end, begin near the ends of recent good games.
        restart_from: a file of states, as `atari diagnose` writes one; the environments of restart_share begin from
            these states alone, in the whole training.

    Example:
        >>> from atari.learning import RestartOptions
        >>> RestartOptions.of("breakout", preset="dqn2015", restart_share=0.25).restart_share
        0.25
    """

    restart_share: float = 0.0
    restart_from: str | None = None

    @classmethod
    def of(cls: type[_Options], game: GameLike, *, preset: str | None = None, **options: Any) -> _Options:
        """The options of a training in a game, see `TrainingOptions.of`, which reads the file of `restart_from`, too.

        Raises:
            FileNotFoundError: there is no such file.
            TypeError, ValueError: an option is wrong, or the file is none of states of this task.
        """
        made = super().of(game, preset=preset, **options)
        if made.restart_from is not None:  # not in `__post_init__`: a run can be read without the file
            read_frontier(made.restart_from, made.task)
        return made

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.restart_share >= 1:
            raise ValueError(f"restart_share must be below 1, got {self.restart_share}")
        if self.restart_from is not None and not self.restart_share:
            raise ValueError(
                f"restart_from={self.restart_from!r} is for the environments of restart_share, which is 0; add "
                "restart_share=0.25, or leave restart_from out"
            )
        if self.restart_from is not None and self.more_games is not None:
            raise ValueError("restart_from has states of one game; leave it or more_games out")


class Restarts:
    """After an end, a share of the environments goes on from snapshots before recent deaths in good games.

    Each environment leaves a snapshot every 100 steps. When a life ends, the game's score so far is compared with those
    at the ends of the last 500 lives in the environments that play whole games. If it is among the best quarter, one of
    the environment's snapshots goes into a ring of 256. The environments that restart feed the ring, too, so it moves
    on with the agent. Each environment draws sticky actions as it would have, so games from one snapshot differ.

    With a file, the ring has its states, from the first step to the end. The file is read before the first step, but
    not if `restore` comes first: a checkpoint has the ring.

    Args:
        envs: the environments, with SAME_STEP autoreset; environment i plays game i modulo the number of games.
        share: the share of the environments of each game that restarts, above 0 and at most 1; at least one does.
        seed: the seed of the choice among snapshots.
        file: a file of `write_frontier` with states of the only game; None fills the ring while the agent plays.

    Attributes:
        restarted: bool (num_envs,), the environments that restart.
        count: the number of restarts so far.
    """

    def __init__(self, envs: AtariVectorEnv, share: float, seed: int, file: str | None = None) -> None:
        self._envs, self._file = envs, file
        lanes, games = np.arange(envs.num_envs), len({game.id for game in envs.games})
        place = lanes // games  # among the environments of its game, so that each game has its share
        self.restarted: npt.NDArray[np.bool_] = np.floor(place * share) > np.floor((place - 1) * share)
        self._game = lanes % games
        self._rng = np.random.default_rng(seed)
        self._step = self.count = 0
        self._scores = np.zeros(envs.num_envs)
        self._trails = [deque[Any](maxlen=KEPT) for _ in lanes]
        self._rings = [deque[Any](maxlen=RING) for _ in range(self._game.max() + 1)]
        self._lives = [deque[float](maxlen=LIVES) for _ in self._rings]

    @property
    def frontier(self) -> float:
        """The median score of the snapshots in the rings; NaN without one."""
        scores = [score for ring in self._rings for _, _, score in ring]
        return float(np.median(scores)) if scores else float("nan")

    def after_step(self, observations: Any, ends: Any, overs: Any, rewards: Any) -> Any:
        """Note the results of a step, and restart environments; returns the observations that follow.

        Args:
            observations: those of the step, (num_envs, ...) uint8; they are not changed.
            ends, overs: bool (num_envs,), the ends of episodes, and of games.
            rewards: int32 (num_envs,), not clipped.
        """
        if self._file is not None and not self._rings[0]:
            self._rings = [_read(self._file, self._envs.task)]
        self._step += 1
        self._scores += rewards
        ended: list[int] = np.flatnonzero(ends).tolist()
        for lane in ended if self._file is None else ():
            self._keep(lane)
        self._scores[overs] = 0
        least = LEAST if self._file is None else 1
        chosen = [lane for lane in ended if self.restarted[lane] and len(self._ring_of(lane)) >= least]
        if chosen:
            observations = self._restart(chosen, observations)
        if self._file is None:
            self._leave(observations)
        return observations

    def _keep(self, lane: int) -> None:
        """Put a snapshot of an environment whose life has ended into the ring, if the game was good."""
        lives, trail, score = self._lives[self._game[lane]], self._trails[lane], self._scores[lane]
        if not self.restarted[lane]:
            lives.append(score)
        if trail and len(lives) >= LIVES // 5 and score >= np.quantile(lives, BEST):
            self._ring_of(lane).append(trail[self._rng.integers(len(trail))])
        trail.clear()

    def _ring_of(self, lane: int) -> deque[Any]:
        return self._rings[self._game[lane]]

    def _restart(self, lanes: list[int], observations: Any) -> Any:
        rings = [self._ring_of(lane) for lane in lanes]
        states: list[tuple[LaneSnapshot, Any, float]] = [ring[self._rng.integers(len(ring))] for ring in rings]
        self._envs.restore(lanes, [state for state, _, _ in states], own_generators=True)
        observations = observations.copy()
        for lane, (_, seen, score) in zip(lanes, states, strict=True):
            observations[lane], self._scores[lane] = seen, score
        self.count += len(lanes)
        return observations

    def _leave(self, observations: Any) -> None:
        """Take the snapshots of the environments whose turn it is."""
        lanes = list(range(self._step % EVERY, len(self._trails), EVERY))
        for lane, state in zip(lanes, self._envs.snapshot(lanes) if lanes else (), strict=True):
            self._trails[lane].append((state, observations[lane].copy(), self._scores[lane]))

    def state(self) -> tuple[Any, ...]:
        """All that the next steps depend on beside the environments; it changes with them."""
        return self._step, self.count, self._scores, self._trails, self._rings, self._lives, self._rng

    def restore(self, state: tuple[Any, ...]) -> None:
        """Continue from a state of `state`, which is not copied."""
        self._step, self.count, self._scores, self._trails, self._rings, self._lives, self._rng = state


def _read(file: str, task: Task) -> deque[Any]:
    """The states of a file, with the observation and the score of each."""
    ring = deque[Any]()
    frontier = read_frontier(file, task)
    with closing(AtariVectorEnv(task, 1)) as envs:
        envs.reset(seed=0)
        for state, score in zip(*frontier, strict=True):
            envs.restore([0], [state])
            ring.append((state, envs.observe()[0][0].copy(), score))
    return ring
