"""`Restorable`: `snapshot` and `restore` of a wrapper and everything in it.

A snapshot of a stack of wrappers has the format of `atari.cores.snapshot`. The fact "layers" lists the wrappers that
have a state, from the outside in, with their arguments and the scalars of their state. Each array of a state is a blob,
compressed with zlib. The fact "task" is the task. The blob "env" is the snapshot of the `AtariEnv`. Wrappers
without a state may differ.
"""

import json
import zlib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import logger, wrappers
from gymnasium.utils import RecordConstructorArgs
from gymnasium.wrappers import OrderEnforcing, PassiveEnvChecker, TimeLimit

from atari.cores import snapshot
from atari.env.env import AtariEnv
from atari.env.lane_snapshot import LaneSnapshot, LaneState, new_episode, split
from atari.task.fields import GROUPS
from atari.task.json_form import identity, require_same

Environment = gymnasium.Env[Any, Any]

State = Mapping[str, Any]
"""The state of a wrapper by name: integers, booleans, texts, JSON objects and arrays."""

_STATELESS = (
    OrderEnforcing,
    PassiveEnvChecker,
    wrappers.TransformObservation,
    wrappers.TransformReward,
    getattr(wrappers, "TransformAction", wrappers.RescaleAction),  # Gymnasium 1.0 added the former
)

_STATELESS_FIELDS = ("obs_type", *(name for name in GROUPS["reward"] if name != "reward"))
"""Fields of a task that wrappers without a state play; the arguments of the others say whether images are gray."""


class Restorable:
    """The first base class of a wrapper: adds `snapshot` and `restore`."""

    _state: ClassVar[tuple[str, ...]] = ()
    """The attributes that `step` or `reset` change."""

    def snapshot(self) -> bytes:
        """This wrapper and everything in it as portable bytes: stacked frames, counters, generators, the game.

        A stack of the same wrappers and task, also in another process, continues from it exactly. Wrappers around
        this one are not included: call the method of the outermost.

        Raises:
            TypeError: the innermost environment is no `AtariEnv`, or a wrapper in between has a state that cannot be
                saved (Gymnasium's `TimeLimit` can be saved); the text names the wrapper.
        """
        env = _env(self)
        atari = _unwrapped(env)
        stateful = list(_stateful(env))
        return _pack(atari, atari.snapshot(), stateful, [_save_state(layer) for layer in stateful])

    def restore(self, data: bytes | LaneSnapshot) -> None:
        """Continue from a snapshot of such a stack.

        `data` may be an element of what `AtariVectorEnv.snapshot` returned, if `atari.make` has made this environment
        of the lane's task.

        Raises:
            TypeError: `data` is neither, or one of the reasons in `snapshot`.
            ValueError: `data` is no snapshot, is damaged, or belongs to other wrappers, another task or core; the
                message lists each field that differs. The environment has not changed.
        """
        env = _env(self)
        atari, stateful = _unwrapped(env), list(_stateful(env))
        facts, blobs = snapshot.unpack(_of_lane(data, atari, stateful) if isinstance(data, LaneSnapshot) else data)
        if facts.get("of") == "AtariEnv":
            raise ValueError(
                "the snapshot is of the AtariEnv without its wrappers; pass it to env.unwrapped.restore, or call "
                "snapshot of the outermost wrapper, too"
            )
        snapshot.require(facts, {"of": "wrappers"})
        require_same(facts.get("task"), atari.task, ignored=_STATELESS_FIELDS)
        saved = _checked_layers(facts.get("layers"), stateful)
        attributes = [
            _load_state(layer, _state(layer, number, scalars, blobs))
            for number, (layer, scalars) in enumerate(zip(stateful, saved, strict=True))
        ]
        snapshot.require_blobs(blobs, "env")
        atari.restore(blobs["env"])
        atari.driver.restored = False
        for layer, values in zip(stateful, attributes, strict=True):
            vars(layer).update(values)
        for layer in layers(env):
            _allow_step(layer)

    @property
    def snapshot_arguments(self) -> dict[str, Any]:
        """The arguments that a snapshot must have in common with this wrapper."""
        return self._saved_kwargs  # type: ignore[attr-defined]  # of RecordConstructorArgs

    def _save_state(self) -> State:
        """The state; before the first reset too, with arrays of the same shape and dtype."""
        return {name: getattr(self, name) for name in self._state}

    def _state_of_lane(self, lane: LaneState) -> State | None:
        """The state of this wrapper that continues a lane of a vector; None if it does not play a whole task."""
        return None

    def _load_state(self, state: State) -> dict[str, Any]:
        """The attributes of a saved state, with the names, types, shapes and dtypes of `_save_state`.

        Raises:
            ValueError: a value is out of range.
        """
        return dict(state)


class RestorableWrapper(Restorable, gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """A wrapper that the environment's spec makes again, from `arguments`."""

    def __init__(self, env: Environment, **arguments: Any) -> None:
        RecordConstructorArgs.__init__(self, **arguments)
        super().__init__(env)

    def _warn_if_restored(self) -> None:
        inner = self.unwrapped
        if isinstance(inner, AtariEnv) and inner.driver.restored:
            warn_of_restore(inner, type(self).__name__)


def layers(env: Environment) -> Iterator[Environment]:
    """The environment and everything that it wraps, from the outside in."""
    while isinstance(env, gymnasium.Wrapper):
        yield env
        env = env.env
    yield env


def warn_of_restore(env: AtariEnv, wrapper: str) -> None:
    """Warn that an `AtariEnv` was restored, but not the wrapper around it."""
    env.driver.restored = False
    logger.warn(
        f"the AtariEnv in {wrapper} was restored without its wrappers, whose frames, lives and counters may be of "
        "another state; use snapshot() and restore() of the outermost wrapper, or call reset()"
    )


def _env(wrapper: Any) -> Environment:
    assert isinstance(wrapper, gymnasium.Wrapper)
    return wrapper


def _unwrapped(env: Environment) -> AtariEnv:
    if not isinstance(env.unwrapped, AtariEnv):
        raise TypeError(f"snapshot() and restore() need an atari.AtariEnv in the wrappers, got {env.unwrapped}")
    return env.unwrapped


def _stateful(env: Environment) -> Iterator[Environment]:
    for layer in layers(env):
        if isinstance(layer, Restorable):
            if type(layer)._save_state is not Restorable._save_state or layer._state:
                yield layer
        elif type(layer) is TimeLimit:
            yield layer
        elif layer is not env.unwrapped and not (
            isinstance(layer, _STATELESS) and type(layer).__module__.startswith("gymnasium.")
        ):
            raise TypeError(
                f"the state of the wrapper {type(layer).__name__} cannot be saved; put it around the others and call "
                "snapshot() and restore() of the environment in it"
            )


def _pack(atari: AtariEnv, inner: bytes, stateful: Sequence[Environment], states: Sequence[State]) -> bytes:
    """The snapshot of a stack of wrappers with these states around an `AtariEnv` with the snapshot `inner`."""
    facts, blobs = [], {"env": inner}
    for number, (layer, state) in enumerate(zip(stateful, states, strict=True)):
        arrays = {name: part for name, part in state.items() if isinstance(part, np.ndarray)}
        blobs |= {f"{number}.{name}": zlib.compress(part.tobytes(), 1) for name, part in arrays.items()}
        facts.append(_identity(layer) | {"state": {name: state[name] for name in state if name not in arrays}})
    return snapshot.pack({"of": "wrappers", "layers": facts, "task": identity(atari.task)}, blobs)


def _of_lane(snapshot: LaneSnapshot, atari: AtariEnv, stateful: list[Environment]) -> bytes:
    """The snapshot of a stack of wrappers that continues a lane."""
    require_same(snapshot.task, atari.task)
    lane = split(snapshot, atari.task, atari.driver)
    states = [layer._state_of_lane(lane) for layer in stateful if isinstance(layer, Restorable)]
    if len(states) != 1 or len(stateful) != 1 or states[0] is None:
        names = ", ".join(type(layer).__name__ for layer in stateful) or "none"
        raise ValueError(
            "a lane's snapshot continues in what atari.make(envs.task) returns, an EpisodeEnv without another wrapper "
            f"that has a state; the wrappers with a state are {names}"
        )
    episode = new_episode(atari.task, atari.driver)
    episode.load(lane.episode)
    return _pack(atari, atari._snapshot_of(lane, episode), stateful, [states[0]])


def _identity(layer: Environment) -> dict[str, Any]:
    arguments: Any = layer.snapshot_arguments if isinstance(layer, Restorable) else layer._saved_kwargs  # type: ignore[attr-defined]
    return {"wrapper": type(layer).__name__, "arguments": json.loads(json.dumps(arguments))}


def _save_state(layer: Any) -> State:
    if isinstance(layer, TimeLimit):
        steps = layer._elapsed_steps
        return {"_elapsed_steps": -1 if steps is None else steps}
    return layer._save_state()


def _load_state(layer: Any, state: State) -> dict[str, Any]:
    if isinstance(layer, TimeLimit):
        steps = state["_elapsed_steps"]
        return {"_elapsed_steps": None if steps < 0 else steps}
    return layer._load_state(state)


def _allow_step(layer: Environment) -> None:
    """Let a wrapper of Gymnasium step before its first reset; `AtariEnv` itself checks for a reset."""
    if isinstance(layer, OrderEnforcing):
        layer._has_reset = True
    elif isinstance(layer, PassiveEnvChecker) and not layer.checked_reset:
        layer.checked_step = layer.checked_data_reuse = True  # the checks compare with the observation of a reset


def _checked_layers(saved: Any, stateful: list[Environment]) -> list[dict[str, Any]]:
    """The scalars of each layer, after a check that the snapshot has the same wrappers."""
    sound = isinstance(saved, list) and all(isinstance(part, dict) and "state" in part for part in saved)
    if not sound or not all(isinstance(part["state"], dict) for part in saved):
        raise _damaged("it has no list of wrappers")
    names = [part.get("wrapper") for part in saved]
    if not all(isinstance(name, str) for name in names):
        raise _damaged("a wrapper has no name")
    own = [type(layer).__name__ for layer in stateful]
    if names != own:
        raise ValueError(
            f"the snapshot was taken with the wrappers {', '.join(names)[:200] or 'none'}, but this environment has "
            f"{', '.join(own) or 'none'}; restore it into the same wrappers"
        )
    for part, layer in zip(saved, stateful, strict=True):
        if part.get("arguments") != (arguments := _identity(layer)["arguments"]):
            raise ValueError(
                f"the snapshot was taken with other arguments of {type(layer).__name__} than {arguments}; "
                "restore it into wrappers made with the same arguments"
            )
    return [part["state"] for part in saved]


def _state(layer: Environment, number: int, scalars: dict[str, Any], blobs: Mapping[str, bytes]) -> State:
    """The saved state of a layer, with the names, types, shapes and dtypes of its current one."""
    state = {}
    for name, now in _save_state(layer).items():
        if isinstance(now, np.ndarray):
            if f"{number}.{name}" not in blobs:
                raise ValueError(
                    f"the snapshot has no {name} of {type(layer).__name__}: it is damaged, or of another release; "
                    "take a new one"
                )
            state[name] = _array(blobs[f"{number}.{name}"], now)
        elif type(scalars.get(name)) is type(now):
            state[name] = scalars[name]
        else:
            raise _damaged(f"{name} of {type(layer).__name__} is not of type {type(now).__name__}")
    return state


def _array(blob: bytes, like: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    unpacker = zlib.decompressobj()
    try:
        data = unpacker.decompress(blob, like.nbytes + 1)
    except zlib.error as error:
        raise _damaged(str(error)) from None
    if len(data) != like.nbytes or not unpacker.eof or unpacker.unused_data:
        raise _damaged(f"an array has not {like.nbytes} bytes")
    return np.frombuffer(bytearray(data), like.dtype).reshape(like.shape)


def _damaged(text: str) -> ValueError:
    return ValueError(f"the snapshot is damaged: {text}")
