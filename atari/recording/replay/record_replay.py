"""`RecordReplay`: records a game in a file of a few kilobytes a minute."""

import weakref
from os import PathLike
from typing import TYPE_CHECKING, Any, overload

import gymnasium
import numpy as np

from atari.base.gymnasium_versions import AutoresetMode, VectorEnv, VectorWrapper
from atari.base.validation import check_arguments, check_integer
from atari.cores.options import SEED_LIMIT
from atari.env import AtariEnv
from atari.env.lane_snapshot import LaneSnapshot
from atari.env.restorable import RestorableWrapper
from atari.env.settings import make_episode
from atari.multiplayer.core import MultiplayerCore
from atari.recording.recordable import not_recorded, recorded_vector
from atari.recording.replay.events import Kind
from atari.recording.replay.players import RecordMatch
from atari.recording.replay.recorded_core import RecordedCore, ReplayRecorder, header_of, not_copied
from atari.vector.env import is_vector
from atari.vector.options import VectorOptions
from atari.vector.seeds import seed_words


class RecordEnvReplay(RestorableWrapper):
    """Records an `AtariEnv` in a replay: `RecordReplay(env, path)` makes it."""

    def __init__(self, env: gymnasium.Env[Any, Any], path: str | PathLike[str]) -> None:
        inner = getattr(env, "unwrapped", env)
        if not isinstance(inner, AtariEnv):
            raise not_recorded(env, "RecordReplay")
        if isinstance(inner.driver.emulated, RecordedCore):
            raise ValueError("this environment is being recorded already; close that RecordReplay first")
        super().__init__(env, path=path)
        self._atari = inner
        emulated = inner.driver.emulated
        started = emulated.snapshot() if inner.driver.phase != "new" else None
        self.recorder = ReplayRecorder(path, header_of(inner, type(inner).__name__), emulated)
        """The recorder, which has the number of frames and the score so far."""
        self._finalizer = weakref.finalize(self, self.recorder.close)  # completes the file if `close` is not called
        self.path = self.recorder.path
        core = RecordedCore(emulated, self.recorder)
        core.record_writes()
        if started is not None:
            self.recorder.record_restore(started)
        else:
            core.seed(int(np.random.SeedSequence().generate_state(1)[0]) % (SEED_LIMIT - 1))
        inner.driver.emulated = core

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset the environment."""
        self.recorder.raise_deferred_error()
        result = self.env.reset(seed=seed, options=options)
        self.recorder.flush_if_full()
        return result

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Play a step."""
        self.recorder.raise_deferred_error()
        self.recorder.begin_step()
        if self._atari.continuous:
            self._record_continuous_action(action)
        result = self.env.step(action)
        self.recorder.end_step()
        return result

    def stop(self) -> None:
        """Complete the file; the environment can continue without a recording."""
        core = self._atari.driver.emulated
        if isinstance(core, RecordedCore):
            self._atari.driver.emulated = core.inner
        self._finalizer.detach()
        self.recorder.close()

    def close(self) -> None:
        """Complete the file and close the environment."""
        try:
            self.stop()
        finally:
            self.env.close()

    def __getstate__(self) -> dict[str, Any]:
        raise not_copied()

    def _record_continuous_action(self, action: Any) -> None:
        try:
            radius, angle, fire = (float(number) for number in np.asarray(action, np.float32))
        except (TypeError, ValueError):
            return  # the environment's step raises a better error
        self.recorder.record(Kind.CONTINUOUS_ACTION, (), (radius, angle, fire))


class Shadow:
    """A recorded core that repeats what one environment of a vector plays, call by call.

    Args:
        options: the options of the vector.
        index: the environment.
        path: the file of the replay.
        observed: whether its episode draws the environment's observations, which `restore` needs; this costs time.

    Raises:
        ValueError, OSError: see `RecordReplay`.
    """

    def __init__(
        self, options: VectorOptions, index: int, path: str | PathLike[str], *, observed: bool = False
    ) -> None:
        self._options, self._index = options, index
        self._recorded = RecordReplay(shadow_env(options, index), path)
        self.recorder = self._recorded.recorder
        inner: Any = self._recorded.unwrapped
        self.core = inner.core
        """The core, whose calls are recorded."""
        self._episode = make_episode(options.tasks[index], observed=observed)

    def reset(self, seed: list[int] | None = None, new_game: bool = False) -> None:
        """Begin an episode, as the environment has. `seed` is nine words of `atari.vector.seeds`; None continues."""

        def begin() -> Any:
            if seed is not None:
                self.core.seed(seed[0])
            self.core.reset()
            return self.core

        self._episode.reset(self.core, begin, seed=seed, new_game=new_game)
        self.recorder.flush_if_full()

    def step(self, index: int, strength: float) -> None:
        """Play a step with the index of an action, and the reset that the autoreset mode makes in this step."""
        was_over, mode = self._episode.ended, self._options.autoreset_mode
        if not was_over:
            self.recorder.begin_step()
            self._episode.step(self.core, int(self._options.actions[self._index][index]), strength)
            self.recorder.end_step()
        if {AutoresetMode.NEXT_STEP: was_over, AutoresetMode.SAME_STEP: self._episode.ended}.get(mode):
            self.reset()

    def restore(self, snapshot: LaneSnapshot) -> None:
        """Continue from the state of an environment; the file then contains it, and the score counts from there."""
        data, size = snapshot.state.content(self.core.inner), len(self.core.save())
        self.core.restore(self.core.snapshot_of(data[1 : 1 + size]))
        self._episode.load(data[:1] + data[1 + size :])

    def is_at(self, snapshot: LaneSnapshot) -> bool:
        """Whether the core is in the state of the environment's emulator in a snapshot."""
        state = self.core.save()
        return bool(snapshot.state.content(self.core.inner)[1 : 1 + len(state)] == state)

    def close(self) -> None:
        """Complete the file."""
        self._recorded.close()


class RecordVectorReplay(VectorWrapper):
    """Records one environment of an `AtariVectorEnv` in a replay: `RecordReplay(envs, path, index)` makes it.

    A vector plays its environments in C++ and does not return the frames inside a step or the no-ops of a reset. So the
    resets and steps of the environment are repeated on a core whose calls are recorded, its shadow. It has the same
    seed and plays the same actions, so its RAM and frame numbers must be equal after each step. If the mode, difficulty
    or state of the environment is set from outside, the recording ends with an error.

    If the first `reset` has no seed, all environments get random seeds, because the replay needs the seed of its
    environment.
    """

    def __init__(self, envs: VectorEnv, path: str | PathLike[str], index: int = 0) -> None:
        inner = recorded_vector(envs, "RecordReplay")
        super().__init__(envs)
        self._vector = inner
        self._index = check_integer("index", index, 0, inner.num_envs - 1)
        self._lane = inner.lanes[self._index]
        self._added = self._lane.added
        if self._added.slots:
            raise ValueError("the environment has a Freeze or a Poke; release it, and make it after RecordReplay")
        self._seeded = not inner.started
        self._shadow = Shadow(inner.options, self._index, path)
        self._recorder = self._shadow.recorder
        self.path = self._recorder.path
        self._added.shadows.append(self._shadow.core)

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset environments; if the recorded one is among them, reset its shadow.

        Raises:
            ValueError: the vector was reset before it was wrapped, and this first reset has no seed.
        """
        vector = self._vector
        self._recorder.raise_deferred_error()
        if seed is None and not vector.started and self._seeded:
            seed = np.random.SeedSequence().generate_state(vector.num_envs).astype(np.int64)
        mask = vector.reset_mask(options)
        seeded, words = seed_words(seed, mask, ale=vector.task.seeding == "ale")
        chosen = words[self._index].tolist() if seeded[self._index] else None
        if mask[self._index] and chosen is None and not self._seeded:
            raise ValueError("the vector was reset before it was recorded; give this first reset a seed")
        result: tuple[Any, dict[str, Any]] = self.env.reset(seed=seed, options=options)
        if mask[self._index] and self._recorder.open:
            self._seeded = True
            self._shadow.reset(chosen, new_game=bool((options or {}).get("new_game")))
            self._compare()
        return result

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Play a step.

        Raises:
            RuntimeError: the recorded environment and its shadow differ.
        """
        indices, strengths = self._vector.options.moves(actions)
        row = self._index
        self._recorder.raise_deferred_error()
        result: tuple[Any, Any, Any, Any, dict[str, Any]] = self.env.step(actions)
        if self._recorder.open:
            self._shadow.step(int(indices[row]), 1.0 if strengths is None else float(strengths[row]))
            self._compare()
        return result

    def stop(self) -> None:
        """Complete the file; the environments can continue without a recording."""
        self._added.shadows = [each for each in self._added.shadows if each is not self._shadow.core]
        self._shadow.close()

    def close(self, **kwargs: Any) -> None:
        """Complete the file and close the environments."""
        self.stop()
        super().close(**kwargs)

    def __getstate__(self) -> dict[str, Any]:
        raise not_copied()

    def _compare(self) -> None:
        lane, core = self._lane, self._shadow.core
        if core.frame_number != lane.frame_number or core.ram().tobytes() != lane.ram().tobytes():
            self.stop()
            raise RuntimeError(
                f"environment {self._index} differs from its recording; was its mode or state set from outside, "
                f"or its action changed by a wrapper inside this one? {self.path} ends before this step"
            )


def shadow_env(options: VectorOptions, index: int) -> AtariEnv:
    """An `AtariEnv` with the core of environment `index` of a vector; the replay's header describes it.

    With ale-py's seeding, the header has the emulator's fields and the frame skip; otherwise it has the whole task.
    """
    task = options.tasks[index]
    alone = task.emulator_task() if task.preprocessed else task.replace(max_episode_steps=None)
    if options.mixed:
        alone = alone.replace(actions="full")
    env = AtariEnv(alone.replace(frameskip=task.frameskip) if task.seeding == "ale" else alone, rom=options.rom)
    env.whole_task = task
    return env


class RecordReplay(RecordEnvReplay):
    """Records everything that is played, by any wrapper, in one replay, which `Replay.load` reads.

    - Of an `AtariEnv`, in any wrappers, the replay has the calls of the core: no-op resets, the frames of a frame skip,
      sticky actions, `set_ram`, `restore`, seeds, and the writes of `atari.lab.Freeze` and `Poke`. As the outermost
      wrapper, `RecordReplay` also records where steps end, which `to_minari` needs.
    - Of an `AtariVectorEnv`, `RecordReplay(envs, path, index=0)` records environment `index` alone. The vector needs
      batches of all environments; after a reset without a recorder, the first reset needs a seed.
    - Of a `MultiplayerCore` with frameskip=1, the replay has the seeds, resets, actions, snapshots and writes to RAM.
      The recorder has the methods of the core, but for `set_mode` and `set_difficulty`, because the file has both.

    Close the recorder to complete the file. If the process is killed, the file holds everything but the last seconds.

    If the environment was not reset before, it gets a random seed, which the file holds. If the recording begins in
    the middle of a game, the file begins with a snapshot, and the replay plays only on the same core. The same holds
    after `restore` of a snapshot that was not taken during the recording.

    Args:
        env: the environment, the vector or the core.
        path: the file, with the suffix ".a26r". Its folder is created, and a file of this name replaced.

    Raises:
        TypeError: the environment is another one.
        ValueError: the name has another suffix; there is no environment `index`; the environment is being recorded
            already, or the vector or the core cannot be recorded.
        OSError: the file cannot be written.

    If the file cannot be written any more, for example because the disk is full, the recording ends. The error is
    deferred: the next call of `step`, `reset` or `close` raises it as an `OSError` before it changes anything. The
    environment can continue from there.

    Example:
        >>> import atari
        >>> from atari.recording import RecordReplay, Replay
        >>> env = RecordReplay(atari.make("pong"), "game.a26r")
        >>> observation, info = env.reset(seed=0)
        >>> for _ in range(20):
        ...     observation, reward, terminated, truncated, info = env.step(2)
        >>> env.close()
        >>> Replay.load("game.a26r").frames_total
        80
        >>> envs = RecordReplay(atari.AtariVectorEnv("pong", 4), "third.a26r", index=2)
        >>> observations, info = envs.reset(seed=0)
        >>> envs.close()
    """

    if TYPE_CHECKING:  # at run time `typing` would hold the functions, and all modules, until the process has ended

        @overload
        def __new__(cls, env: gymnasium.Env[Any, Any], path: str | PathLike[str]) -> "RecordReplay": ...
        @overload
        def __new__(cls, env: VectorEnv, path: str | PathLike[str], index: int = 0) -> RecordVectorReplay: ...  # type: ignore[misc]
        @overload
        def __new__(cls, env: MultiplayerCore, path: str | PathLike[str]) -> RecordMatch: ...  # type: ignore[misc]

    def __new__(cls, env: Any = None, *args: Any, **kwargs: Any) -> Any:
        """The recorder of this kind of environment; copying calls this without arguments."""
        match = isinstance(env, MultiplayerCore)
        kind: Any = RecordVectorReplay if is_vector(env) else RecordMatch if match else RecordEnvReplay
        check_arguments("RecordReplay", kind, kwargs)
        return super().__new__(cls) if kind is RecordEnvReplay else kind(env, *args, **kwargs)
