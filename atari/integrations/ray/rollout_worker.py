"""`RolloutWorker`: environments and a policy, which an actor of `RolloutActors` plays. This module needs no Ray."""

import pickle
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.base.gymnasium_versions import AutoresetMode
from atari.cores.options import SEED_LIMIT
from atari.integrations.ray.rollout import FrameTable, Rollout
from atari.learning.policies import load_policy
from atari.policy.needs import needs_of
from atari.task import Task
from atari.task.fields import GROUPS
from atari.vector import AtariVectorEnv
from atari.vector.results import ends_of_stacks


@dataclass(frozen=True)
class WorkerSettings:
    """The settings that the workers of a run share.

    Attributes:
        tasks: the task of each environment of a worker.
        steps: number of steps of each environment in a rollout.
        seed: first seed: environment j of worker i has seed + i * num_envs + j.
        unstacked: whether frames are stored once.
        options: other options of `AtariVectorEnv`.
    """

    tasks: tuple[Task, ...]
    steps: int
    seed: int
    unstacked: bool
    options: Mapping[str, Any]

    @property
    def num_envs(self) -> int:
        """The number of environments of a worker."""
        return len(self.tasks)

    def make(self) -> AtariVectorEnv:
        """The environments of a worker.

        Raises:
            TypeError, ValueError, FileNotFoundError: see `AtariVectorEnv`; or observations would not be written
                straight into a rollout.
        """
        envs = AtariVectorEnv(self.tasks, **{"num_threads": 1, "game_info": True, **self.options})
        refused = {
            "channels_last=True, dtype='float32' or stack_num=None": not envs.options.layout.is_engines,
            "obs_type='dict'": envs.task.kind.is_dict,
            f"autoreset_mode={envs.autoreset_mode.value!r}": envs.autoreset_mode != AutoresetMode.NEXT_STEP,
            f"batch_size={envs.batch_size}": envs.batch_size != envs.num_envs,
            f"players={envs.options.players}": envs.options.players > 1,
            "life_loss_info=True": envs.task.life_loss_info,
            "game_info=False": not envs.options.game_info,
        }
        for what, is_so in refused.items():
            if is_so:
                envs.close()
                raise ValueError(f"RolloutActors cannot have {what}; leave it out")
        return envs


@dataclass(frozen=True)
class Position:
    """The position of a worker after a rollout: everything that the next rollout depends on, except the weights.

    Attributes:
        number: number of the next rollout.
        environments: snapshots of the environments after rollout `snapshot_number - 1`, packed; None means their reset.
        actions: the actions played since the snapshot, (steps, num_envs, ...) for each rollout.
        policy: the state of the policy after the last rollout, pickled; None means the beginning.
    """

    number: int = 0
    environments: bytes | None = None
    actions: tuple[npt.NDArray[Any], ...] = ()
    policy: bytes | None = None


@dataclass(frozen=True)
class Played:
    """The result of `RolloutWorker.play`.

    Attributes:
        rollout: the steps.
        environments: snapshots after the rollout, packed; None without `take_snapshot`.
        policy: the state of the policy, see `Position`.
    """

    rollout: Rollout
    environments: bytes | None
    policy: bytes


class RolloutWorker:
    """Plays rollouts one after another.

    Args:
        settings: the settings of all workers.
        index: the index of this worker.
        policy: see `RolloutActors`.
        position: the position to continue from.
    """

    def __init__(self, settings: WorkerSettings, index: int, policy: Any, position: Position) -> None:
        self._index, self._steps = index, settings.steps
        self._lanes = np.arange(settings.num_envs)
        self._seeds = np.random.SeedSequence([settings.seed, index]).generate_state(settings.num_envs).astype(np.int64)
        self._policy = load_policy(policy)
        self._envs = settings.make()
        self._number = position.number
        self._observations, _ = self._envs.reset(seed=(settings.seed + index * settings.num_envs) % SEED_LIMIT)
        self._ended = np.zeros(settings.num_envs, np.bool_)  # lanes in which the next step begins an episode
        self._renewed = self._ended  # lanes in which the next step also begins a stack of images
        shape = self._observations.shape
        stacked = settings.unstacked and len(shape) > 3 and shape[1] > 1
        self._frames = FrameTable(settings.steps, shape) if stacked else None
        self._table: npt.NDArray[np.uint8] | None = None
        self._position: Position | None = position

    def play(self, weights: Any, version: int, take_snapshot: bool) -> Played:
        """Play a rollout. The next rollout overwrites the memory of its observations.

        Args:
            weights: the argument of the policy's `load`, before the first step; None keeps the old weights.
            version: the version of the weights, which marks the rollout.
            take_snapshot: whether to return the state of the environments after the rollout.

        Raises:
            ValueError: the policy returns no actions for the environments, or other extras than before.
            RuntimeError: in the successor of a lost actor, the policy's `restore` has failed.
        """
        if self._position is not None:  # not in the constructor, whose failure would mean a lost actor to Ray
            self._begin_policy()
            self._continue(self._position)
            self._position = None
        if weights is not None:
            if not hasattr(self._policy, "load"):
                raise ValueError(f"policy {self._policy.name} has no load(weights), which set_weights needs")
            self._policy.load(weights)
        rows = _Rows(self._steps)
        table = self._begin()
        for step in range(self._steps):
            actions, extras = self._policy.choose(self._observations, self._lanes)
            extras = {name: np.asarray(part) for name, part in extras.items()}
            valid = ~self._ended
            out = None if self._frames else table[step + 1]
            self._observations, rewards, terminations, truncations, info = self._envs.step(actions, out=out)
            if self._frames:
                self._frames.add(step + 1, self._observations, self._ended)
            if self._renewed.any():
                self._policy.begin_episodes(self._lanes[self._renewed])
            self._note_ends(terminations, truncations, info)
            rows.add(step, actions, rewards, terminations, truncations, valid, extras)
            rows.add_games(info)
        index = self._frames.index if self._frames else None
        table = self._frames.table if self._frames else table
        rollout = rows.rollout(self._index, self._number, version, table, index)
        self._number += 1
        state = self._policy.state() if hasattr(self._policy, "state") else None
        return Played(rollout, self._snapshot() if take_snapshot else None, pickle.dumps(state, 5))

    def _begin(self) -> npt.NDArray[np.uint8]:
        """Begin a rollout with the last observations; returns the array for whole observations."""
        if self._frames:
            self._frames.begin(self._observations)
            return np.zeros(0, np.uint8)
        if self._table is None:
            self._table = np.empty((self._steps + 1, *self._observations.shape), np.uint8)
        self._table[0] = self._observations
        return self._table

    def _note_ends(self, terminations: Any, truncations: Any, info: Mapping[str, Any]) -> None:
        self._ended = terminations | truncations
        self._renewed = ends_of_stacks(self._envs.task, terminations, truncations, info)

    def _snapshot(self) -> bytes:
        return zlib.compress(pickle.dumps((self._envs.snapshot(), self._ended, self._renewed), 5), 1)

    def _begin_policy(self) -> None:
        played, needs = self._envs.task, needs_of(self._policy, self._envs.games[0])
        if needs.task is not None:
            fields = needs.task.differences(played)
            for name in ("actions", "frameskip", *GROUPS["observation"]):
                if name in fields:
                    theirs, ours = fields[name]
                    raise ValueError(
                        f"policy {self._policy.name} needs {name}={theirs!r}, and the environments have {ours!r}; make "
                        "them with the policy's task as the game"
                    )
            if "rom" in needs.options or not needs.layout(needs.task).is_engines:
                needed = ", ".join(needs.options)
                raise ValueError(f"policy {self._policy.name} needs {needed}, which rollouts do not have; leave it out")
        names = [action.name for action in self._envs.options.actions[0]]
        self._policy.begin(played.game, names, self._lanes, self._seeds)

    def _continue(self, position: Position) -> None:
        if position.environments is not None:
            snapshots, self._ended, self._renewed = pickle.loads(zlib.decompress(position.environments))
            self._envs.restore(None, snapshots)
            self._observations, _ = self._envs.observe()
        for actions in position.actions:
            for row in actions:
                self._observations, _, terminations, truncations, info = self._envs.step(row)
                self._note_ends(terminations, truncations, info)
        if position.policy is not None:
            state = pickle.loads(position.policy)
            if state is not None:
                self._restore(state)

    def _restore(self, state: Any) -> None:
        try:
            self._policy.restore(state)
        except Exception as error:
            raise RuntimeError(
                f"restore(state) of the policy {self._policy.name} failed in the successor of a lost actor "
                f"({type(error).__name__}: {error}); it is called on a new policy, before load(weights), and must not "
                "need weights: let it keep the state until load(), or save more in state()"
            ) from error


class _Rows:
    """The arrays of a rollout except its observations, filled row by row; the first row decides their shapes."""

    def __init__(self, steps: int) -> None:
        self._steps = steps
        self._columns: list[npt.NDArray[Any]] = []
        self._extras: dict[str, npt.NDArray[Any]] = {}
        self._games: list[tuple[float, int]] = []

    def add(self, row: int, *parts: Any) -> None:
        *columns, extras = parts
        if not row:
            self._columns = [np.zeros((self._steps, *part.shape), part.dtype) for part in columns]
            self._extras = {name: np.zeros((self._steps, *part.shape), part.dtype) for name, part in extras.items()}
        for target, part in zip(self._columns, columns, strict=True):
            target[row] = part
        if extras.keys() != self._extras.keys():
            raise ValueError(f"the policy returned {sorted(extras)} beside actions, and {sorted(self._extras)} before")
        for name, part in extras.items():
            column = self._extras[name]
            if part.shape != column.shape[1:] or not np.can_cast(part.dtype, column.dtype):
                raise ValueError(
                    f"the policy returned {name!r} as {part.dtype} {part.shape}, and before as {column.dtype} "
                    f"{column.shape[1:]}"
                )
            column[row] = part

    def add_games(self, info: Mapping[str, Any]) -> None:
        if "episode" in info:
            for lane in np.flatnonzero(info["_episode"]).tolist():
                self._games.append((float(info["episode"]["r"][lane]), int(info["episode"]["l"][lane])))

    def rollout(self, index: int, number: int, version: int, table: Any, table_index: Any) -> Rollout:
        scores = np.array([score for score, _ in self._games], np.float64)
        lengths = np.array([length for _, length in self._games], np.int64)
        actions, rewards, terminations, truncations, valid = self._columns
        signals = rewards, terminations, truncations, valid
        return Rollout(index, number, version, table, table_index, actions, *signals, self._extras, scores, lengths)
