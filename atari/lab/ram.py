"""`Ram`: the bytes of RAM by the names that a game's labels give them."""

import html
import reprlib
from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np

from atari.base.text_table import Table
from atari.base.validation import check_integer
from atari.cores import ByteArray, Core
from atari.env import AtariEnv
from atari.games.game import Game, RamLabel
from atari.games.objects import positions, visible_objects
from atari.lab.labels import BoolArray, IntArray, byte_index, evaluate_label, labels_of, unknown_label
from atari.vector import AtariVectorEnv

_MOST_COLUMNS = 8


class Ram:
    """The RAM of a game by the names of its labels (`atari.games[game].ram_labels`), and by place.

    `ram["ball_x"]` is the value of a label: its transform, in integers. It is None while the label's `visible` is
    false. A place is an integer: an index 0..127, or an address 0x80..0xFF; `ram[49]` and `ram[0xB1]` are the same
    byte. Assigning to a label writes the byte that has the value, and assigning to a place writes the byte itself. The
    next frame shows it, or the one after it, unless the game writes the byte again.

    The values of a whole vector are `numpy.ma.MaskedArray` int32 (num_envs,), masked where they are not visible or
    where the game has no such label; bytes are uint8 (num_envs,). One value is written to all lanes, or an array
    (num_envs,) has one for each; masked entries are not written.

    `Ram` holds no copy. It goes on working over resets, restores and replaced cores.

    Args:
        target: an `AtariEnv` or a wrapper around one, a core, or an `AtariVectorEnv`.
        index: a lane of a vector, which is then used like a single environment.

    Raises:
        TypeError: `target` is something else; or `index` is given for something that is no vector.
        IndexError: the vector has no lane of this number.

    All methods that read or write raise gymnasium.error.ClosedEnvironmentError after `close` of an environment or
    vector, and RuntimeError after `close` of a core, or between `send` and `recv` of a vector.

    Example:
        >>> import atari
        >>> from atari.lab import Ram
        >>> env = atari.make("breakout")
        >>> observation, info = env.reset(seed=0)
        >>> ram = Ram(env)
        >>> ram["lives"]
        5
        >>> ram["player_x"] = 80
        >>> ram["player_x"]
        80
    """

    def __init__(self, target: Any, *, index: int | None = None) -> None:
        self._access = access(target, index)
        self._games = self._access.games
        distinct = dict.fromkeys(self._games)
        self._lanes: dict[Game, slice | list[int]] = dict.fromkeys(distinct, slice(None))
        if len(distinct) > 1:
            self._lanes = {game: [n for n, own in enumerate(self._games) if own == game] for game in distinct}
        self._labels: dict[str, RamLabel] = {}
        for game in self._lanes:
            self._labels = {**game.ram_labels, **self._labels}

    def __getitem__(self, place: str | int) -> Any:
        """The value of a label, or the byte of a place; see the class.

        Raises:
            KeyError: there is no such label; the message suggests the nearest.
            TypeError, ValueError: `place` is neither a text nor a place.
        """
        rams = self._access.read()
        if isinstance(place, str):
            return self._value_of(*evaluate_label(place, self._lanes, rams))
        column = rams[:, byte_index(place)]
        return int(column[0]) if self._access.single else column.copy()

    def __setitem__(self, place: str | int, value: Any) -> None:
        """Write the byte that has this value, or the byte of a place. Nothing is written if anything is wrong.

        Raises:
            KeyError: there is no such label, or a game of the vector has none.
            TypeError, ValueError: the value is no integer, or the label or a byte cannot have it; the message says the
                possible values. Or an array is not of shape (num_envs,).
        """
        if isinstance(place, str):
            self._known(place)
        else:
            place = byte_index(place)
        values = self._values(value)
        rams = self._access.read()
        lanes = [lane for lane, wanted in enumerate(values) if wanted is not np.ma.masked]
        writes = [(lane, *self._byte(place, lane, rams[lane], values[lane])) for lane in lanes]
        for write in writes:
            self._access.write(*write)

    def __contains__(self, place: object) -> bool:
        """Whether there is a label of this name, or a byte at this place."""
        if isinstance(place, str):
            return place in self._labels
        try:
            byte_index(place)
        except (TypeError, ValueError):
            return False
        return True

    def __iter__(self) -> Iterator[str]:
        return iter(self._labels)

    def __len__(self) -> int:
        """The number of labels."""
        return len(self._labels)

    def __repr__(self) -> str:
        games = ", ".join(game.id for game in self._lanes)
        lanes = "" if self._access.single else f", {len(self._games)} lanes"
        return f"Ram({games}, {len(self)} labels{lanes})"

    def _repr_html_(self) -> str | None:
        """The table, for a notebook; None where the RAM cannot be read, as after `close`."""
        try:
            return f"<p><strong>{html.escape(repr(self))}</strong></p>{self.table()._repr_html_()}"
        except (gymnasium.error.ClosedEnvironmentError, RuntimeError):
            return None

    def keys(self) -> list[str]:
        """The names of the labels."""
        return list(self._labels)

    def items(self) -> list[tuple[str, Any]]:
        """The names of the labels and their values, all of one reading of RAM."""
        rams = self._access.read()
        return [(name, self._value_of(*evaluate_label(name, self._lanes, rams))) for name in self._labels]

    def label(self, name: str) -> RamLabel:
        """The entry of a label in the game's file.

        Raises:
            KeyError: there is no such label.
        """
        return self._labels[self._known(name)]

    def byte(self, name: str) -> int:
        """The index 0..127 of a label's byte.

        Raises:
            KeyError: there is no such label.
            ValueError: games of the vector have the label at different places.
        """
        self._known(name)
        indices = sorted({game.ram_labels[name].index for game in self._lanes if name in game.ram_labels})
        if len(indices) > 1:
            raise ValueError(f"{name!r} is at different places in these games, {indices}; use Ram(envs, index=i)")
        return indices[0]

    def objects(self) -> Any:
        """The things on the screen, by their labels of positions.

        Returns:
            A list of `GameObject`; for a whole vector, a list of such lists. An object has a `name`, such as
            "asteroid_3"; a `kind`, the name without numbers; and in pixels `x`, `y`, `width` and `height`, None where
            not known.
        """
        rams = self._access.read()
        each = [
            visible_objects(positions(game.ram_labels), labels_of(game).values(ram))
            for game, ram in zip(self._games, rams, strict=True)
        ]
        return each[0] if self._access.single else each

    def table(self) -> Table:
        """All labels with their places, bytes and values. It prints, and shows in a notebook.

        The table of a vector has the values of the first eight lanes. Without labels, it has all 128 bytes.
        """
        rams = self._access.read()
        if not self._labels:
            rows = [(index, f"0x{0x80 + index:02X}", *_first(rams[:, index])) for index in range(128)]
            return Table.of(("index", "address", *self._titles("byte")), rows)
        titles = (*self._titles("byte"), *self._titles("value"))
        columns = ("name", "index", "address", *titles, "kind", "evidence", "note")
        return Table.of(columns, [self._row(name, rams) for name in self._labels])

    def _row(self, name: str, rams: ByteArray) -> tuple[Any, ...]:
        label = self._labels[name]
        values, visible = evaluate_label(name, self._lanes, rams)
        shown = [value if seen else None for value, seen in zip(_first(values), visible.tolist(), strict=False)]
        place = (name, label.index, f"0x{0x80 + label.index:02X}")
        return (*place, *_first(rams[:, label.index]), *shown, label.kind, label.evidence, label.note)

    def _titles(self, title: str) -> list[str]:
        lanes = range(min(len(self._games), _MOST_COLUMNS))
        return [title] if self._access.single else [f"{title} {lane}" for lane in lanes]

    def _known(self, name: str) -> str:
        if name not in self._labels:
            raise unknown_label(name, tuple(self._lanes))
        return name

    def _value_of(self, values: IntArray, visible: BoolArray) -> Any:
        if self._access.single:
            return int(values[0]) if visible[0] else None
        return np.ma.MaskedArray(values, ~visible)

    def _values(self, value: Any) -> list[Any]:
        """The value for each lane, `numpy.ma.masked` where none is to be written."""
        count = len(self._games)
        if self._access.single or np.ndim(value) == 0:
            return [value] * count
        array = value if isinstance(value, np.ma.MaskedArray) else np.asarray(value)
        if array.shape != (count,):
            raise ValueError(f"there must be a value for each of the {count} lanes, got the shape {array.shape}")
        if array.dtype.kind not in "iu":
            raise TypeError(f"values must be integers, got {array.dtype}")
        return list(array)

    def _byte(self, place: str | int, lane: int, ram: ByteArray, value: Any) -> tuple[int, int]:
        """The index and the byte to write for a checked place."""
        game = self._games[lane]
        if isinstance(place, int):
            return place, check_integer("a byte", value, 0, 255)
        if place not in game.ram_labels:
            raise unknown_label(place, (game,))
        return game.ram_labels[place].index, labels_of(game, place).byte_of(place, ram, value)


def _first(column: Any) -> list[int]:
    return column[:_MOST_COLUMNS].tolist()


def access(target: Any, index: int | None = None) -> "_Single | _Vector":
    """The access to an environment or a wrapper around one, to a core, or to a vector or its lane `index`.

    An access has the `games` of its lanes. `single` is true for a core, an environment and one lane. `read` returns a
    copy of RAM, (lanes, 128) uint8, and `write` changes one byte.

    Raises:
        TypeError: `target` is something else, or `index` is given for something that is no vector.
        IndexError: there is no such lane.
    """
    inner: Any = target.unwrapped if isinstance(target, (gymnasium.Env, gymnasium.vector.VectorEnv)) else target
    if isinstance(inner, AtariVectorEnv):
        lanes = list(range(inner.num_envs)) if index is None else [_check_index(inner, index)]
        return _Vector(inner, lanes, single=index is not None)
    if index is not None:
        raise TypeError(f"index is the number of a lane of an AtariVectorEnv, but this is {target!r}; leave it out")
    if isinstance(inner, AtariEnv) or (isinstance(getattr(inner, "game", None), Game) and hasattr(inner, "set_ram")):
        return _Single(inner)
    advice = "for a replay or its frames, take Ram(replay.seek(number of frames))"
    if isinstance(inner, gymnasium.vector.VectorEnv):
        advice = "take one environment of another vector"
    raise TypeError(
        "RAM is read from an AtariEnv (or a wrapper around one), a core, or an AtariVectorEnv, got "
        f"{reprlib.repr(target)}; {advice}"
    )


def _check_index(envs: AtariVectorEnv, index: Any) -> int:
    try:
        return check_integer("index", index, 0, envs.num_envs - 1)
    except ValueError as error:
        raise IndexError(f"{error}; the vector has {envs.num_envs} lanes") from None


class _Single:
    """An environment or a core. An environment may replace its core by another one, so the core is read at each use."""

    single = True

    def __init__(self, target: Any) -> None:
        self._target = target
        self.games: tuple[Game, ...] = (target.game,)

    def _core(self) -> Core:
        if isinstance(self._target, AtariEnv) and self._target.driver.closed:
            raise gymnasium.error.ClosedEnvironmentError("this environment is closed; call reset() to go on")
        return self._target.core if isinstance(self._target, AtariEnv) else self._target

    def read(self) -> ByteArray:
        return self._core().ram()[None]

    def write(self, _row: int, index: int, byte: int) -> None:
        self._core().set_ram(index, byte)


class _Vector:
    """These lanes of a vector."""

    def __init__(self, envs: AtariVectorEnv, lanes: list[int], single: bool) -> None:
        self._envs, self._lanes, self.single = envs, np.array(lanes), single
        self.games = tuple(envs.games[lane] for lane in lanes)

    def read(self) -> ByteArray:
        return self._envs.ram(self._lanes)

    def write(self, row: int, index: int, byte: int) -> None:
        self._envs.lanes[self._lanes[row]].set_ram(index, byte)
