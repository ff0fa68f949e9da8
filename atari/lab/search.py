"""`Search`: finds the bytes of RAM that behave as a value does, filter by filter, while a game is played."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import islice
from os import PathLike
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.base.text_table import Table
from atari.base.validation import check_integer
from atari.cores import ByteArray
from atari.games.catalog import games
from atari.lab.labels import byte_index
from atari.lab.places import RAM_BYTES, IntArray, Place, Places
from atari.lab.ram import access
from atari.recording import Replay

_COLUMNS = 12
_ROWS = 40
_LONGEST = 10**12
_MOST_VALUES = 1 << 22


@dataclass(frozen=True)
class Filter:
    """An applied filter: its call as text, and the number of places that it left."""

    call: str
    left: int


@dataclass(frozen=True)
class _Step:
    """The state of a search before a filter, for `undo`."""

    places: Places
    ram: ByteArray
    kept: int
    filters: int


class Search:
    """The places of RAM that every filter so far has left.

    Each filter reads the RAM and compares it with the RAM at the filter before; the first filter compares with the RAM
    at the start of the search. It keeps the places that fit, and returns the search, so that filters can be chained. A
    place has to fit in all lanes of a vector. Before the first `bcd`, a place is a byte; afterwards it is a decimal
    number of one or more bytes, and all filters compare these numbers.

    Args:
        source: the game to search:

            - an `AtariEnv`, an `AtariVectorEnv` (in any wrappers) or a core, which is played between the filters;
            - a recorded history: a `Replay` or its path (.a26r), with a state after each emulated frame, or an array
              (T, 128) or (T, N, 128), uint8. The search begins at its first state; `seek` goes to another.
        index: the lane of a vector, or the one of N games, to search; None searches all.

    Raises:
        TypeError, ValueError, FileNotFoundError: `source` is none of these.
        IndexError: there is no such index.

    Example:
        >>> import atari
        >>> from atari.lab import Search
        >>> env = atari.make("breakout")
        >>> observation, info = env.reset(seed=0)
        >>> search = Search(env).equals(5)
        >>> for _ in range(30):
        ...     observation = env.step(0)[0]
        >>> print(search.unchanged().table())
        place  index  label        now
        0xB9   57     lives  5  5  5
        0xD8   88            5  5  5
        2 candidates
    """

    def __init__(self, source: Any, *, index: int | None = None) -> None:
        self._states = recorded(source)
        self._state = 0
        self._labels: dict[int, str] = {}
        if self._states is None:
            ram = access(source, index)
            self._read = ram.read
            if len(set(ram.games)) == 1:
                self._labels = {label.index: name for name, label in ram.games[0].ram_labels.items()}
        else:
            if not len(self._states):
                raise ValueError("a recorded history needs at least one state")
            if index is not None:
                count = self._states.shape[1]
                if not isinstance(index, (int, np.integer)) or not 0 <= index < count:
                    raise IndexError(f"there is no game {index!r} in this history; it has 0..{count - 1}")
                self._states = self._states[:, [index]]
            self._read = self._read_recorded
        self._places = Places.all_bytes()
        self._ram = self._read().copy()
        self._kept = [self._ram]
        self._steps: list[_Step] = []
        self.filters: list[Filter] = []
        """The filters, in order."""

    @property
    def candidates(self) -> list[int]:
        """The indices 0..127 of the remaining bytes, or of all bytes of the remaining numbers, ascending."""
        return self._places.indices()

    @property
    def places(self) -> list[Place]:
        """The remaining places."""
        return list(self._places.columns())

    @property
    def emptied_by(self) -> str | None:
        """The filter that left nothing, or None if something is left."""
        before = len(Places.all_bytes())
        for number, each in enumerate(self.filters, 1):
            if not each.left:
                return f"{each.call}, filter {number} of {len(self.filters)}, left none of {before}"
            before = each.left
        return None

    @property
    def history(self) -> ByteArray:
        """The RAM at the start, at each filter and at each `keep`, or all recorded states: (T, 128) or (T, N, 128)."""
        states = np.stack(self._kept) if self._states is None else self._states
        return states[:, 0] if states.shape[1] == 1 else states

    def changed(self) -> "Search":
        """Keep the places whose value is not the same as before."""
        return self._compare("changed()", np.not_equal)

    def unchanged(self) -> "Search":
        """Keep the places whose value is the same as before."""
        return self._compare("unchanged()", np.equal)

    def increased(self) -> "Search":
        """Keep the places whose value is more than before."""
        return self._compare("increased()", np.greater)

    def decreased(self) -> "Search":
        """Keep the places whose value is less than before."""
        return self._compare("decreased()", np.less)

    def equals(self, n: Any) -> "Search":
        """Keep the places whose value is `n` now: an integer, or (N,) integers for N games."""
        numbers = self._numbers("n", n)
        return self._filter(f"equals({n})", lambda places, ram: places.values(ram) == numbers)

    def between(self, a: Any, b: Any) -> "Search":
        """Keep the places whose value is at least `a` and at most `b` now.

        Raises:
            ValueError: `a` is more than `b`.
        """
        low, high = self._numbers("a", a), self._numbers("b", b)
        if (low > high).any():
            raise ValueError(f"between(a, b) needs a <= b, got {a} and {b}")
        return self._filter(
            f"between({a}, {b})", lambda places, ram: (places.values(ram) >= low) & (places.values(ram) <= high)
        )

    def bcd(self, n: Any, bytes: Sequence[int] | None = None) -> "Search":
        """Keep the numbers in binary-coded decimal, two digits a byte, that are `n` now.

        A number has as many bytes as the largest `n` so far needs. They are adjacent, or with one byte between them,
        with the highest digits first or last. Zeros at the end of `n`, up to three, need not be in RAM.

        Args:
            n: an integer of 0 or more, or (N,) integers for N games.
            bytes: the places of the number, lowest digits first, instead of all of RAM.

        Raises:
            TypeError, ValueError: `n` is no such number, or there are no such places.
        """
        numbers = self._numbers("n", n)
        if (numbers < 0).any():
            raise ValueError(f"a decimal number in RAM is 0 or more, got {n}")
        indices = None if bytes is None else [byte_index(byte) for byte in bytes]
        if indices == []:
            raise ValueError("bytes= needs at least one place")
        places = self._places
        if indices is not None or not places.decimal:
            places = Places.numbers(indices).with_byte_of(self.candidates)
        places = places.long_enough(int(numbers.max()))
        call = f"bcd({n})" if bytes is None else f"bcd({n}, bytes={list(bytes)})"
        return self._filter(call, lambda places, ram: places.values(ram) == numbers, places)

    def correlates(self, series: Any, at_least: float = 0.9) -> "Search":
        """Keep the places that have followed `series`, up or down: |Pearson's correlation| >= `at_least`.

        Args:
            series: a number for each state of `history`, (T,) or (T, N).
            at_least: 0..1.

        Raises:
            TypeError, ValueError: `series` has another shape, or is constant; `at_least` is out of range.
        """
        states = np.stack(self._kept) if self._states is None else self._states
        wanted = _check_series(series, states.shape[:2])
        if not 0 <= float(at_least) <= 1:
            raise ValueError(f"at_least is a correlation 0..1, got {at_least}")
        return self._filter(
            f"correlates(series, at_least={at_least})",
            lambda places, ram: np.abs(_correlations(places, states, wanted))[None] >= at_least,
        )

    def keep(self) -> "Search":
        """Append the RAM to `history`, without a filter."""
        if self._states is not None:
            raise ValueError("a recorded history has all its states already; keep() is for a game that is played")
        self._kept.append(self._read().copy())
        return self

    def seek(self, state: int) -> "Search":
        """Let filters read this state of a recorded history, 0..T-1; state i of a replay is after frame i + 1.

        Raises:
            TypeError, ValueError: there is no such state, or the search is of a game that is played.
        """
        if self._states is None:
            raise ValueError("seek() goes to a state of a recorded history; this search reads a game that is played")
        self._state = check_integer("state", state, 0, len(self._states) - 1)
        return self

    def undo(self) -> "Search":
        """Take the last filter back. The next filter compares with the same RAM as that one.

        Raises:
            ValueError: there is no filter to take back.
        """
        if not self._steps:
            raise ValueError("there is no filter to undo")
        step = self._steps.pop()
        self._places, self._ram = step.places, step.ram
        del self._kept[step.kept :]
        del self.filters[step.filters :]
        return self

    def table(self) -> Table:
        """The remaining places with their last values in `history`; it shows in notebooks."""
        if not len(self._places):
            return Table(("place",), (), f"no candidates: {self.emptied_by}")
        states = np.stack(self._kept) if self._states is None else self._states[: self._state + 1]
        values = self._places.values(states[-_COLUMNS:])
        columns = self._places.columns()
        rows = tuple(
            (
                str(each),
                " ".join(map(str, each.bytes)),
                ", ".join(self._labels[byte] for byte in reversed(each.bytes) if byte in self._labels),
                *map(_joined, values[:, :, column]),
            )
            for each, column in islice(columns.items(), _ROWS)
        )
        left = len(columns)
        note = f"{left} candidates" + (f"; {_ROWS} are shown" if left > _ROWS else "")
        return Table(("place", "index", "label", *[""] * (len(values) - 1), "now"), rows, note)

    def __repr__(self) -> str:
        if self.emptied_by:
            return f"<Search: no candidates; {self.emptied_by}>"
        return f"<Search: {len(self.places)} candidates after {len(self.filters)} filters>"

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()

    def _read_recorded(self) -> ByteArray:
        assert self._states is not None
        return self._states[self._state]

    def _numbers(self, name: str, value: Any) -> IntArray:
        """The numbers (N, 1), or (1, 1), of an argument."""
        numbers = np.asarray(value)
        if numbers.dtype.kind not in "iu" and not (numbers.dtype.kind == "f" and (np.trunc(numbers) == numbers).all()):
            raise TypeError(f"{name} must be an integer, got {value!r}")
        if numbers.shape not in ((), (len(self._ram),)):
            raise ValueError(f"{name} must be an integer or have the shape ({len(self._ram)},), got {numbers.shape}")
        if (numbers > _LONGEST).any() or (numbers < -_LONGEST).any():
            raise ValueError(f"{name} must be at most {_LONGEST:,}, got {value}")
        return numbers.astype(np.int64).reshape(-1, 1)

    def _compare(self, call: str, relation: Callable[[Any, Any], Any]) -> "Search":
        before = self._ram
        return self._filter(call, lambda places, ram: relation(places.values(ram), places.values(before)))

    def _filter(
        self, call: str, fits: Callable[[Places, ByteArray], npt.NDArray[np.bool_]], places: Places | None = None
    ) -> "Search":
        """Keep the places that fit in all games."""
        ram = self._read().copy()
        places = self._places if places is None else places
        left = places.pick(np.asarray(fits(places, ram).all(axis=0)))
        self._steps.append(_Step(self._places, self._ram, len(self._kept), len(self.filters)))
        self._places, self._ram = left, ram
        self._kept.append(ram)
        self.filters.append(Filter(call, len(left)))
        return self


def _check_series(series: Any, shape: tuple[int, ...]) -> npt.NDArray[np.float64]:
    array = np.asarray(series)
    if array.dtype.kind not in "biuf":
        raise TypeError(f"a series has numbers, got {array.dtype}")
    if array.shape not in (shape, shape[:1]):
        more = f" or {shape}" if shape[1] > 1 else ""
        raise ValueError(f"a series has a number for each state of the history, ({shape[0]},){more}, got {array.shape}")
    numbers = np.broadcast_to(array.reshape(shape[0], -1), shape).astype(np.float64)
    if not np.isfinite(numbers).all():
        raise ValueError("a series has finite numbers")
    if (numbers == numbers[:1, :1]).all():
        raise ValueError("the series never changes, so nothing can follow it")
    return numbers


def _correlations(places: Places, states: ByteArray, series: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Pearson's correlation of each place's values in states (T, N, 128) with the series (T, N); 0 if none changes."""
    y = series.ravel() - series.mean()
    found = np.zeros(len(places))
    part = max(1, _MOST_VALUES // series.size)
    for start in range(0, len(places), part):
        rows = np.arange(start, min(start + part, len(places)))
        values = places.pick(rows).values(states).reshape(series.size, -1).astype(np.float64)
        x = values - values.mean(0)
        size = np.sqrt((x**2).sum(0) * (y**2).sum())
        found[rows] = np.divide(y @ x, size, out=np.zeros_like(size), where=size > 0)
    return found


def _joined(values: npt.NDArray[Any]) -> str:
    return " ".join("-" if value < 0 else str(value) for value in values.tolist())


def recorded(source: Any) -> ByteArray | None:
    """The states of a recording: one after each emulated frame of a replay, or the rows of an array; else None.

    Args:
        source: a `Replay`, the path of one (.a26r), or an array (T, 128) or (T, N, 128), uint8.

    Raises:
        TypeError, ValueError: the array has another shape, or its values are no bytes; or as `Replay.load`.
        FileNotFoundError: there is no such file.
    """
    if isinstance(source, (str, PathLike)):
        if isinstance(source, str) and source in games:
            raise TypeError(
                f"RAM is read from a game that is played, so take an environment, such as atari.make({source!r}), or a "
                "recorded game: the path of a replay (.a26r)"
            )
        source = Replay.load(source)
    if isinstance(source, Replay):
        return _replayed(source)
    if isinstance(source, (np.ndarray, list, tuple)):
        return _checked(np.asarray(source))
    return None


def _replayed(replay: Replay) -> ByteArray:
    rows = np.empty((replay.frames_total, 1, RAM_BYTES), np.uint8)
    count = 0
    core = replay.make_env().core
    try:
        for _, calls in replay.walk(core):  # `Replay.frames` also renders each frame
            for call in calls:
                if call.played and count < len(rows):
                    core.ram(rows[count, 0])
                    count += 1
    finally:
        core.close()
    return rows[:count]


def _checked(array: npt.NDArray[Any]) -> ByteArray:
    if array.ndim not in (2, 3) or array.shape[-1] != RAM_BYTES:
        raise ValueError(f"a history of RAM is an array (T, 128) or (T, N, 128), got {array.shape}")
    if array.dtype != np.uint8:
        if array.dtype.kind not in "iu" or (array.size and not 0 <= array.min() <= array.max() <= 0xFF):
            raise TypeError(f"a history of RAM holds bytes, integers 0..255, got {array.dtype}")
        array = array.astype(np.uint8)
    return array[:, None] if array.ndim == 2 else array
