"""`ReplayMemory` stores the experience of vector environments, each frame once."""

import os
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, cast

import gymnasium
import numpy as np
import numpy.typing as npt

import atari._emulator as _emulator
from atari.base.gymnasium_versions import AutoresetMode, autoreset_mode
from atari.base.validation import check_integer
from atari.cores.options import SEED_LIMIT
from atari.lab.dataset_reader import StoredEpisode
from atari.learning.memory import memory_file
from atari.learning.memory.batches import Batch, BatchPool, Sequences, array_maker, check_size, make_batch, target_of
from atari.learning.memory.datasets import open_data, options_of, rows_of
from atari.learning.memory.options import MemoryOptions, as_numpy, options_for
from atari.learning.memory.step_arrays import StepArrays
from atari.learning.memory.stored_memory import StoredMemory, atomic
from atari.recording.episodes import Source
from atari.recording.stacks import Stacking
from atari.task.checks import check_bool

_SEQUENCE_MOST = 2**20
_UNWRITTEN = np.frombuffer(bytes.fromhex("9e3779b97f4a7c15f39cc0605cedc834"), np.uint8)
"""The first bytes of the array that `frames` returns, until a step writes there."""


class ReplayMemory(StoredMemory):
    """The steps of a vector environment, with each frame stored once; stacks are made when they are sampled.

    Environments write single frames into the memory without a copy, see `frames`::

        envs = atari.AtariVectorEnv("pong", 8, stack_num=1)
        memory = ReplayMemory.for_env(envs, 1_000_000)
        observations, info = envs.reset(seed=0)
        memory.reset(observations)
        for _ in range(1000):
            actions = policy(memory.observations())  # uint8 (8, 4, 84, 84)
            _, rewards, terminations, truncations, info = envs.step(actions, out=memory.frames())
            memory.add(actions, rewards, terminations, truncations, info)
        batch = memory.sample(32, n=3, gamma=0.99)

    An observation of `stack_num` frames has the shape (stack_num, *frame), where `frame` is `observation_shape` without
    a first axis of 1; an observation of one frame has the shape `observation_shape`. Frames before the first of an
    episode are 0, or with padding="reset" copies of the first.

    The ignored step after the end of an episode in NEXT_STEP is no transition. The last observation of an episode is
    the real one in all autoreset modes.

    Threads may share a memory: each call is atomic, and one runs at a time. A step that is written to `frames` takes
    two calls, so several threads add steps by `add(..., observations=...)`.

    Args:
        capacity: the number of latest steps that are kept, of all environments together, ignored steps included.
        num_envs: environments that step together.
        observation_shape: the shape of one frame, uint8, as the environment gives it: (1, 84, 84), (84, 84),
            (210, 160, 3), (128,). For a dict of observations a dict of shapes.
        stack_num: the most frames in an observation; with a dict of observations a number, or a dict of numbers.
        padding: "zero", or "reset".
        autoreset_mode: the environments' `gymnasium.vector.AutoresetMode`, or "next_step", "same_step", "disabled".
        action_shape, action_dtype: the shape and the dtype of one action.
        priority_exponent: the power of priorities, 0.6 in Schaul et al. 2016; None is without priorities.
        final_frames: space for last observations that have no place among the frames (SAME_STEP, DISABLED). A memory
            that needs more forgets its oldest steps earlier. None is a fiftieth of the capacity. With a file, an eighth
            of this space and of `compressed_bytes` is for the steps after a flush.
        compress: store frames compressed, without loss.
        compressed_bytes: space for compressed frames; a memory that needs more forgets its oldest steps earlier. None
            is a seventh of the bytes of the frames. Main memory is taken when first needed, a file in full.
        seed: seed of the generator that samples, 0..2**32-1; None is random.
        num_threads: threads that `sample` may use, the caller's included.
        path: a new file that holds the memory, as large as the memory can get; `open` continues it.
        margin: with a file, the number of further steps that are kept, after which `flush` is needed, see there. None
            is a 64th of the capacity.
        autoflush: with a file, flush before a step that would overwrite the state of the last flush. With False such a
            step raises BufferError, and `must_flush` says when one may come.

    Raises:
        TypeError, ValueError: an option is of the wrong kind or out of range.
        MemoryError: the machine has too little memory available.
        FileExistsError: the file exists; `open` continues it.
        OSError: the file cannot be made, or the disk has no space for it.

    Example:
        >>> import atari, numpy
        >>> from atari.learning import ReplayMemory
        >>> envs = atari.AtariVectorEnv("breakout", 2, stack_num=1, preset="dqn2015")
        >>> memory = ReplayMemory.for_env(envs, 1000, seed=0)
        >>> observations, info = envs.reset(seed=0)
        >>> memory.reset(observations)
        >>> fire = numpy.ones(2, int)
        >>> for _ in range(20):
        ...     _, rewards, terminations, truncations, info = envs.step(fire, out=memory.frames())
        ...     memory.add(fire, rewards, terminations, truncations, info)
        >>> batch = memory.sample(8, n=3, gamma=0.99)
        >>> batch.observations.shape, batch.rewards.shape
        ((8, 4, 84, 84), (8,))
        >>> envs.close()
    """

    def __init__(
        self,
        capacity: int,
        num_envs: int,
        observation_shape: Any,
        *,
        stack_num: int | Mapping[str, int] = 4,
        padding: str = "zero",
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        action_shape: tuple[int, ...] = (),
        action_dtype: npt.DTypeLike = "int64",
        priority_exponent: float | None = None,
        final_frames: int | None = None,
        compress: bool = False,
        compressed_bytes: int | None = None,
        seed: int | None = None,
        num_threads: int = 1,
        path: str | PathLike[str] | None = None,
        margin: int | None = None,
        autoflush: bool = True,
    ) -> None:
        options = MemoryOptions.check(
            capacity=capacity,
            num_envs=num_envs,
            observation_shape=observation_shape,
            stack_num=stack_num,
            padding=padding,
            autoreset_mode=autoreset_mode,
            action_shape=action_shape,
            action_dtype=action_dtype,
            priority_exponent=priority_exponent,
            final_frames=final_frames,
            compress=compress,
            compressed_bytes=compressed_bytes,
            margin=margin,
            saved=path is not None,
        )
        words = np.random.SeedSequence(None if seed is None else check_integer("seed", seed, 0, SEED_LIMIT - 1))
        threads = check_integer("num_threads", num_threads, 1, 1024)
        autoflush = check_bool("autoflush", autoflush)
        if path is None and (margin is not None or not autoflush):
            raise ValueError("margin and autoflush are about flushes to a file; add path=..., or leave them out")
        file = None if path is None else memory_file.BlockFile.create(Path(os.fspath(path)), options)
        try:
            block = memory_file.allocate(options) if file is None else file.block
            self._begin(options, threads, file, block, autoflush)
            self._core.seed(int(words.generate_state(1, np.uint64)[0]))
            self.flush()
        except BaseException:
            if file is not None:
                file.discard()
            raise

    def _use(self, core: _emulator.ReplayMemory, block: memory_file.Block) -> None:
        super()._use(core, block)
        options = self._options
        self._arrays, self._pool = StepArrays(options), BatchPool(options)
        self._usual_actions = not options.action_shape and options.action_dtype == np.dtype(np.int64).str
        self._same_step = autoreset_mode(options.autoreset_mode) == AutoresetMode.SAME_STEP
        self._mark: npt.NDArray[np.uint8] | None = None  # the first bytes of `frames`, called after the last `add`
        self._started = False  # whether an `add` has found that a reset came first
        self._rings: dict[str, npt.NDArray[np.uint8]] = {}
        for index, (name, shape) in enumerate(self._arrays.frame_shapes.items()):
            offset, places = core.places(index)
            self._rings[name] = np.ndarray((places, *shape), np.uint8, block, offset)

    @classmethod
    def for_env(cls, envs: Any, capacity: int, num_envs: int | None = None, **options: Any) -> "ReplayMemory":
        """A memory with the shapes and the autoreset mode of a vector environment.

        An `AtariVectorEnv` must be made with `stack_num=1`; the memory also takes its padding. Images get stacks of 4,
        RAM stacks of 1; `stack_num` chooses others. `ReplayMemory` has the other options.

        Instead of `envs`, a user may give a game as `AtariVectorEnv` takes it, with `num_envs`. The memory then makes
        the stacks of the game's task, for environments of this task with `stack_num=1`.

        Raises:
            TypeError, ValueError: the environment's observations are no uint8 arrays, or its options do not fit.
        """
        return cls(capacity, **{**options_for(envs, num_envs), **options})

    @classmethod
    def from_dataset(
        cls,
        source: Source | Iterable[Source],
        *,
        capacity: int | None = None,
        reward_clipping: bool | None = None,
        **options: Any,
    ) -> "ReplayMemory":
        """A memory with the steps of a data set, for learning from recorded games (offline reinforcement learning).

        The data are what an agent saw (`write_dataset(..., observations="seen")`, `atari collect --observations seen`),
        or replays, whose games are played again, twice. `sample` gives the observations that the agent got, equal to
        the bit: the data set's task decides their shapes, the stacks and the padding. One episode at a time is in main
        memory beside the memory itself.

        Episodes end where the agent's did: a lost life that began a new stack is a termination. The data have no
        observation between such a life and the next: the newest frame of `next_observations` is there the first of the
        next life, and the step's discount is 0.

        The memory is one of a single environment in NEXT_STEP mode. With a larger `capacity`, `reset` and `add` go on
        with steps of an environment of the same task.

        Args:
            source: an HDF5 or Parquet file, a folder of Parquet files, the ID of a Minari dataset; or a replay, or
                several of one task: `Replay`s or files.
            capacity: the number of latest steps that are kept, see the class; None is what the data need: their steps,
                and an observation after the end of each episode but the last.
            reward_clipping: clip rewards to -1..1; None decides as the task that was played.
            options: options of the class, except those which the task decides: `num_envs`, `observation_shape`,
                `stack_num`, `padding`, `autoreset_mode`, `action_shape` and `action_dtype`. A memory with a `path` is
                flushed.

        Raises:
            FileNotFoundError: there is no such file or dataset.
            ValueError: it has no data of what an agent saw, or `capacity` is too small for them; or the task has
                rewards or lost lives that the memory does not serve. Nothing has been read then but `stack`. Or
                `compressed_bytes` is too small.
            TypeError: an option is of the wrong kind, or the task decides it.
            MemoryError: the machine has too little memory available.
            BufferError: the memory has a `path` and autoflush=False, and the data have more steps than `margin`.
            gymnasium.error.DependencyNotInstalled: the package that reads the format is not installed.

        Example:
            >>> import atari
            >>> from atari.learning import ReplayMemory
            >>> from atari.recording import RecordReplay
            >>> with RecordReplay(atari.make("pong", preset="dqn2015"), "game.a26r") as env:
            ...     observation, info = env.reset(seed=0)
            ...     for _ in range(10):
            ...         observation = env.step(2)[0]
            >>> memory = ReplayMemory.from_dataset("game.a26r", seed=0)
            >>> len(memory), memory.sample(32, n=3).observations.shape
            (10, (32, 4, 84, 84))
        """
        data = open_data(source)
        clip = data.task.reward_clipping if reward_clipping is None else check_bool("reward_clipping", reward_clipping)
        steps, rows = rows_of(data)
        if capacity is not None and check_integer("capacity", capacity, 1, 2**40) < rows:
            raise ValueError(
                f"capacity={capacity} is too small: the data have {steps} steps, which need a capacity of {rows} with "
                "the observations after ends; leave capacity out, or collect fewer episodes"
            )
        decided = options_of(data.task)
        if given := decided.keys() & options.keys():
            raise TypeError(f"the task of the data decides {min(given)}; leave it out")
        memory = cls(rows if capacity is None else capacity, **decided, **options)
        try:
            for episode in data:
                memory._add_episode(episode, clip)
                del episode  # before the next is read
            if len(memory) < steps:
                raise ValueError(
                    f"compressed_bytes is too small: {len(memory)} of {steps} steps fit; give more, or leave it out"
                )
            memory.flush()
        except BaseException:
            memory._discard()
            raise
        return memory

    def _add_episode(self, episode: StoredEpisode, clip: bool) -> None:
        assert episode.frames is not None
        assert episode.stack is not None
        frames = episode.frames.reshape(len(episode.frames), *self._arrays.frame_shapes[""])
        begun = episode.stack[1:] == Stacking.BEGUN  # by a step that lost a life
        rewards = np.clip(episode.rewards, -1, 1) if clip else episode.rewards
        columns = (episode.actions, rewards, episode.terminations | begun, episode.truncations & ~begun)
        steps = zip(frames[1:], begun.tolist(), *[column[:, None] for column in columns], strict=True)
        self.reset(frames[0])
        for frame, begins, *step in steps:
            np.copyto(self.frames(), frame)
            self.add(*step)
            if begins:
                self.reset(frame)

    @atomic
    def frames(self) -> Any:
        """The array for the observations of the next step, which `AtariVectorEnv.step` takes as `out`.

        uint8 (num_envs, *observation_shape), or a dict of such arrays. Call this method again for every step: the array
        is memory of the ring, which is written again after `capacity` steps.

        Raises:
            BufferError: with autoflush=False, these frames would overwrite the state of the last flush.
        """
        core = self._core
        self._make_space(core)
        place = core.next_place()
        frames = {name: ring[place] for name, ring in self._rings.items()}
        self._mark = next(iter(frames.values())).reshape(-1)[: len(_UNWRITTEN)]
        self._mark[:] = _UNWRITTEN[: len(self._mark)]
        return frames if self._arrays.named else frames[""]

    @atomic
    def reset(self, observations: Any, mask: Any = None) -> None:
        """Begin new episodes with the observations that a reset returned. Episodes that had not ended are truncated.

        Args:
            observations: uint8 (num_envs, *observation_shape), or a dict of these.
            mask: bool (num_envs,), the `reset_mask` of the environments, for DISABLED: environments that it leaves out
                go on, and their rows are ignored. None is all environments.

        Raises:
            TypeError, ValueError: an array does not fit; nothing has changed.
            BufferError: with autoflush=False, the state of the last flush would be overwritten; nothing has changed.
        """
        arrays = self._arrays.frames("observations", observations)
        if mask is None:
            self._write_frames(arrays)
            self._core.reset(None, [])
            self._mark = None
            return
        chosen = self._arrays.flags("mask", mask)
        core = self._core
        self._make_space(core)
        core.reset(chosen, [np.ascontiguousarray(array) for array in arrays])

    @atomic
    def add(
        self,
        actions: Any,
        rewards: Any,
        terminations: Any,
        truncations: Any,
        info: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None = None,
        *,
        observations: Any = None,
    ) -> None:
        """Complete a step of all environments with the results of `step(actions)`.

        Args:
            actions: (num_envs, *action_shape), of values that `action_dtype` can store; floats are rounded.
            rewards: numbers (num_envs,), stored as float32.
            terminations, truncations: bool (num_envs,).
            info: in SAME_STEP, with `final_obs` of the environments that ended; a dict, or a dict for each environment.
            observations: uint8 (num_envs, *observation_shape), or a dict of these, which are copied to `frames`. None
                if the step has written them there.

        Raises:
            gymnasium.error.ResetNeeded: before the first `reset`.
            TypeError, ValueError: an array does not fit, an action or a stored reward is not finite, or a final
                observation is missing; or `observations` is None, and the step has not written to `frames`. Nothing has
                changed.
            BufferError: with autoflush=False, the state of the last flush would be overwritten; nothing has changed.
        """
        core = self._core
        if observations is not None:  # nothing reads them before the step is complete
            self._write_frames(self._arrays.frames("observations", observations))
        elif not self._are_written() and self._begun(core):
            raise ValueError(
                "the observations of this step are missing: pass add(..., observations=observations), or let the step "
                "write them, by envs.step(actions, out=memory.frames())"
            )
        if self._usual_actions and core.try_add(actions, rewards, terminations, truncations):
            self._mark = None
            return
        terminations = self._arrays.flags("terminations", terminations)
        truncations = self._arrays.flags("truncations", truncations)
        rewards = self._arrays.rewards(rewards)
        actions = self._arrays.actions(actions)
        finals: list[Any] = []
        if self._same_step and (terminations.any() or truncations.any()):
            finals = self._arrays.finals(info, terminations | truncations)
        if not self._begun(core):
            raise gymnasium.error.ResetNeeded("call reset(observations) before the first add")
        self._started = True
        self._make_space(core)
        core.add(actions, rewards, terminations, truncations, finals)
        self._mark = None

    def _are_written(self) -> bool:
        """Whether the step has written frames to the array of `frames`; shorter ones than the mark are not checked."""
        mark = self._mark
        return mark is not None and (len(mark) < len(_UNWRITTEN) or mark.tobytes() != _UNWRITTEN.tobytes())

    def _begun(self, core: _emulator.ReplayMemory) -> bool:
        return self._started or bool(core.numbers[0])

    def _write_frames(self, arrays: list[npt.NDArray[np.uint8]]) -> None:
        to = self.frames()
        for name, array in zip(self._rings, arrays, strict=True):
            np.copyto(to[name] if self._arrays.named else to, array)

    @atomic
    def observations(self, *, stack_num: int | Mapping[str, int] | None = None, out: Any = None) -> Any:
        """The present observations of all environments, for the choice of actions.

        Args:
            stack_num: see `sample`.
            out: a C-contiguous uint8 array or CPU tensor for the result, or a dict of these.

        Returns:
            uint8 (num_envs, stack_num, *frame), see the class, or a dict of such arrays; `out` if it was given.

        Raises:
            ValueError: before the first `reset`, or `out` does not fit.
        """
        stacks = self._options.stacks(stack_num)
        shapes = {part.name: (self.num_envs, *part.stacked(stacks[part.name])) for part in self._options.parts}
        if out is None:
            arrays = {name: np.empty(shape, np.uint8) for name, shape in shapes.items()}
        else:
            given = out if self._arrays.named else {"": out}
            if not isinstance(given, Mapping) or set(given) != set(shapes):
                raise TypeError(f"out must be a dict with the keys {', '.join(shapes)}")
            arrays = {name: as_numpy("out", given[name]) for name in shapes}
            for name, shape in shapes.items():
                if arrays[name].shape != shape:
                    raise ValueError(f"out must have the shape {shape}, got {arrays[name].shape}")
        self._core.observe([stacks[name] for name in shapes], [arrays[name] for name in shapes])
        return out if out is not None else arrays if self._arrays.named else arrays[""]

    def make_batch(
        self,
        batch_size: int,
        *,
        stack_num: int | Mapping[str, int] | None = None,
        torch: bool = False,
        pin_memory: bool = False,
        share: bool = False,
    ) -> Batch:
        """Arrays for `sample(batch_size, out=...)`, for repeated use.

        Args:
            batch_size: the number of transitions.
            stack_num: see `sample`.
            torch: make tensors of PyTorch on the CPU.
            pin_memory: make tensors in page-locked memory, from which a GPU copies asynchronously; without CUDA no
                effect.
            share: store the frames that `observations` and `next_observations` have in common once, in `frames`, of
                which both are views: with stacks of four 35 KB a transition instead of 56 KB. For n=1 only. The views
                are not contiguous, and a change to one changes the other.

        Raises:
            gymnasium.error.DependencyNotInstalled: PyTorch is not installed.
        """
        stacks = self._options.stacks(stack_num)
        size, array = check_size(batch_size), array_maker(torch, pin_memory)
        return cast(Batch, make_batch(self._options, size, 0, stacks, array, share))

    def make_sequences(
        self,
        batch_size: int,
        length: int,
        *,
        stack_num: int | Mapping[str, int] | None = None,
        torch: bool = False,
        pin_memory: bool = False,
    ) -> Sequences:
        """Arrays for `sample_sequences(batch_size, length, out=...)`; see `make_batch`."""
        stacks = self._options.stacks(stack_num)
        size, length = check_size(batch_size), check_integer("length", length, 1, _SEQUENCE_MOST)
        return cast(Sequences, make_batch(self._options, size, length, stacks, array_maker(torch, pin_memory)))

    @atomic
    def sample(
        self,
        batch_size: int,
        *,
        n: int = 1,
        gamma: float = 0.99,
        beta: float | None = None,
        stack_num: int | Mapping[str, int] | None = None,
        out: Batch | None = None,
    ) -> Batch:
        """Transitions of up to n steps of one episode, drawn with replacement.

        A transition begins with any step after which n steps, or the end of its episode, are known. The target of a
        value is `rewards + discounts * value(next_observations)`, at a truncation too.

        Args:
            batch_size: the number of transitions.
            n: steps of a transition; it ends earlier where its episode does.
            gamma: discount of a step, within 0..1.
            beta: draw by priority, in equal strata (Schaul et al. 2016), and with importance weights of this exponent;
                None draws uniformly.
            stack_num: frames in an observation, at most the memory's `stack_num`, which is also the default. A batch
                in `out` has its own number.
            out: a batch to write to, from `make_batch` or with your own arrays and CPU tensors. A batch with shared
                frames needs n=1.

        Returns:
            A `Batch`, `out` if it was given. Its attributes are arrays of NumPy, or CPU tensors of PyTorch.

            - `observations`: uint8 (batch, stack_num, ...), or a dict of these;
            - `actions`: (batch, *action_shape), of `action_dtype`;
            - `rewards`: float32 (batch,), the discounted sum of the rewards of the steps;
            - `next_observations`: as `observations`, after the last step; the real last ones at the end of an episode;
            - `discounts`: float32 (batch,), gamma to the power of the number of steps, and 0 at a termination;
            - `terminations`, `truncations`: bool (batch,), how the last step ended. A reset before the end of an
                episode is a truncation;
            - `indices`: int64 (batch,), the numbers of the steps, for `update_priorities`. No number is used twice;
            - `env_id`: int64 (batch,), the environments of the steps;
            - `weights`: float32 (batch,), importance weights, divided by their maximum; 1 in uniform sampling;
            - `frames`: uint8 (batch, stack_num + 1, ...), or a dict of these, after `make_batch(..., share=True)`:
                `observations` and `next_observations` are views of it. Otherwise None.

        Raises:
            TypeError, ValueError: an argument does not fit, no step can be drawn yet, or all priorities are 0.
        """
        core, size, reach = self._core, check_size(batch_size), check_integer("n", n, 1, 2**40)
        batch, target = self._batch(core, size, 0, stack_num, out)
        core.sample(target, reach, float(gamma), None if beta is None else float(beta), self._threads)
        return cast(Batch, batch)

    def _batch(
        self, core: _emulator.ReplayMemory, size: int, length: int, stack_num: Any, out: Batch | Sequences | None
    ) -> tuple[Batch | Sequences, _emulator.ReplayTarget]:
        """The batch to write to, `out` or a new one, and its target; with a length other than 0, of sequences."""
        if out is None:
            return self._pool.take(core, size, length, self._options.stacks(stack_num))
        if stack_num is not None:
            raise ValueError("out has a number of frames; leave stack_num out")
        return out, target_of(out, core, self._options, size, length)

    @atomic
    def sample_sequences(
        self,
        batch_size: int,
        length: int,
        *,
        stack_num: int | Mapping[str, int] | None = None,
        out: Sequences | None = None,
    ) -> Sequences:
        """Sequences of steps of one episode, whose starts are drawn uniformly with replacement.

        A sequence starts with a step after which `length` steps, or an end, are known.

        Args:
            batch_size: the number of sequences.
            length: steps in each.
            stack_num, out: see `sample`, and `make_sequences`.

        Returns:
            A `Sequences`, `out` if it was given. Its attributes are arrays of NumPy, or CPU tensors of PyTorch.

            - `observations`: uint8 (batch, length + 1, stack_num, ...), or a dict of these; observation i + 1 follows
                step i;
            - `actions`: (batch, length, *action_shape), of `action_dtype`;
            - `rewards`: float32 (batch, length);
            - `terminations`, `truncations`: bool (batch, length);
            - `mask`: bool (batch, length), False after the end of the episode, where all else is 0;
            - `indices`: int64 (batch,), the numbers of the first steps;
            - `env_id`: int64 (batch,), the environments.

        Raises:
            TypeError, ValueError: an argument does not fit, or no sequence can be drawn yet.
        """
        core, size = self._core, check_size(batch_size)
        length = check_integer("length", length, 1, _SEQUENCE_MOST)
        batch, target = self._batch(core, size, length, stack_num, out)
        core.sample(target, length, 1.0, None, self._threads)
        return cast(Sequences, batch)

    @atomic
    def update_priorities(self, indices: Any, priorities: Any) -> None:
        """Set the priorities of sampled steps, before the exponent: commonly the magnitude of their TD errors.

        New steps have the greatest priority that was given to a step of the rows that are still stored, 1 if none was.
        Steps that have been overwritten are left out.

        Args:
            indices: int64 (batch,), as `sample` returned them.
            priorities: numbers (batch,) within 0..1e100, whose powers by `priority_exponent` are, too.

        Raises:
            TypeError, ValueError: the memory has no priorities, or an array does not fit; nothing has changed.
        """
        steps, values = as_numpy("indices", indices), as_numpy("priorities", priorities)
        if steps.dtype.kind not in "iu" or values.dtype.kind not in "iuf":
            raise TypeError(f"indices must be integers and priorities numbers, got {steps.dtype} and {values.dtype}")
        if steps.ndim != 1 or values.shape != steps.shape:
            raise ValueError(f"indices and priorities must be (batch,), got {steps.shape} and {values.shape}")
        self._core.update_priorities(np.ascontiguousarray(steps, np.int64), np.ascontiguousarray(values, np.float64))

    @atomic
    def __len__(self) -> int:
        """Steps that `sample` can draw with n=1."""
        return self._core.count(1)

    @atomic
    def count(self, n: int = 1) -> int:
        """Steps that `sample` can draw with this n."""
        return self._core.count(check_integer("n", n, 1, 2**40))
