"""`VectorState`: the states of a vector's lanes, its snapshots and pickles."""

import copy
import operator
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal, overload

import gymnasium

import atari._emulator as _emulator
from atari.cores import writes
from atari.env.env import AtariEnv
from atari.env.episode_env import EpisodeEnv, lane_of, single_env
from atari.env.lane_snapshot import LaneSnapshot
from atari.games.game import Game
from atari.task import Task
from atari.task.checks import check_bool
from atari.task.json_form import require_same
from atari.vector.lanes import AddedWrites, check_lanes
from atari.vector.results import Results
from atari.vector.views import Views

_COPIED = ("spec", "single_action_space", "action_space")
"""Attributes that a copy has, too; action spaces have generators of their own."""


def _are_lanes(snapshots: Any) -> bool:
    """Whether the argument of `restore` has snapshots of lanes alone, and not bytes too.

    Raises:
        TypeError: it is no list of these.
    """
    if isinstance(snapshots, Sequence) and not isinstance(snapshots, (LaneSnapshot, bytes)):
        if all(isinstance(one, LaneSnapshot) and isinstance(one.state, _emulator.MemberSnapshot) for one in snapshots):
            return True
        others = [one for one in snapshots if not isinstance(one, bytes)]
        if len(others) < len(snapshots) and _are_lanes(others):
            return False
    raise TypeError(
        "snapshots must be a list that AtariVectorEnv.snapshot returned, or a part of one, or a list of snapshots of "
        f"single environments, got {snapshots!r:.80}"
    )


class VectorState(Views):
    """The methods of `AtariVectorEnv` that save and restore its environments."""

    batch_size: int
    games: tuple[Game, ...]
    spec: Any
    action_space: Any
    single_action_space: Any
    closed: bool
    _engine: _emulator.VectorEngine | None
    _added: tuple[AddedWrites, ...]
    _buffers: list[Results]
    _closed_states: list[bytes] | None  # the lanes at `close`; `reset` continues from them
    _given: dict[str, Any]
    _phase: Any
    _singles: dict[Task, AtariEnv | EpisodeEnv]
    _begin: Any
    _is_sent: Any
    _receive: Any

    @property
    def task(self) -> Task:
        """The task of the first environment; others differ only in game, mode, difficulty and interventions (added)."""
        return self.tasks[0]

    @property
    def tasks(self) -> tuple[Task, ...]:
        """The task of each environment, with the modes and difficulties set later (added)."""
        return self._options.tasks

    if TYPE_CHECKING:  # at run time `typing` would hold the functions, and all modules, until the process has ended

        @overload
        def snapshot(self, indices: Iterable[int] | None = None) -> list[LaneSnapshot]: ...
        @overload
        def snapshot(self, indices: Iterable[int] | None = None, *, packed: Literal[True]) -> list[bytes]: ...

    def snapshot(self, indices: Iterable[int] | None = None, *, packed: bool = False) -> Any:
        """The whole state of some environments, or of all, in memory: task, game, stack, generators, counters.

        Each state can be pickled, and restored in another process, and in the single environment that `atari.make`
        makes of its task.

        Args:
            indices: the environments; None is all of them.
            packed: return bytes of 4 to 11 kB each, as that single environment's own `snapshot` returns them; one takes
                up to a millisecond (added).

        Raises:
            RuntimeError: environments are being played (between `send` and `recv`).
            IndexError: there is no such environment.
            ValueError: with `packed`, several wrappers, or several players, play a task.
        """
        chosen, packed = self._indices(indices), check_bool("packed", packed)
        with self._lock:
            states = self._started().snapshot(chosen)
            tasks = self._options.identities
            lanes = [LaneSnapshot(state, tasks[index]) for index, state in zip(chosen, states, strict=True)]
            return [self._packed(*pair) for pair in zip(chosen, lanes, strict=True)] if packed else lanes

    def _packed(self, index: int, snapshot: LaneSnapshot) -> bytes:
        single = self._single(index)
        single.restore(snapshot)
        return single.snapshot()

    def _single(self, index: int) -> AtariEnv | EpisodeEnv:
        """The single environment of a lane's task, which converts snapshots."""
        task = self.tasks[index]
        if task.players > 1:
            raise ValueError("a game of several players has no single environment; leave packed=True, or bytes, out")
        if task not in self._singles:
            self._singles[task] = single_env(task, self._options.rom)
        return self._singles[task]

    def restore(
        self, indices: Iterable[int] | None, snapshots: Sequence[LaneSnapshot | bytes], *, own_generators: bool = False
    ) -> None:
        """Continue some environments, or all, from snapshots; each may come from any environment of the same task.

        Observations already returned do not change; `observe` returns the new ones. The threads copy a state when its
        environment is next played or read.

        Args:
            indices: the environments; None is all of them.
            snapshots: one for each of them. Bytes are packed, or the snapshot of a single environment that `atari.make`
                has made of the environment's task (added).
            own_generators: draw no-ops, skips and sticky actions as the environments would have gone on to do, and not
                as the snapshots' environments did (added). So two environments that continue from one snapshot differ.

        Raises:
            RuntimeError, IndexError: see `snapshot`.
            TypeError, ValueError: these are no snapshots, not one for each environment, or belong to another task; the
                message lists each field that differs. Nothing has changed.
        """
        chosen, own = self._indices(indices), check_bool("own_generators", own_generators)
        if len(set(chosen)) < len(chosen):
            raise ValueError(f"an environment is given twice: {chosen}; give each once")
        with self._lock:
            engine = self._started()
            lanes: Any = snapshots if _are_lanes(snapshots) else self._as_lanes(chosen, snapshots)
            self._require_same(chosen, [task for _, task in lanes])
            engine.restore(chosen, [state for state, _ in lanes], own)

    def _as_lanes(self, chosen: Sequence[int], snapshots: Sequence[LaneSnapshot | bytes]) -> list[LaneSnapshot]:
        pairs = zip(chosen, snapshots, strict=False)  # the engine checks that there is one for each
        return [self._of_single(index, one) if isinstance(one, bytes) else one for index, one in pairs]

    def _of_single(self, index: int, snapshot: bytes) -> LaneSnapshot:
        try:
            single = self._single(index)
            single.restore(snapshot)
            return lane_of(single)
        except ValueError as error:
            raise ValueError(f"environment {index} cannot continue from it: {error}") from None

    def fork(self, source: int, targets: Iterable[int]) -> None:
        """Continue some environments from the state of another one of the same task, its generators included.

        Raises:
            RuntimeError, IndexError, TypeError, ValueError: see `restore`.
        """
        chosen = self._indices(targets)
        try:
            source = operator.index(source)
        except TypeError:
            raise TypeError(f"source is the index of an environment, such as 0, got {source!r}") from None
        check_lanes([source], self.num_envs)
        with self._lock:
            engine = self._started()
            self._require_same(chosen, [self._options.identities[source]] * len(chosen))
            engine.restore(chosen, engine.snapshot([source]) * len(chosen))

    def _require_same(self, indices: Sequence[int], tasks: Sequence[str]) -> None:
        own = self._options.identities
        for index, task in zip(indices, tasks, strict=False):
            if task != own[index]:
                try:
                    require_same(task, self.tasks[index])
                except ValueError as error:
                    raise ValueError(f"environment {index} cannot continue from it: {error}") from None

    def _started(self) -> _emulator.VectorEngine:
        engine: _emulator.VectorEngine = self._open()
        if self._phase == "new":
            raise gymnasium.error.ResetNeeded("call reset() first")
        return engine

    def _indices(self, indices: Iterable[int] | None) -> list[int]:
        return list(range(self.num_envs)) if indices is None else check_lanes(indices, self.num_envs)

    def __getstate__(self) -> dict[str, Any]:
        """Pickling and copying keep the position in all games, and the writes of `Freeze` and `Poke`.

        If a batch has fewer results than all, a reset must follow.
        """
        with self._lock:
            engine = self._open()
            if engine.sent:
                raise RuntimeError("environments are being played; call recv() before pickling")
            states = [engine.save(index) for index in range(self.num_envs)]
            phase = self._phase if self.batch_size == self.num_envs else "new"
            added = [writes.definitions(added.slots) for added in self._added]
            options = replace(self._options)  # without the cached values made from them
            own = copy.deepcopy((self.spec, self.single_action_space, self.action_space))
            facts = {"phase": phase, **dict(zip(_COPIED, own, strict=True))}
            return {"given": self._given, "options": options, "states": states, "writes": added, **facts}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._given = state["given"]
        self._begin(state["options"])
        self._added = tuple(
            AddedWrites(writes.writes_of(game, added)) for game, added in zip(self.games, state["writes"], strict=True)
        )
        self._load(self._open(), state["states"])
        self._phase = state["phase"]
        for name in _COPIED:
            setattr(self, name, state[name])

    def _load(self, engine: _emulator.VectorEngine, states: Sequence[bytes]) -> None:
        """Bring a new engine into states that `save` has returned, with the added writes."""
        for index, added in enumerate(self._added):
            added.add_to(engine, index)
        for index, state in enumerate(states):
            engine.load(index, state)

    def note_choices(self, index: int) -> None:
        """Store the new mode and difficulty of an environment in its task."""
        engine, tasks = self._open(), list(self.tasks)
        tasks[index] = tasks[index].with_checked(mode=engine.mode(index), difficulty=engine.difficulty(index))
        self._options = replace(self._options, tasks=tuple(tasks))

    def _keep_states(self, engine: _emulator.VectorEngine) -> None:
        """Keep the states for a reset after `close`, unless another thread uses the environments."""
        with suppress(Exception):
            if self._is_sent():
                self._receive(engine)
            self._closed_states = [engine.save(index) for index in range(self.num_envs)]

    def _reopen(self) -> None:
        self._engine = self._options.make_engine()
        self._load(self._engine, self._closed_states or ())
        self._buffers = [Results(self._engine, self._options) for _ in range(2)]
        self._closed_states = None
        self.closed = False
