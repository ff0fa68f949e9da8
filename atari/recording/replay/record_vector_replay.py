"""`RecordVectorReplay`: a wrapper that records one environment of a vector in a replay.

A vector plays its environments in C++ and does not return the frames inside a step or the no-ops of a reset. So a
shadow, a single environment with the same seed and actions, is recorded instead. After each step both must have the
same RAM and frame numbers; a difference raises an error.
"""

from os import PathLike
from typing import Any

import numpy as np

from atari._gymnasium import AutoresetMode, VectorEnv, VectorWrapper
from atari.cores.options import SEED_LIMIT
from atari.env import AtariEnv
from atari.making import make_env
from atari.recording.replay.record_replay import RecordReplay
from atari.validation import check_integer
from atari.vector.env import AtariVectorEnv
from atari.vector.members import Member
from atari.vector.seeds import seed_values

FIRE, NOOP = 1, 0


class RecordVectorReplay(VectorWrapper):
    """Record one environment of an `AtariVectorEnv` in a replay.

    If the first `reset` has no seed, all environments get random seeds, because the replay needs the seed of its
    environment. Bytes of RAM that are set and the writes of `atari.lab.Freeze` and `Poke` are recorded. If the mode,
    difficulty or state of the environment is set from outside, the recording ends with an error.

    Args:
        envs: an `AtariVectorEnv` with batches of all environments.
        path: the file, with the suffix ".a26". Its folder is created, and a file of this name replaced.
        index: the number of the recorded environment.

    Raises:
        TypeError: `envs` is not an `AtariVectorEnv`.
        ValueError: there is no such environment, the vector cannot be recorded, or the environment has a `Freeze` or a
            `Poke` already.
        OSError: the file cannot be written. Later errors are deferred, see `RecordReplay`.

    Example:
        >>> import atari, numpy
        >>> from atari.recording import RecordVectorReplay, Replay
        >>> envs = RecordVectorReplay(atari.AtariVectorEnv("pong", 4), "game.a26", index=2)
        >>> observations, info = envs.reset(seed=0)
        >>> for _ in range(10):
        ...     observations = envs.step(numpy.zeros(4, int))[0]
        >>> envs.close()
        >>> Replay.load("game.a26").frames_total > 0
        True
    """

    def __init__(self, envs: VectorEnv, path: str | PathLike[str], index: int = 0) -> None:
        inner = envs.unwrapped
        if not isinstance(inner, AtariVectorEnv):
            raise TypeError(f"RecordVectorReplay records an atari.AtariVectorEnv, got {type(inner).__name__}")
        if inner.batch_size != inner.num_envs:
            raise ValueError("RecordVectorReplay needs batches of all environments, with batch_size=0")
        super().__init__(envs)
        self._vector = inner
        self._index = check_integer("index", index, 0, inner.num_envs - 1)
        self._added = inner.members[self._index].added
        if self._added.slots:
            raise ValueError("the environment has a Freeze or a Poke; release it, and make it after RecordVectorReplay")
        self._seeded = not inner.started
        self._shadow = _make_shadow(inner, self._index, path)
        self._recorder = self._shadow.env.recorder
        self.path = self._recorder.path
        self._core = self._shadow.env.unwrapped.core
        self._added.shadows.append(self._core)

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
        chosen = seed_values(seed, mask).get(self._index)
        if mask[self._index] and chosen is None and not self._seeded:
            raise ValueError("the vector was reset before it was recorded; give this first reset a seed")
        result: tuple[Any, dict[str, Any]] = self.env.reset(seed=seed, options=options)
        if mask[self._index] and self._recorder.open:
            self._seeded = True
            self._shadow.reset(chosen)
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
        result = self.env.step(actions)
        if not self._recorder.open:
            return result
        info = result[4]
        final = info["final_info"]["frame_number"][row] if info.get("_final_info", [False] * (row + 1))[row] else None
        self._shadow.step(int(indices[row]), 1.0 if strengths is None else float(strengths[row]), final)
        self._compare()
        return result

    def stop(self) -> None:
        """Complete the file; the environments can continue without a recording."""
        self._added.shadows = [each for each in self._added.shadows if each is not self._core]
        self._shadow.env.close()

    def close(self, **kwargs: Any) -> None:
        """Complete the file and close the environments."""
        self.stop()
        super().close(**kwargs)

    def _compare(self) -> None:
        member, core = self._shadow.member, self._shadow.env.unwrapped.core
        if core.frame_number != member.frame_number or core.ram().tobytes() != member.ram().tobytes():
            self.stop()
            raise RuntimeError(
                f"environment {self._index} differs from its recording; was its mode or state set from outside, "
                f"or its action changed by a wrapper inside this one? {self.path} ends before this step"
            )


class _AleShadow:
    """Repeats an environment with ale-py's options. The frame numbers determine the number of no-ops."""

    def __init__(self, vector: AtariVectorEnv, member: Member, env: RecordReplay) -> None:
        self.env, self.member = env, member
        self._core: Any = env.get_wrapper_attr("core")
        self._actions = vector.options.actions[member.index]
        task = vector.options.tasks[member.index]
        self._fires = task.fire != "never" and FIRE in task.begin_actions
        self._episode_frames = 0

    def reset(self, seed: int | None) -> None:
        core = self._core
        if seed is not None:
            core.seed(seed % SEED_LIMIT)
        core.reset()
        if self._fires:
            core.act(FIRE)
        while core.frame_number < self.member.frame_number:
            core.act(NOOP)
            if core.game_over:
                core.reset()
        self.env.recorder.flush_if_full()
        self._episode_frames = self.member.episode_frame_number

    def step(self, index: int, strength: float, final: int | None) -> None:
        member, core = self.member, self._core
        target = member.frame_number if final is None else int(final)
        went_on = self._episode_frames + target - core.frame_number
        if final is None and member.episode_frame_number != went_on:
            return self.reset(None)
        if core.frame_number < target:
            self.env.recorder.begin_step()
            while core.frame_number < target and not core.game_over:
                core.act(int(self._actions[index]), strength)
            self.env.recorder.end_step()
        if final is not None:
            self.reset(None)
        self._episode_frames = member.episode_frame_number


class _PresetShadow:
    """Repeats an environment with a preset, by the preset's wrappers."""

    def __init__(self, vector: AtariVectorEnv, member: Member, env: RecordReplay) -> None:
        self.env, self.member = env, member
        self._autoreset = vector.options.autoreset_mode
        self._over = False

    def reset(self, seed: int | None) -> None:
        self.env.reset(seed=seed)
        self._over = False

    def step(self, index: int, strength: float, final: int | None) -> None:
        if self._over and self._autoreset == AutoresetMode.DISABLED:
            return
        if self._over:
            return self.reset(None)
        _, _, terminated, truncated, _ = self.env.step(index)
        self._over = terminated or truncated
        if self._over and self._autoreset == AutoresetMode.SAME_STEP:
            self.reset(None)


def _make_shadow(vector: AtariVectorEnv, index: int, path: str | PathLike[str]) -> Any:
    options, member = vector.options, vector.members[index]
    task = options.tasks[index]
    if task.seeding == "ale":
        emulator = task.of_emulator().replace(
            frameskip=task.frameskip, actions="full" if options.mixed else task.actions, max_num_frames_per_episode=None
        )
        return _AleShadow(vector, member, RecordReplay(AtariEnv(emulator, rom=options.rom), path))
    if options.mixed:
        raise ValueError("environments with wrappers can be recorded only if all games have the same actions")
    return _PresetShadow(vector, member, RecordReplay(make_env(task, rom=options.rom), path))
