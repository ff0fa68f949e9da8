"""`ContractError`, and the comparisons that all checks share."""

import copy
import pickle
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np
from gymnasium import spaces


class ContractError(AssertionError):
    """A contract is broken. The message has the call, the result that was expected, and the result that was seen.

    Example:
        >>> from atari.testing import ContractError, check_env
        >>> try:
        ...     check_env(lambda: None)
        ... except ContractError as error:
        ...     print(error)
        make() must return a gymnasium.Env, got None
    """


def require(kept: Any, sentence: str) -> None:
    """Raise `ContractError` with `sentence` unless `kept` is true."""
    if not kept:
        raise ContractError(sentence)


def require_same(expected: Any, seen: Any, name: str, sentence: str) -> None:
    """Raise `ContractError` with `sentence` and the first difference, unless two results are equal."""
    found = difference(expected, seen, name)
    require(found is None, f"{sentence}; {found}")


@contextmanager
def refuses(call: str, *errors: type[Exception]) -> Iterator[None]:
    """Check that the block raises one of `errors`; without `errors`, an error of any kind."""
    allowed = errors or (Exception,)
    names = " or ".join(error.__name__ for error in errors) or "an error"
    try:
        yield
    except allowed:
        return
    except Exception as error:
        raise ContractError(f"{call} must raise {names}, but raised {type(error).__name__}: {error}") from error
    raise ContractError(f"{call} must raise {names}, but raised nothing")


@contextmanager
def broken_by(call: str) -> Iterator[None]:
    """Turn an error that the block raises into a `ContractError` that names the call."""
    try:
        yield
    except ContractError:
        raise
    except Exception as error:
        raise ContractError(f"{call} raised {type(error).__name__}: {error}") from error


def check_maker(owner: str, make: Any, kind: str) -> None:
    """Raise an error if the argument `make` cannot be called.

    Raises:
        TypeError: `make` cannot be called.
    """
    if not callable(make):
        raise TypeError(f"{owner} takes a function that makes {kind}, got {make!r}; write lambda: {kind}")


def difference(expected: Any, seen: Any, name: str) -> str | None:
    """The first difference between two results, such as "reward is 1.0 instead of 0.0"; None if they are equal.

    Arrays are equal if they agree in dtype, shape and each element (NaN equals NaN). The seconds of an episode,
    `info["episode"]["t"]`, are not compared.
    """
    if isinstance(expected, Mapping) and isinstance(seen, Mapping):
        if expected.keys() != seen.keys():
            return f"{name} has the keys {sorted(map(str, seen))} instead of {sorted(map(str, expected))}"
        of_time = name.endswith("['episode']")
        keys = [key for key in expected if not (of_time and key == "t")]
        return _first(difference(expected[key], seen[key], f"{name}[{key!r}]") for key in keys)
    if isinstance(expected, (list, tuple)) and isinstance(seen, (list, tuple)):
        if len(expected) != len(seen):
            return f"{name} has {len(seen)} parts instead of {len(expected)}"
        pairs = enumerate(zip(expected, seen, strict=True))
        return _first(difference(one, other, f"{name}[{index}]") for index, (one, other) in pairs)
    return _difference_of_arrays(np.asarray(expected), np.asarray(seen), name)


def _difference_of_arrays(expected: np.ndarray[Any, Any], seen: np.ndarray[Any, Any], name: str) -> str | None:
    if (expected.dtype.kind, expected.shape) != (seen.dtype.kind, seen.shape) or expected.dtype != seen.dtype != object:
        if {expected.dtype.kind, seen.dtype.kind} <= {"U", "S"}:  # texts may differ in length
            return f"{name} is {seen!r:.80} instead of {expected!r:.80}"
        return f"{name} is {seen.dtype} {seen.shape} instead of {expected.dtype} {expected.shape}"
    if expected.dtype == object:
        if expected.shape:
            return difference(expected.tolist(), seen.tolist(), name)
        one, other = expected.item(), seen.item()
        return None if one is other or one == other else f"{name} is {other!r:.80} instead of {one!r:.80}"
    wrong = (expected != seen) & ~((expected != expected) & (seen != seen))
    if not wrong.any():
        return None
    place = tuple(int(index) for index in np.argwhere(wrong)[0])
    at = f" at {place}" if place else ""
    return f"{name} is {seen[place]}{at} instead of {expected[place]}"


def _first(found: Iterator[str | None]) -> str | None:
    return next((text for text in found if text is not None), None)


def require_in(space: spaces.Space[Any], value: Any, call: str) -> None:
    """Check the type, shape, dtype and bounds of an observation; `space.contains` alone accepts dtypes that fit.

    Raises:
        ContractError: the observation, or a part of it, is not in the space.
    """
    if isinstance(space, spaces.Dict):
        seen = list(value) if isinstance(value, Mapping) else f"{value!r:.60}"
        keys = isinstance(value, Mapping) and value.keys() == space.spaces.keys()
        require(keys, f"{call} must return an observation with the keys {list(space.spaces)}, got {seen}")
        for key, part in space.spaces.items():
            require_in(part, value[key], f"{call}[{key!r}]")
    elif isinstance(space, spaces.Tuple):
        fits = isinstance(value, tuple) and len(value) == len(space.spaces)
        require(fits, f"{call} must return a tuple of {len(space.spaces)} observations, got {value!r:.60}")
        for index, part in enumerate(space.spaces):
            require_in(part, value[index], f"{call}[{index}]")
    else:
        if isinstance(space, spaces.Box):
            seen = f"{value.dtype} {value.shape}" if isinstance(value, np.ndarray) else f"{value!r:.60}"
            fits = isinstance(value, np.ndarray) and (value.dtype, value.shape) == (space.dtype, space.shape)
            require(fits, f"{call} must return an observation {space.dtype} {space.shape}, got {seen}")
        require(value in space, f"{call} returned an observation that is not in {space}: {value!r:.80}")


def check_copies(original: Any, play: Callable[[Any], Any], calls: tuple[str, str], what: str) -> None:
    """Check that a deep copy and a pickle of an environment continue where it is.

    Args:
        original: the environment.
        play: plays an environment, and returns its results.
        calls, what: the names of copy and pickle, and of the environment, in messages.

    Raises:
        ContractError: it cannot be copied, or a copy plays on otherwise.
    """
    copies = []
    for call, through_pickle in zip(calls, (False, True), strict=True):
        with broken_by(f"{call} (copies=False leaves this check out)"):
            copies.append(pickle.loads(pickle.dumps(original)) if through_pickle else copy.deepcopy(original))
    expected = play(original)
    for call, other in zip(calls, copies, strict=True):
        require_same(expected, play(other), "results", f"{call} must continue where {what} is")
        other.close()
