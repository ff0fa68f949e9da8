"""`Freeze` and `Poke`: hold bytes of RAM, or write them once, while an environment plays.

Both add writes to the native core, which applies them after every emulated frame, before the rules read RAM.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any, TypeAlias

import numpy as np

import atari._emulator as _emulator
from atari.base.validation import check_integer
from atari.cores.writes import first_free, make_write
from atari.env import AtariEnv
from atari.games.game import Game
from atari.games.interventions.writes import LATEST_FRAME, WriteRule
from atari.vector.env import AtariVectorEnv
from atari.vector.lanes import Lane


class _Single:
    """An environment or a core, with the methods of `Lane`. An environment may replace its core by another one, so
    the core is read at each use.
    """

    def __init__(self, env: Any) -> None:
        self._env = env
        self.game: Game = env.game

    @property
    def _core(self) -> Any:
        return self._env.core if isinstance(self._env, AtariEnv) else self._env

    @property
    def slots(self) -> Sequence[_emulator.Write | None]:
        return list(self._core.writes)

    def add_write(self, write: _emulator.Write, now: bool) -> int:
        slot = first_free(self.slots)
        self._core.add_write(write, now)
        return slot

    def remove_write(self, write: _emulator.Write) -> None:
        self._core.remove_write(write)


_Target: TypeAlias = _Single | Lane


class _Held:
    """Writes that were added to cores, until `release`.

    A copy that `copy.deepcopy` or `pickle` makes together with a copy of the environment releases the copy's writes.
    """

    def __init__(self, env: Any, values: Mapping[Any, Any], index: int | None, now: bool, **rule: Any) -> None:
        if not values:
            raise ValueError(f"{type(self).__name__} needs a label or a place in RAM, such as ball_x=80 or {{49: 80}}")
        self._env, self._index = getattr(env, "unwrapped", env), index
        self._targets = _targets(self._env, index)
        self._held: list[tuple[_Target, _emulator.Write, int]] = []
        made: list[tuple[_Target, _emulator.Write]] = []
        for place, value in values.items():
            if type(place) is not str:
                place = check_integer("a place in RAM", place, 0, 255)
            for target, one in zip(self._targets, _spread(value, len(self._targets), place), strict=True):
                where = f"{type(self).__name__}({place!r})"
                made.append((target, make_write(target.game, WriteRule(place, one, **rule), where)))
        try:
            for target, write in made:
                self._held.append((target, write, target.add_write(write, now)))
        except ValueError:
            self.release()
            raise

    def release(self) -> None:
        """End the writes; a second call does nothing. The bytes keep their values until the program changes them."""
        while self._held:
            target, write, _ = self._held.pop()
            with suppress(RuntimeError):  # the core is closed
                target.remove_write(write)

    def __getstate__(self) -> dict[str, Any]:
        """The lane and the slot of each write."""
        held = []
        for target, write, slot in self._held:
            with suppress(RuntimeError, IndexError):  # the core is closed, or its slots were set
                if (now := target.slots[slot]) is not None and now.definition == write.definition:
                    held.append((self._targets.index(target), slot))
        return {"env": self._env, "index": self._index, "held": held}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._env, self._index = state["env"], state["index"]
        self._targets = _targets(self._env, self._index)
        self._held = []
        for lane, slot in state["held"]:
            write = self._targets[lane].slots[slot]
            assert write is not None
            self._held.append((self._targets[lane], write, slot))


class Freeze(_Held):
    """Hold bytes of RAM at the given values after every emulated frame, also within a frame skip.

    Args:
        env: an `AtariEnv` or a wrapper around one, a native core, or an `AtariVectorEnv`.
        values: values by label or by place, an index 0..127 or an address 0x80..0xFF. The value of a label is the
            result of its `transform`; the value of a place is the byte. A value is an integer, or an expression of
            interventions, such as "old"; for a vector also an array of integers, (num_envs,).
        index: the lane of a vector to write to; None writes to all.
        paid: whether the rules reward the change, such as a new score.
        labels: values by label.

    The bytes are written at once, after a reset and after each frame, until `release`, the end of the `with` block, or
    `close` of the environment. Copies of the environment by `pickle` and `copy.deepcopy` hold them too. To release them
    in a copy, copy both in one call: `env, freeze = copy.deepcopy((env, freeze))`.

    Raises:
        TypeError: `env` is none of these.
        ValueError: there is no such label, place or lane, or it cannot have the value; or the core is ale-py's.

    Example:
        >>> import atari
        >>> from atari.lab import Freeze, Ram
        >>> env = atari.make("breakout")
        >>> observation, info = env.reset(seed=0)
        >>> with Freeze(env, lives=3):
        ...     info = env.step(1)[4]
        >>> info["lives"]
        3
    """

    def __init__(
        self,
        env: Any,
        values: Mapping[str | int, Any] | None = None,
        /,
        *,
        index: int | None = None,
        paid: bool = True,
        **labels: Any,
    ) -> None:
        super().__init__(env, _joined("Freeze", values, labels), index, True, when="held", paid=bool(paid))

    def __enter__(self) -> "Freeze":
        return self

    def __exit__(self, *error: object) -> None:
        self.release()


class Poke(_Held):
    """Write bytes of RAM once, after the first emulated frame that fits.

    Args:
        env, values, index, paid, labels: as in `Freeze`.
        frame: the number of that frame in its episode; the first after a reset has the number 1.
        when: a condition over labels, `ram[...]`, `old` and `frame`, which is read after each frame.

    Without `frame` and `when`, it is the next frame. The writes of a `Poke` are independent: each is done at its first
    fitting frame. A snapshot says which are done, so after `restore` of an earlier one they are done again.

    Raises:
        TypeError, ValueError: as `Freeze`; or the condition is wrong.

    Example:
        >>> import atari
        >>> from atari.lab import Poke, Ram
        >>> env = atari.AtariEnv("breakout", frameskip=1)
        >>> observation, info = env.reset(seed=0)
        >>> poke = Poke(env, {"lives": 2}, frame=3)
        >>> [env.step(0)[4]["lives"] for _ in range(4)]
        [5, 5, 2, 2]
    """

    def __init__(
        self,
        env: Any,
        values: Mapping[str | int, Any] | None = None,
        /,
        *,
        frame: int | None = None,
        when: str | None = None,
        index: int | None = None,
        paid: bool = True,
        **labels: Any,
    ) -> None:
        if when is not None and not isinstance(when, str):
            raise TypeError(f"when must be a condition such as 'ball_x > 100', got {when!r}")
        at: Any = "frame" if frame is None else (check_integer("frame", frame, 1, LATEST_FRAME),)
        joined = _joined("Poke", values, labels)
        super().__init__(env, joined, index, False, when=at, condition=when, once=True, paid=bool(paid))


def _joined(name: str, values: Any, labels: Mapping[str, Any]) -> dict[Any, Any]:
    if values is not None and not isinstance(values, Mapping):
        raise TypeError(
            f"{name} needs values by label or by place, such as ball_x=80 or {{49: 80}}, got {values!r:.80}"
        )
    return {**(values or {}), **labels}


def _targets(env: Any, index: int | None) -> list[_Target]:
    """The native core, or the lanes of a vector, to write to."""
    if isinstance(env, AtariVectorEnv):
        return list(env.lanes) if index is None else [env.lanes[check_integer("index", index, 0, env.num_envs - 1)]]
    if index is not None:
        raise ValueError("index is for an AtariVectorEnv; leave it out")
    if isinstance(env, Lane):
        return [env]
    core: Any = env.core if isinstance(env, AtariEnv) else env
    if getattr(core, "name", None) == "ale":
        raise ValueError("ale-py's core cannot write RAM within a frame; use core='native'")
    if not hasattr(core, "add_write"):
        kinds = "an AtariEnv, a core, an AtariVectorEnv or one of its lanes"
        raise TypeError(f"{kinds} is needed, got {type(env).__name__}")
    return [_Single(env)]


def _spread(value: Any, count: int, place: Any) -> list[int | str]:
    if isinstance(value, (np.ndarray, list, tuple)):
        array = np.asarray(value)
        if array.shape != (count,):
            raise ValueError(f"{place!r} needs a value for each of {count} lanes, got the shape {array.shape}")
        return [_number(one, place) for one in array.tolist()]
    return [value if isinstance(value, str) else _number(value, place)] * count


def _number(value: Any, place: Any) -> int:
    return check_integer(f"the value of {place!r}", value, -(2**31), 2**31 - 1)
