"""`RamLabels`: adds the values of a game's labels to `info` at each step of an environment or of a vector."""

import difflib
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Literal, get_args, overload

import gymnasium
import numpy as np

from atari._emulator import RamOf, VectorEngine
from atari.base.gymnasium_versions import VectorEnv, VectorWrapper
from atari.base.validation import check_arguments, check_name
from atari.env import AtariEnv
from atari.env.restorable import RestorableWrapper
from atari.games.game import Game
from atari.lab import atari_ari
from atari.lab.labels import Labels, unknown_label
from atari.vector.env import AtariVectorEnv, is_vector

Names = Literal["game", "atari_ari"]


class LabelValues(dict[str, int]):
    """The values of labels by name. Its items are the visible labels; `values[name]` of an invisible one is None.

    Gymnasium's `SyncVectorEnv` and `AsyncVectorEnv` make arrays with masks of such items.
    """

    def __init__(self, items: Iterable[tuple[str, int]] = (), hidden: Iterable[str] = ()) -> None:
        super().__init__(items)
        self.hidden = frozenset(hidden)

    def __missing__(self, name: str) -> None:
        if name not in self.hidden:
            near = difflib.get_close_matches(str(name), [*self, *self.hidden], n=1, cutoff=0.5)
            raise KeyError(f"no label {name!r}" + (f"; did you mean {near[0]!r}?" if near else ""))


class EnvRamLabels(RestorableWrapper):
    """Adds labels to the `info` of an `AtariEnv`: `RamLabels(env, ...)` makes it."""

    def __init__(
        self, env: gymnasium.Env[Any, Any], labels: Iterable[str] | None = None, names: Names = "game"
    ) -> None:
        if not isinstance(env.unwrapped, AtariEnv):
            raise TypeError(f"RamLabels reads the RAM of an AtariEnv or an AtariVectorEnv, got {env}")
        chosen = None if labels is None else _checked(labels)
        super().__init__(env, labels=chosen, names=names)
        self._atari = env.unwrapped
        (self._labels,) = _labels_by_game((env.unwrapped.game,), chosen, names).values()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset the environment."""
        observation, info = self.env.reset(seed=seed, options=options)
        return observation, {**info, "labels": self.labels()}

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Play a step."""
        *results, info = self.env.step(action)
        return (*results, {**info, "labels": self.labels()})

    def labels(self) -> LabelValues:
        """The values of the labels now."""
        values = self._labels.values(self._atari.core.ram())
        items = [(name, value) for name, value in values.items() if value is not None]
        return LabelValues(items, [name for name, value in values.items() if value is None])


class VectorRamLabels(VectorWrapper):
    """Adds `info["labels"]` to the results of an `AtariVectorEnv`: the values of RAM labels that the observations show.

    It is a dict with an int32 array (rows,) for each name, zero where the label is not visible, and its mask, bool
    (rows,), under `_name`, as all of `info`. In SAME_STEP, after the end of an episode, `info["final_info"]["labels"]`
    has the labels of the final observation. Where games differ, it has the labels of all, and masks say which lanes
    have them.

    `RamLabels(envs)` makes it, with the same arguments and errors. `recv`, `observe` and the other methods of the
    `AtariVectorEnv` are available.
    """

    def __init__(self, env: VectorEnv, labels: Iterable[str] | None = None, names: Names = "game") -> None:
        if not isinstance(env.unwrapped, AtariVectorEnv):
            raise TypeError(
                f"RamLabels reads the RAM of an AtariEnv or an AtariVectorEnv, got {env.unwrapped}; in another vector, "
                "wrap each environment"
            )
        super().__init__(env)
        self._atari = env.unwrapped
        games = self._atari.games
        self._by_game = _labels_by_game(games, None if labels is None else _checked(labels), names)
        self._names = list(dict.fromkeys(name for part in self._by_game.values() for name in part.names))
        self._masks = [f"_{name}" for name in self._names]
        self._only = next(iter(self._by_game.values())) if len(self._by_game) == 1 else None
        self._hiding = range(len(self._names)) if self._only is None else self._only.hiding
        numbers = {game: number for number, game in enumerate(self._by_game)}
        self._number = np.array([numbers[game] for game in games])

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset lanes."""
        observation, info = self.env.reset(seed=seed, options=options)
        return observation, self._labelled(info)

    def step(self, actions: Any, *args: Any, **kwargs: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Play a step, with the arguments of `AtariVectorEnv.step`."""
        observation, reward, terminated, truncated, info = self.env.step(actions, *args, **kwargs)
        return observation, reward, terminated, truncated, self._labelled(info)

    def recv(self) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Wait for the results of `send`."""
        observation, reward, terminated, truncated, info = self.env.recv()  # type: ignore[attr-defined]
        return observation, reward, terminated, truncated, self._labelled(info)

    def observe(self) -> tuple[Any, dict[str, Any]]:
        """The present observations of the lanes."""
        observation, info = self.env.observe()  # type: ignore[attr-defined]
        return observation, self._labelled(info)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "env":
            raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")
        return getattr(self.env, name)

    def _labelled(self, info: dict[str, Any]) -> dict[str, Any]:
        rows = info["env_id"]
        info["labels"], info["_labels"] = self._evaluate(rows, info["_env_id"], RamOf.RESULT), info["_env_id"]
        if "_final_info" in info:
            ended = info["_final_info"]
            final = self._evaluate(rows, ended, RamOf.FINAL)
            info["final_info"]["labels"], info["final_info"]["_labels"] = final, ended
        return info

    def _evaluate(self, rows: Any, mask: Any, of: RamOf) -> dict[str, Any]:
        """The arrays of these lanes, where `mask` is true, which is also the mask of labels that cannot hide."""
        with self._atari.engine() as engine:
            if self._only is not None:
                values, visible = self._only.evaluate_lanes(engine, rows, of)
            else:
                values, visible = self._evaluate_games(engine, rows, of)
        if of is RamOf.FINAL:
            visible &= mask
            values *= visible
        arrays: dict[str, Any] = dict.fromkeys(self._masks, mask)
        arrays.update(zip(self._names, values, strict=True))
        for number in self._hiding:
            arrays[self._masks[number]] = visible[number]
        return arrays

    def _evaluate_games(self, engine: VectorEngine, rows: Any, of: RamOf) -> tuple[Any, Any]:
        values = np.zeros((len(self._names), len(rows)), np.int32)
        visible = np.zeros(values.shape, np.bool_)
        numbers = self._number[rows]
        for number, labels in enumerate(self._by_game.values()):
            columns = np.flatnonzero(numbers == number)
            if len(columns) and labels.names:
                where = np.ix_(np.array([self._names.index(name) for name in labels.names]), columns)
                values[where], visible[where] = labels.evaluate_lanes(engine, rows[columns], of)
        return values, visible


def _checked(labels: Iterable[str]) -> tuple[str, ...]:
    names = () if isinstance(labels, str) else tuple(labels)
    if not names or not all(isinstance(name, str) for name in names):
        raise TypeError(f"labels must be a list of names, or None for all, got {labels!r}")
    return tuple(dict.fromkeys(names))


def _labels_by_game(games: Iterable[Game], chosen: tuple[str, ...] | None, names: Names) -> dict[Game, Labels]:
    """The labels by game; each game has the chosen labels that it knows."""
    check_name("names", names, get_args(Names))
    named = {game: atari_ari.with_names(game) if names == "atari_ari" else game for game in games}
    known = set().union(*(game.ram_labels for game in named.values()))
    if not known:
        raise ValueError(
            f"there are no labels of {' and '.join(game.id for game in named)}; atari.games has the labels of others"
        )
    for name in chosen or ():
        if name not in known:
            raise unknown_label(name, tuple(named.values()))
    return {
        game: Labels(
            other, other.ram_labels if chosen is None else [name for name in chosen if name in other.ram_labels]
        )
        for game, other in named.items()
    }


class RamLabels(EnvRamLabels):
    """Adds `info["labels"]`, the values of RAM labels at the time of the observation.

    For a single environment it is a dict of integers by name; the value of a label that is not visible is None (see
    `LabelValues`). `RamLabels(envs)` of an `AtariVectorEnv` is a `VectorRamLabels`.

    Args:
        env: an `AtariEnv`, or a wrapper around one, or around an `AtariVectorEnv`.
        labels: the names of the labels; None is all.
        names: "game" selects the names and values of `atari.games[game].ram_labels`, "atari_ari" the names of
            AtariARI's `AtariARIWrapper`, whose values are unchanged bytes, always visible.

    Raises:
        TypeError: `env` is another environment.
        KeyError: the game has no label of a name; the message suggests the nearest.
        ValueError: the game has no labels, or AtariARI does not have the game.

    Example:
        >>> import atari
        >>> from atari.lab import RamLabels
        >>> env = RamLabels(atari.make("breakout"), ["lives", "player_x"])
        >>> env.reset(seed=0)[1]["labels"]
        {'lives': 5, 'player_x': 99}
    """

    if TYPE_CHECKING:  # at run time `typing` would hold the functions, and all modules, until the process has ended

        @overload
        def __new__(
            cls, env: gymnasium.Env[Any, Any], labels: Iterable[str] | None = None, names: Names = "game"
        ) -> "RamLabels": ...
        @overload
        def __new__(  # type: ignore[misc]
            cls, env: VectorEnv, labels: Iterable[str] | None = None, names: Names = "game"
        ) -> VectorRamLabels: ...

    def __new__(cls, env: Any = None, *args: Any, **kwargs: Any) -> Any:
        """A `VectorRamLabels` for a vector; copying and pickling call this without arguments."""
        kind: type = VectorRamLabels if is_vector(env) else RamLabels
        check_arguments("RamLabels", kind, kwargs)
        return VectorRamLabels(env, *args, **kwargs) if kind is VectorRamLabels else super().__new__(cls)
