"""`Watch`: a wrapper that logs chosen labels and bytes of RAM while a game is played."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, overload

import gymnasium
import numpy as np
import numpy.typing as npt

from atari.base.gymnasium_versions import VectorEnv, VectorWrapper
from atari.base.validation import check_arguments, check_name
from atari.env import AtariEnv
from atari.env.restorable import Restorable
from atari.lab.ram import Ram
from atari.vector.env import AtariVectorEnv, is_vector

Each: TypeAlias = Literal["step", "frame"]
OnChange: TypeAlias = Callable[[str | int, Any, Any], object]
Array: TypeAlias = npt.NDArray[Any]


class _History:
    """The history of a `Watch` and of a `VectorWatch`."""

    _log: "_Log"

    @property
    def history(self) -> dict[str | int, Array]:
        """The values by name or place, int32 (T,), masked where a label is not visible; "frame" is the frame number.

        A log of all lanes of a vector has (T, num_envs).
        """
        return self._log.history()

    def clear(self) -> None:
        """Forget the history."""
        self._log.clear()

    def stop(self) -> None:
        """End the log; the environment can continue."""
        self._log.stopped = True


class EnvWatch(_History, Restorable, gymnasium.Wrapper[Any, Any, Any, Any]):
    """Log values of RAM of an `AtariEnv`: `Watch(env, ...)` makes it."""

    def __init__(
        self,
        env: gymnasium.Env[Any, Any],
        *what: str | int,
        each: Each = "step",
        index: int | None = None,
        on_change: OnChange | None = None,
    ) -> None:
        inner: Any = env.unwrapped
        if not isinstance(inner, AtariEnv):
            raise TypeError(f"Watch logs the RAM of an AtariEnv or an AtariVectorEnv, got {env}")
        check_name("each", each, ("step", "frame"))
        super().__init__(env)
        self._atari = inner
        self._log = _Log(Ram(inner, index=index), what, on_change)
        self._observer = _FrameLogger(self._append) if each == "frame" else None
        self._observe()

    def _observe(self) -> None:
        if self._observer is not None:
            self._atari.driver.observers.append(self._observer)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Log the frames of the copied environment, which has no observers."""
        self.__dict__.update(state)
        self._observe()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset the environment."""
        result = self.env.reset(seed=seed, options=options)
        self._end_step()
        return result

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Play a step."""
        result = self.env.step(action)
        self._end_step()
        return result

    def stop(self) -> None:
        """End the log; the environment can continue."""
        if self._observer is not None and self._observer in self._atari.driver.observers:
            self._atari.driver.observers.remove(self._observer)
        super().stop()

    def close(self) -> None:
        """End the log, and close the environment."""
        self.stop()
        self.env.close()

    def _end_step(self) -> None:
        if self._observer is None:
            self._append()
        self._log.raise_error()

    def _append(self) -> None:
        self._log.append(self._atari.core.frame_number)


class VectorWatch(_History, VectorWrapper):
    """Log values of RAM of all lanes of an `AtariVectorEnv`, or of one, after each reset and step.

    `Watch(envs, ...)` makes it, with the same arguments and errors.
    """

    def __init__(
        self,
        envs: VectorEnv,
        *what: str | int,
        each: Each = "step",
        index: int | None = None,
        on_change: OnChange | None = None,
    ) -> None:
        inner = envs.unwrapped
        if not isinstance(inner, AtariVectorEnv):
            raise TypeError(
                f"Watch logs the RAM of an AtariEnv or an AtariVectorEnv, got {inner}; in another vector, wrap each "
                "environment"
            )
        if each != "step":
            raise ValueError(f"a vector is logged by steps, each='step', got each={each!r}; watch an AtariEnv instead")
        super().__init__(envs)
        self._log = _Log(Ram(inner, index=index), what, on_change)
        self._lanes = inner.lanes if index is None else (inner.lanes[index],)
        self._single = index is not None

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset the lanes."""
        result: tuple[Any, dict[str, Any]] = self.env.reset(seed=seed, options=options)
        self._append()
        return result

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Play a step."""
        result: tuple[Any, Any, Any, Any, dict[str, Any]] = self.env.step(actions)
        self._append()
        return result

    def _append(self) -> None:
        frames = [lane.frame_number for lane in self._lanes]
        self._log.append(frames[0] if self._single else frames)
        self._log.raise_error()


class Watch(EnvWatch):
    """Log values of RAM after each reset, and after each step or emulated frame.

    The log of an `AtariVectorEnv` has the values of all its lanes, or of one; `Watch(envs, ...)` makes a `VectorWatch`.

    Args:
        env: an `AtariEnv` or an `AtariVectorEnv`, in any wrappers. With each="step", a step is one of this wrapper.
        what: names of labels, and places (0..127, or 0x80..0xFF) of bytes.
        each: "step", or "frame" for all emulated frames, also inside a frame skip and in resets of wrappers. A vector
            is logged by steps.
        index: the lane of a vector to log; None logs all lanes.
        on_change: called with name or place, the value before, and the value now, after each change but the first;
            None is the value of a label that is not visible. It must not change the environment. Its errors end the
            step after it was played.

    Raises:
        TypeError: `env` is neither, a name is of the wrong kind, or `index` is given for an `AtariEnv`.
        ValueError, KeyError: there is no such label or place, none is given, or `each` is something else.
        IndexError: there is no such lane.

    Example:
        >>> import atari
        >>> from atari.lab import Watch
        >>> env = Watch(atari.make("breakout"), "lives", 0xE3)
        >>> observation, info = env.reset(seed=0)
        >>> observation = env.step(1)[0]
        >>> env.history["lives"].tolist()
        [5, 5]
        >>> envs = Watch(atari.AtariVectorEnv("breakout", 2), "lives")
        >>> observations, info = envs.reset(seed=0)
        >>> envs.history["lives"].tolist()
        [[5, 5]]
        >>> envs.close()
    """

    if TYPE_CHECKING:  # at run time `typing` would hold the functions, and all modules, until the process has ended

        @overload
        def __new__(
            cls,
            env: gymnasium.Env[Any, Any],
            *what: str | int,
            each: Each = "step",
            index: int | None = None,
            on_change: OnChange | None = None,
        ) -> "Watch": ...
        @overload
        def __new__(  # type: ignore[misc]
            cls,
            env: VectorEnv,
            *what: str | int,
            each: Each = "step",
            index: int | None = None,
            on_change: OnChange | None = None,
        ) -> VectorWatch: ...

    def __new__(cls, env: Any = None, *args: Any, **kwargs: Any) -> Any:
        """A `VectorWatch` for a vector; copying and pickling call this without arguments."""
        kind: type = VectorWatch if is_vector(env) else Watch
        check_arguments("Watch", kind, kwargs)
        return VectorWatch(env, *args, **kwargs) if kind is VectorWatch else super().__new__(cls)


class _FrameLogger:
    """Observes the emulated frames."""

    def __init__(self, append: Callable[[], None]) -> None:
        self._append = append

    def game_begun(self) -> None:
        self._append()

    def frame_played(self, action: int, reward: int) -> None:
        self._append()


class _Log:
    """Rows of values. An error of `on_change` waits for `raise_error`, because observers of frames must not raise."""

    def __init__(self, ram: Ram, what: Sequence[str | int], on_change: OnChange | None) -> None:
        if not what:
            raise ValueError("name at least one label or byte to watch")
        for name in what:
            ram[name]  # raises if there is no such label or place
        self._ram, self._what, self._on_change = ram, tuple(what), on_change
        self._error: Exception | None = None
        self.stopped = False
        self.clear()

    def clear(self) -> None:
        self._frames: list[Any] = []
        self._rows: dict[str | int, list[Any]] = {name: [] for name in self._what}

    def append(self, frame: Any) -> None:
        if self.stopped:
            return
        self._frames.append(frame)
        for name, rows in self._rows.items():
            value = self._ram[name]
            rows.append(value)
            if self._on_change is not None and len(rows) > 1 and not _same(rows[-2], value):
                try:
                    self._on_change(name, rows[-2], value)
                except Exception as error:
                    self._error = self._error or error

    def raise_error(self) -> None:
        error, self._error = self._error, None
        if error is not None:
            raise error

    def history(self) -> dict[str | int, Array]:
        columns: dict[str | int, Array] = {name: _column(rows) for name, rows in self._rows.items()}
        return {"frame": np.array(self._frames, np.int64), **columns}


def _same(before: Any, now: Any) -> bool:
    if not np.ndim(now):
        return bool(before == now)
    return bool(np.ma.asarray(before).tolist() == np.ma.asarray(now).tolist())  # a list has None where it is masked


def _column(rows: list[Any]) -> Array:
    if rows and np.ndim(rows[0]):
        return np.ma.stack([np.ma.asarray(row) for row in rows]).astype(np.int32)
    hidden = [row is None for row in rows]
    values = np.array([0 if row is None else row for row in rows], np.int32)
    return np.ma.array(values, mask=hidden) if any(hidden) else values
