"""`RecordReplay`: a wrapper that records all calls of the core in a file of a few kilobytes a minute."""

import weakref
from os import PathLike
from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils import RecordConstructorArgs

from atari.cores.options import SEED_LIMIT
from atari.env import AtariEnv
from atari.recording.replay.events import Kind
from atari.recording.replay.recorder import RecordedCore, ReplayRecorder, header_of
from atari.restorable import Restorable


class RecordReplay(Restorable, gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """Record everything that is played, by any wrapper, in one replay.

    The replay has the calls of the core: no-op resets, the frames of a frame skip, sticky actions, `set_ram`,
    `restore`, seeds, and the writes of `atari.lab.Freeze` and `Poke`. `Replay.load` reads the file. Close the
    environment to complete it. If the process is killed, the file holds everything but the last seconds.

    If the environment was not reset before, it gets a random seed, which the file holds. If the recording begins in
    the middle of a game, the file begins with a snapshot, and the replay plays only on the same core. The same holds
    after `restore` of a snapshot that was not taken during the recording.

    As the outermost wrapper it also records where steps end, which `to_minari` needs.

    Args:
        env: an `AtariEnv`, in any wrappers.
        path: the file, with the suffix ".a26". Its folder is created, and a file of this name replaced.

    Raises:
        TypeError: the environment is not an `AtariEnv`.
        ValueError: the name has another suffix, or the environment is being recorded already.
        OSError: the file cannot be written.

    If the file cannot be written any more, for example because the disk is full, the recording ends. The error is
    deferred: the next call of `step`, `reset` or `close` raises it as an `OSError` before it changes anything. The
    environment can continue from there.

    Example:
        >>> import atari
        >>> from atari.recording import RecordReplay, Replay
        >>> env = RecordReplay(atari.make("pong"), "game.a26")
        >>> observation, info = env.reset(seed=0)
        >>> for _ in range(20):
        ...     observation, reward, terminated, truncated, info = env.step(2)
        >>> env.close()
        >>> Replay.load("game.a26").frames_total
        80
    """

    def __init__(self, env: gymnasium.Env[Any, Any], path: str | PathLike[str]) -> None:
        inner = env.unwrapped
        if not isinstance(inner, AtariEnv):
            hint = "; for an atari.AtariVectorEnv there is RecordVectorReplay" if hasattr(inner, "num_envs") else ""
            raise TypeError(f"RecordReplay records an atari.AtariEnv, got {type(inner).__name__}{hint}")
        if isinstance(inner.core, RecordedCore):
            raise ValueError("this environment is being recorded already; close that RecordReplay first")
        RecordConstructorArgs.__init__(self, path=path)
        super().__init__(env)
        self._atari = inner
        started = inner.core.snapshot() if inner.driver.phase != "new" else None
        self.recorder = ReplayRecorder(path, header_of(inner, type(inner).__name__), inner.core)
        """The recorder, which has the number of frames and the score so far."""
        self._finalizer = weakref.finalize(self, self.recorder.close)  # without a call of close
        self.path = self.recorder.path
        core = RecordedCore(inner.core, self.recorder)
        core.record_writes()
        if started is not None:
            self.recorder.record_restore(started)
        else:
            core.seed(int(np.random.SeedSequence().generate_state(1)[0]) % (SEED_LIMIT - 1))
        inner.driver.core = core

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
        core = self._atari.core
        if isinstance(core, RecordedCore):
            self._atari.driver.core = core.inner
        self._finalizer.detach()
        self.recorder.close()

    def close(self) -> None:
        """Complete the file and close the environment."""
        try:
            self.stop()
        finally:
            self.env.close()

    def __getstate__(self) -> dict[str, Any]:
        raise TypeError("RecordReplay writes a file and cannot be copied or pickled; call stop(), or copy its env")

    def _record_continuous_action(self, action: Any) -> None:
        try:
            radius, angle, fire = (float(number) for number in np.asarray(action, np.float32))
        except (TypeError, ValueError):
            return  # the environment's step raises a better error
        self.recorder.record(Kind.CONTINUOUS_ACTION, (), (radius, angle, fire))
