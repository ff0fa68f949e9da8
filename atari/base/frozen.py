"""The mapping of the package's constants and of frozen dataclasses."""

import difflib
from collections.abc import Iterable, Iterator, Mapping
from typing import TypeVar

K = TypeVar("K")
V = TypeVar("V")


class FrozenDict(Mapping[K, V]):
    """A mapping that cannot be changed and, unlike `types.MappingProxyType`, can be hashed, copied and pickled."""

    def __init__(self, items: Mapping[K, V] | Iterable[tuple[K, V]] = ()) -> None:
        self._items = dict(items)

    def __getitem__(self, key: K) -> V:
        try:
            return self._items[key]
        except KeyError:
            near = difflib.get_close_matches(str(key), map(str, self._items), n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"there are {', '.join(map(str, self._items)) or 'none'}"
        raise KeyError(f"there is no {key!r}; {hint}")

    def __iter__(self) -> Iterator[K]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __hash__(self) -> int:
        return hash(frozenset(self._items.items()))

    def __or__(self, other: Mapping[K, V]) -> dict[K, V]:
        return {**self, **other}

    def __ror__(self, other: Mapping[K, V]) -> dict[K, V]:
        return {**other, **self}

    def copy(self) -> dict[K, V]:
        """A dict with these items."""
        return dict(self._items)

    def __repr__(self) -> str:
        return repr(self._items)
