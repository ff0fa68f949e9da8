"""`RecordSearch`: keeps how each snapshot of a search was reached, and writes that as a replay.

Every lane has a node for what it played last, which refers to the node before. A snapshot of a lane has the lane's
node, and a lane that is restored from it goes on from there. So the nodes are a tree. A branch is freed when no lane
and no snapshot refers to it.
"""

from collections.abc import Iterable, Sequence
from contextlib import closing
from os import PathLike
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from atari.base.gymnasium_versions import AutoresetMode, VectorEnv, VectorWrapper
from atari.env.env import AtariEnv
from atari.env.lane_snapshot import LaneSnapshot
from atari.recording.recordable import recorded_vector
from atari.recording.replay.record_replay import Shadow
from atari.recording.replay.replay import Replay
from atari.vector.lanes import check_lanes
from atari.vector.seeds import seed_words


class Reset(NamedTuple):
    """A reset: its nine words of `atari.vector.seeds`, or None, and whether it begins a new game in any case."""

    seed: list[int] | None
    new_game: bool


Played = Reset | LaneSnapshot | npt.NDArray[Any]
"""A node adds a reset, a state from which the lane went on, or the actions of steps."""


class Node:
    """What a lane played after the node `before`; a root, a seeded reset or a snapshot, has none."""

    __slots__ = ("before", "mode", "played")

    def __init__(self, played: Played, mode: AutoresetMode, before: "Node | None" = None) -> None:
        self.played, self.mode, self.before = played, mode, before

    def path(self) -> list[Played]:
        """What was played, from the root on."""
        path, node = [self.played], self
        while (before := node.before) is not None:
            node = before
            path.append(node.played)
        return path[::-1]

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy is made of the path, because pickle cannot follow thousands of nodes."""
        return _chain, (self.path(), self.mode)


class RecordedSnapshot(LaneSnapshot):
    """The snapshot of a lane, with the node of what was played up to it."""

    node: Node


class RecordSearch(VectorWrapper):
    """Records how each state of a search was reached: `write_replay` makes a replay of one.

    It has the methods of `AtariVectorEnv` that play and restore: `reset`, `step`, `play`, `snapshot`, `restore` and
    `fork`. A snapshot keeps the actions from the last reset with a seed up to it, of a byte or more each. A first
    `reset` without a seed draws seeds. States that come from elsewhere, packed ones too, are the beginning of what
    follows: the replay contains them, and plays only on the cores "native" and "plain".

    Args:
        envs: an `AtariVectorEnv` with batches of all environments; wrappers go around this one.

    Raises:
        TypeError: it is another environment, or a wrapper.
        ValueError: its batches are smaller, or it has several players.

    Example:
        >>> import atari, numpy as np
        >>> from atari.recording import RecordSearch
        >>> envs = RecordSearch(atari.AtariVectorEnv("ms_pacman", 16, preset="dqn2015"))
        >>> observations, info = envs.reset(seed=0)
        >>> rng, best = np.random.default_rng(0), envs.snapshot([0])[0]
        >>> for _ in range(5):  # 16 plans of 20 steps, each time from the state with the most points
        ...     envs.restore(None, [best] * 16)
        ...     rewards = envs.play(rng.integers(9, size=(16, 20)))[1]
        ...     best = envs.snapshot([int(rewards.argmax())])[0]
        >>> envs.trajectory(best).shape
        (100,)
        >>> replay = envs.write_replay(best, "best.a26r")
        >>> replay.episodes[0].score
        90
    """

    def __init__(self, envs: VectorEnv) -> None:
        if isinstance(getattr(envs, "unwrapped", None), AtariEnv):
            raise TypeError(
                f"RecordSearch records an AtariVectorEnv, got {type(envs).__name__}; give one of 1 environment"
            )
        self._vector = recorded_vector(envs, "RecordSearch")
        if self._vector is not envs:
            raise TypeError(f"RecordSearch records an AtariVectorEnv itself; put {type(envs).__name__} around it")
        super().__init__(envs)
        started = self._vector.snapshot() if self._vector.started else ()
        self._nodes: list[Node | None] = [self._root(one) for one in started] or [None] * self._vector.num_envs

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset environments, see `AtariVectorEnv.reset`."""
        vector = self._vector
        if seed is None and not vector.started:
            seed = np.random.SeedSequence().generate_state(vector.num_envs).astype(np.int64)
        mask = vector.reset_mask(options)
        seeded, words = seed_words(seed, mask, ale=vector.task.seeding == "ale")
        result = vector.reset(seed=seed, options=options)
        new_game = bool((options or {}).get("new_game"))
        for lane in np.flatnonzero(mask).tolist():
            before = self._nodes[lane]
            if seeded[lane]:
                self._nodes[lane] = Node(Reset(words[lane].tolist(), new_game), vector.autoreset_mode)
            elif before is not None:
                self._nodes[lane] = Node(Reset(None, new_game), vector.autoreset_mode, before)
            else:
                self._nodes[lane] = self._root(vector.snapshot([lane])[0])
        return result

    def step(self, actions: Any, out: Any = None, env_id: Any = None) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Play a step, see `AtariVectorEnv.step`."""
        result = self._vector.step(actions, out, env_id)
        array = np.asarray(actions)
        self._add(result[4]["env_id"].tolist(), [array[row : row + 1] for row in range(len(array))])
        return result

    def play(
        self, actions: Any, *, discount: float = 1.0, stop: bool = True, every: bool = False, env_id: Any = None
    ) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Play several steps, see `AtariVectorEnv.play`."""
        result = self._vector.play(actions, discount=discount, stop=stop, every=every, env_id=env_id)
        steps, lanes = result[4]["steps"].tolist(), range(self._vector.num_envs) if env_id is None else env_id
        self._add(map(int, lanes), [row[:count] for row, count in zip(np.asarray(actions), steps, strict=True)])
        return result

    def _add(self, lanes: Iterable[int], played: Iterable[npt.NDArray[Any]]) -> None:
        mode = self._vector.autoreset_mode
        for lane, actions in zip(lanes, played, strict=True):
            if len(actions):
                small = actions.astype(np.uint8 if actions.dtype.kind in "iu" else np.float32)  # a copy of this row
                self._nodes[lane] = Node(small, mode, self._nodes[lane])

    def snapshot(self, indices: Iterable[int] | None = None) -> list[RecordedSnapshot]:
        """The state of some environments, or of all, with what was played up to it; see `AtariVectorEnv.snapshot`."""
        chosen = list(range(self._vector.num_envs)) if indices is None else check_lanes(indices, self._vector.num_envs)
        pairs = zip(self._vector.snapshot(chosen), chosen, strict=True)
        return [_with_node(one, self._nodes[lane]) for one, lane in pairs]

    def restore(self, indices: Iterable[int] | None, snapshots: Sequence[LaneSnapshot | bytes]) -> None:
        """Continue environments from snapshots, see `AtariVectorEnv.restore`.

        The environments draw as those of the snapshots did, so that a replay can play what follows from the beginning.
        """
        vector = self._vector
        chosen = list(range(vector.num_envs)) if indices is None else check_lanes(indices, vector.num_envs)
        vector.restore(chosen, snapshots)
        for lane, snapshot in zip(chosen, snapshots, strict=True):
            known = isinstance(snapshot, RecordedSnapshot) and snapshot.node.mode == vector.autoreset_mode
            self._nodes[lane] = snapshot.node if known else self._root(vector.snapshot([lane])[0])  # type: ignore[union-attr]

    def fork(self, source: int, targets: Iterable[int]) -> None:
        """Continue some environments from the state of another one, see `AtariVectorEnv.fork`."""
        chosen = list(targets)
        self._vector.fork(source, chosen)
        for lane in chosen:
            self._nodes[lane] = self._nodes[source]

    def _root(self, snapshot: LaneSnapshot) -> Node:
        return Node(snapshot, self._vector.autoreset_mode)

    def trajectory(self, snapshot: RecordedSnapshot) -> npt.NDArray[Any]:
        """The actions from the last reset with a seed up to a snapshot, (steps,) uint8; continuous, (steps, 3) float32.

        Raises:
            TypeError: it is no snapshot of a `RecordSearch`.
        """
        parts = [part for part in _checked(snapshot).node.path() if isinstance(part, np.ndarray)]
        none = np.zeros((0, 3), np.float32) if self._vector.continuous else np.zeros(0, np.uint8)
        return np.concatenate([none, *parts])

    def write_replay(self, snapshot: RecordedSnapshot, path: str | PathLike[str]) -> Replay:
        """Write what was played up to a snapshot as a replay, verify it, and return it.

        Args:
            snapshot: one that this object's `snapshot` returned, or a pickled copy.
            path: the file, with the suffix ".a26r"; one of this name is replaced.

        Raises:
            TypeError: it is no snapshot of a `RecordSearch`.
            ValueError: it is of another task, or `path` has another suffix.
            RuntimeError: the replay ends in another state, because something else changed the environment: its mode,
                its RAM, a `Freeze` or a `Poke`. The file is complete up to there.
            OSError: the file cannot be written.
        """
        options = self._vector.options
        played = _checked(snapshot).node.path()
        if snapshot.task not in options.identities:
            raise ValueError(f"the snapshot is of another task than these environments: {snapshot.task:.200}")
        index, observed = options.identities.index(snapshot.task), isinstance(played[0], LaneSnapshot)
        shadow = Shadow(options, index, path, observed=observed)
        with closing(shadow):
            for part in played:
                if isinstance(part, Reset):
                    shadow.reset(part.seed, part.new_game)
                elif isinstance(part, LaneSnapshot):
                    shadow.restore(part)
                else:
                    indices, strengths, steps = options.moves_of_sequences(part[None], 1)
                    factors = np.ones(steps) if strengths is None else strengths
                    for action, strength in zip(indices.tolist(), factors.tolist(), strict=True):
                        shadow.step(action, strength)
            same = shadow.is_at(snapshot)
        replay = Replay.load(shadow.recorder.path, game=options.games[index], rom=options.rom)
        if not (same and replay.verify()):
            raise RuntimeError(
                "the replay ends in another state than the snapshot; was the environment's mode, RAM or state set from "
                "outside? Set these before RecordSearch is made, or leave them"
            )
        return replay


def _checked(snapshot: Any) -> RecordedSnapshot:
    if not isinstance(snapshot, RecordedSnapshot):
        raise TypeError(f"give a snapshot that RecordSearch.snapshot returned, got {type(snapshot).__name__}")
    return snapshot


def _with_node(snapshot: LaneSnapshot, node: Node | None) -> RecordedSnapshot:
    recorded = RecordedSnapshot(*snapshot)
    assert node is not None  # the vector was reset before
    recorded.node = node
    return recorded


def _chain(path: Sequence[Played], mode: AutoresetMode) -> Node:
    node: Node | None = None
    for played in path:
        node = Node(played, mode, node)
    assert node is not None
    return node
