"""`RecordReplay`: a wrapper that writes down what is played, in a file of a few kilobytes a minute."""

import weakref
from os import PathLike
from typing import Any

import gymnasium
import numpy as np
from gymnasium.utils import RecordConstructorArgs

from atari.cores.options import SEED_LIMIT
from atari.env import AtariEnv
from atari.recording.recorder import RecordedCore, Recorder, header_of
from atari.recording.replay_events import Kind


class RecordReplay(gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """Record all that is played, by whatever wrappers, in one replay.

    The calls of the emulator are recorded, so no-op resets, frame skips and sticky actions are in it, and `set_ram`,
    `restore` and seeds too. `Replay.load` reads the file. Close the environment to complete it; if the process is
    killed, the file holds all but the last seconds.

    An environment that was not reset before gets a random seed of the emulator, which the file holds, in place of the
    one it was made with, which nobody knows. One that is recorded from the middle of a game on starts from a snapshot,
    and its replay plays on the same core only; so does one that is restored from a snapshot of elsewhere.

    As the outermost wrapper it also notes what was a step; `to_minari` needs that.

    Args:
        env: an `AtariEnv`, in any wrappers.
        path: of the file, ending in ".a26". Its folder is made, and a file of this name replaced.

    Raises:
        TypeError: the environment is no `AtariEnv`.
        ValueError: the name has another ending, or the environment is being recorded already.
        OSError: the file cannot be written.

    If it cannot be written any more, as on a full disk, the recording ends, and the next call of `step`, `reset` or
    `close` raises an `OSError` before it does anything. The game can go on from there.
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
        started = inner.core.snapshot() if inner._phase != "new" else None
        self._recorder = Recorder(path, header_of(inner, type(inner).__name__), inner.core)
        self._finalizer = weakref.finalize(self, self._recorder.close)  # should nobody call close
        self.path = self._recorder.path
        core = RecordedCore(inner.core, self._recorder)
        if started is not None:
            self._recorder.restored(started)
        else:
            core.seed(int(np.random.SeedSequence().generate_state(1)[0]) % (SEED_LIMIT - 1))
        inner.core = core

    @property
    def recorder(self) -> Recorder:
        """What writes the file: frames and score so far."""
        return self._recorder

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset the environment."""
        self._recorder.raise_trouble()
        result = self.env.reset(seed=seed, options=options)
        self._recorder.flush_if_full()
        return result

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Play a step."""
        self._recorder.raise_trouble()
        self._recorder.begin_step()
        if self._atari.continuous:
            self._note_motion(action)
        result = self.env.step(action)
        self._recorder.end_step()
        return result

    def stop(self) -> None:
        """Complete the file; the game can go on, without a recording."""
        core = self._atari.core
        if isinstance(core, RecordedCore):
            self._atari.core = core.inner
        self._finalizer.detach()
        self._recorder.close()

    def close(self) -> None:
        """Complete the file and close the environment."""
        try:
            self.stop()
        finally:
            self.env.close()

    def __getstate__(self) -> dict[str, Any]:
        raise TypeError("RecordReplay writes a file and cannot be copied or pickled; call stop(), or copy its env")

    def _note_motion(self, action: Any) -> None:
        try:
            radius, angle, fire = (float(number) for number in np.asarray(action, np.float32))
        except (TypeError, ValueError):
            return  # the environment refuses it, with a better text
        self._recorder.note(Kind.MOTION, (), (radius, angle, fire))
