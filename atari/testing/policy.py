"""`check_policy`: the contract of `atari.learning.Policy`, for authors of policies."""

import copy
import pickle
import reprlib
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from typing_extensions import Unpack

from atari.games.catalog import games
from atari.policy import LoadedPolicy, describe, makes_policy
from atari.policy.needs import in_game, needs_of
from atari.task import Task
from atari.task.fields import VectorTaskOptions
from atari.task.task import GameLike, look_up
from atari.testing.contract import ContractError, broken_by, require, require_same
from atari.vector import AtariVectorEnv
from atari.vector.options import task_of_lane
from atari.vector.results import indexed

IntArray = npt.NDArray[np.int64]

_LANES = 3


class _Call(NamedTuple):
    """A call of a policy: copies of the observations, and the actions (n,) that it returned."""

    observations: Any
    actions: IntArray


def check_policy(
    policy: Any,
    game: GameLike | None = None,
    *,
    preset: str | None = None,
    steps: int = 20,
    **options: Unpack[VectorTaskOptions],
) -> None:
    """Check that a policy keeps the contract of `atari.learning.Policy`.

    The policy plays three environments. It must return an action of the game for each, and not change the
    observations. It must return the same actions after `begin` with the same seeds, and the same for one environment
    alone as for a batch. After `restore` it must continue like after the saved `state`.

    Args:
        policy: a `Policy`, a function of observations, or a class of policies; a network, a file or a name in the form
            that `atari.learning.load_policy` returns.
        game: the game, in a form that `atari.AtariVectorEnv` takes; None means the game of its attribute `game` or
            `task`.
        preset, options: arguments of `AtariVectorEnv`, for a policy without `task` and `environment`.
        steps: number of steps.

    Raises:
        ContractError: the policy breaks the contract; the message has the call, and the expected and the actual result.
        TypeError, ValueError: the game or an option is wrong, or the policy has its own `task` or `environment`.

    Example:
        >>> from atari.learning import load_policy
        >>> from atari.testing import check_policy
        >>> check_policy(load_policy("random"), "pong", preset="dqn2015")
        >>> check_policy(lambda observations: [0] * len(observations), "pong", obs_type="ram")
    """
    loaded = _loaded(policy)
    own: Any = getattr(loaded, "game", None) or getattr(loaded, "task", None)
    if game is None and own is None:
        raise TypeError("check_policy needs a game, for a policy without the attributes game and task")
    given = task_of_lane(look_up(game or own), preset, options)
    task, layout, names = _played(loaded, given, {"preset": preset, **options})
    envs = AtariVectorEnv(task, _LANES, **layout)
    every = [action.name for action in task.action_set]
    indices = np.array([every.index(name) for name in names])
    seeds = np.arange(_LANES, dtype=np.int64) + 7
    lanes = np.arange(_LANES, dtype=np.int64)
    begin = (task.game, names)
    with broken_by("begin(game, actions, lanes, seeds)"):
        loaded.begin(*begin, lanes, seeds)
    calls, observations = [], envs.reset(seed=0)[0]
    for _ in range(steps):
        calls.append(_call(loaded, observations, lanes))
        observations = envs.step(indices[calls[-1].actions])[0]
    envs.close()
    loaded.begin(*begin, lanes, seeds)
    for number, call in enumerate(calls, 1):
        seen = _call(loaded, call.observations, lanes).actions
        sentence = f"call {number} after begin() with the same seeds must return the same actions"
        require_same(call.actions, seen, "the policy", sentence)
    _check_alone(loaded, begin, calls, seeds)
    _check_state(loaded, begin, calls, seeds)


def _loaded(policy: Any) -> LoadedPolicy:
    if isinstance(policy, LoadedPolicy):
        return policy
    if not callable(policy) or hasattr(policy, "state_dict"):
        raise TypeError(
            f"check_policy takes a function of observations and lanes, got {reprlib.repr(policy)}; for a network, a "
            "file or a name, pass atari.learning.load_policy(...)"
        )
    try:
        loaded = LoadedPolicy(policy() if makes_policy(policy) else policy)
    except (TypeError, ValueError) as error:
        raise ContractError(str(error)) from error
    name = getattr(loaded, "game", None)
    require(name is None or name in games, f"game must be the id of a game, got {name!r}")
    return loaded


def _played(
    policy: LoadedPolicy, task: Task, options: Mapping[str, Any]
) -> tuple[Task, Mapping[str, Any], tuple[str, ...]]:
    """The task of a policy, the options of its vector, and the names of its actions."""
    try:
        needs = needs_of(policy, task.definition)
    except ValueError as error:
        raise ContractError(str(error)) from error
    if needs.task is not None:
        if wrong := [name for name, value in options.items() if name != "preset" or value is not None]:
            raise ValueError(f"the policy says what it sees, by its task or environment; leave out {wrong[0]}")
        task = needs.task if needs.task.game == task.game else in_game(needs.task, task)
    every = [action.name for action in task.action_set]
    names = needs.actions or tuple(every)
    lacking = [name for name in names if name not in every]
    require(not lacking, f"the policy has the actions {', '.join(lacking)}, and {task.game} has {', '.join(every)}")
    return task, needs.options, names


def _call(policy: LoadedPolicy, observations: Any, lanes: IntArray) -> _Call:
    before = copy.deepcopy(observations)
    call = f"policy({describe(observations)}, {lanes.tolist()})"
    with broken_by(call):
        returned, extras = policy.choose(observations, lanes)
    require_same(before, observations, "the observation", f"{call} must not write to the observations")
    try:
        actions = policy.checked(returned, lanes)
    except ValueError as error:
        raise ContractError(str(error)) from error
    for name, extra in extras.items():
        rows = np.shape(extra)[:1]
        require(rows == (len(lanes),), f"{call} must return a row of {name!r} for each lane, got {np.shape(extra)}")
    return _Call(before, actions)


def _check_alone(policy: LoadedPolicy, begin: tuple[str, tuple[str, ...]], calls: list[_Call], seeds: IntArray) -> None:
    """Check that results do not depend on the other environments of a batch."""
    for lane in range(_LANES):
        lanes = np.array([lane], np.int64)
        policy.begin(*begin, lanes, seeds[lane : lane + 1])
        for number, call in enumerate(calls, 1):
            row = copy.deepcopy(indexed(call.observations, slice(lane, lane + 1)))
            (action,) = _call(policy, row, lanes).actions
            require(
                action == call.actions[lane],
                f"call {number} must return the same action for lane {lane} alone as in a batch of {_LANES}, got "
                f"{action} alone and {call.actions[lane]} in the batch",
            )


def _check_state(policy: LoadedPolicy, begin: tuple[str, tuple[str, ...]], calls: list[_Call], seeds: IntArray) -> None:
    has = {name: hasattr(policy, name) for name in ("state", "restore")}
    if not any(has.values()):
        return
    require(all(has.values()), "a policy has state() and restore(state), or neither of them")
    lanes = np.arange(_LANES, dtype=np.int64)
    policy.begin(*begin, lanes, seeds)
    half = len(calls) // 2
    for call in calls[:half]:
        _call(policy, call.observations, lanes)
    with broken_by("pickle.dumps(policy.state())"):
        saved = pickle.dumps(policy.state())
    for call in calls[half:]:
        _call(policy, call.observations, lanes)
    with broken_by("restore(state)"):
        policy.restore(pickle.loads(saved))
    for number, call in enumerate(calls[half:], half + 1):
        seen = _call(policy, call.observations, lanes).actions
        require_same(call.actions, seen, "the policy", f"restore(state()) must continue exactly (call {number})")
