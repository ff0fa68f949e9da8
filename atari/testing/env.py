"""`check_env`: the contract of environments, for authors of environments and wrappers."""

import copy
import math
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from inspect import signature
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import env_checker

from atari.env import AtariEnv
from atari.testing.contract import broken_by, check_copies, check_maker, refuses, require, require_in, require_same

Env = gymnasium.Env[Any, Any]
MakeEnv = Callable[[], Env]

_NO_FAULTS = (".*different from the unwrapped version", ".*env.seed to get variables")
"""Warnings of Gymnasium's checker about wrappers, and in 0.29 about its own call of an environment."""


def check_env(make: MakeEnv, *, steps: int = 60, copies: bool = True, spec: bool = True) -> None:
    """Check that environments keep Gymnasium's interface, and the contract of this package's environments.

    Gymnasium's `check_env` is first; its warnings stay warnings. The other checks cover the dtype, shape and bounds of
    every observation, including the last ones of episodes; observations that must not change later; equal results for
    equal seeds, in the same environment and in another one; errors for actions and seeds that do not exist, before
    anything changes; the lives, frames and ends of the game in an `AtariEnv`; copies, pickles, `snapshot` and
    `restore`; and `gymnasium.make(env.spec)`.

    Args:
        make: a function without parameters that makes the environment, with its wrappers.
        steps: number of random actions in a comparison.
        copies: whether the environment can be copied and pickled, and then continues from its state.
        spec: whether `env.spec`, if there is one, makes the same environment with its wrappers, which then have the
            base class `gymnasium.utils.RecordConstructorArgs`.

    Raises:
        ContractError: the environment breaks the contract; the message has the call, the expected and the real result.
        TypeError: `make` is no function.

    Example:
        >>> import atari
        >>> from atari.testing import check_env
        >>> from atari.wrappers import ClipReward
        >>> check_env(lambda: ClipReward(atari.make("pong", obs_type="ram")))
    """
    check_maker("check_env", make, "MyEnv()")
    env, twin = _made(make), _made(make)
    _check_gymnasium(_made(make))
    actions = some_actions(env.action_space, steps)
    with refuses("step() before the first reset()"):
        env.step(actions[0])
    expected = _check_seeds(env, twin, actions)
    _check_results(env, actions)
    if isinstance(env.unwrapped, AtariEnv):
        _check_game(env, actions)
    _check_refusals(env)
    if copies:
        _check_copies(env, actions)
    if hasattr(type(env), "snapshot"):
        _check_snapshots(env, twin, actions)
    if spec and env.spec is not None:
        with broken_by("gymnasium.make(env.spec) (spec=False leaves this check out)"):
            remade = gymnasium.make(env.spec)
        require(str(remade) == str(env), f"gymnasium.make(env.spec) must make {env}, made {remade}")
        seen = _rollout_from(remade, 3, actions)
        require_same(expected, seen, "results", "gymnasium.make(env.spec) must play the same")
        remade.close()
    for each in (env, twin):
        each.close()


def some_actions(space: spaces.Space[Any], count: int) -> list[Any]:
    """Random actions of a space, without a change of its own generator."""
    space = copy.deepcopy(space)
    space.seed(0)
    return [space.sample() for _ in range(count)]


def _made(make: MakeEnv) -> Env:
    with broken_by("make()"):
        env = make()
    require(isinstance(env, gymnasium.Env), f"make() must return a gymnasium.Env, got {env!r}")
    return env


def _check_gymnasium(env: Env) -> None:
    with warnings.catch_warnings(), broken_by("gymnasium.utils.env_checker.check_env(env)"):
        for message in _NO_FAULTS:
            warnings.filterwarnings("ignore", message=message)
        known = signature(env_checker.check_env).parameters  # Gymnasium 0.29 does not skip the close, nor check it
        skipped = [name for name in ("skip_render_check", "skip_close_check") if name in known]
        env_checker.check_env(env, **dict.fromkeys(skipped, True))
    with broken_by("close() after close()"):
        env.close()
        env.close()


def _rollout(env: Env, actions: list[Any]) -> list[Any]:
    """All results of these actions, with a reset after each episode."""
    results: list[Any] = []
    for action in actions:
        results.append(copy.deepcopy(env.step(action)))
        if results[-1][2] or results[-1][3]:
            results.append(copy.deepcopy(env.reset()))
    return results


def _rollout_from(env: Env, seed: int, actions: list[Any]) -> list[Any]:
    return [copy.deepcopy(env.reset(seed=seed)), *_rollout(env, actions)]


def _check_seeds(env: Env, twin: Env, actions: list[Any]) -> list[Any]:
    """Check that a seed decides all results, and return the results of seed 3."""
    expected = _rollout_from(env, 3, actions)
    seen = _rollout_from(twin, 3, actions)
    require_same(expected, seen, "results", "reset(seed=3) must give the same episode in two environments")
    seen = _rollout_from(env, 3, actions)
    require_same(expected, seen, "results", "reset(seed=3) must start everything over in a used environment")
    return expected


def _check_results(env: Env, actions: list[Any]) -> None:
    kept = []
    observation, info = env.reset(seed=4)
    require_in(env.observation_space, observation, "reset()")
    require(isinstance(info, dict), f"reset() must return a dict of info, got {info!r:.60}")
    for number, action in enumerate(actions, 1):
        kept.append((observation, copy.deepcopy(observation)))
        observation, reward, terminated, truncated, info = env.step(action)
        call = f"step({action!r}), number {number} after reset(seed=4),"
        ended = " at the end of an episode" if terminated or truncated else ""
        require_in(env.observation_space, observation, call + ended)
        number_given = isinstance(reward, (int, float, np.integer, np.floating)) and not isinstance(reward, bool)
        require(number_given and math.isfinite(reward), f"{call} must return a finite number as reward, got {reward!r}")
        for name, value in (("terminated", terminated), ("truncated", truncated)):
            require(isinstance(value, (bool, np.bool_)), f"{call} must return a bool as {name}, got {value!r}")
        require(isinstance(info, dict), f"{call} must return a dict of info, got {info!r:.60}")
        if ended:
            kept.append((observation, copy.deepcopy(observation)))
            observation, info = env.reset()
            require_in(env.observation_space, observation, "reset()")
    for number, (observation, copied) in enumerate(kept):
        sentence = f"a later step must not change an observation that was returned ({number} results before the end)"
        require_same(copied, observation, "the observation", sentence)


def _check_game(env: Env, actions: list[Any]) -> None:
    """Check that `info` and the ends agree with the game in the environment."""
    atari: Any = env.unwrapped
    env.reset(seed=5)
    for number, action in enumerate(actions, 1):
        *_, terminated, truncated, info = env.step(action)
        call = f"step({action!r}), number {number} after reset(seed=5),"
        for name in ("lives", "frame_number", "episode_frame_number"):
            if name in info:
                seen, expected = info[name], getattr(atari.core, name)
                require(seen == expected, f"{call} must return info[{name!r}]={expected} of the game, got {seen}")
        over = atari.core.game_over or atari.core.truncated
        require(terminated or truncated or not over, f"{call} must end the episode: the game is over")
        if terminated or truncated:
            env.reset()


def _check_refusals(env: Env) -> None:
    env.reset(seed=6)
    wrong: list[Any] = [None, "NOOP"]
    if isinstance(env.action_space, spaces.Discrete):
        first, count = int(env.action_space.start), int(env.action_space.n)
        wrong += [first + count, first - 1, first + 0.5]
    for action in wrong:
        with _unchanged(env, f"step({action!r})"), refuses(f"step({action!r})"):
            env.step(action)
    for seed in (-1, "1", 0.5):
        with _unchanged(env, f"reset(seed={seed!r})"), refuses(f"reset(seed={seed!r})"):
            env.reset(seed=seed)  # type: ignore[arg-type]


@contextmanager
def _unchanged(env: Any, call: str) -> Iterator[None]:
    """Check that the block does not change the environment, if it has snapshots."""
    before = env.snapshot() if hasattr(type(env), "snapshot") else None
    yield
    same = before is None or env.snapshot() == before
    require(same, f"{call} must change nothing, but the snapshot of the environment is another one")


def _check_copies(env: Env, actions: list[Any]) -> None:
    env.reset(seed=7)
    _rollout(env, actions[: len(actions) // 2])
    calls = ("copy.deepcopy(env)", "pickle.loads(pickle.dumps(env))")
    check_copies(env, lambda one: _rollout(one, actions), calls, "the environment")


def _check_snapshots(env: Any, twin: Any, actions: list[Any]) -> None:
    with broken_by("snapshot()"):
        saved = env.snapshot()
    expected = _rollout(env, actions)
    for target, place in ((env, "the same environment"), (twin, "another environment")):
        with broken_by(f"restore() in {place}"):
            target.restore(saved)
        require(target.snapshot() == saved, f"after restore() in {place}, snapshot() must return what was restored")
        require_same(expected, _rollout(target, actions), "results", f"restore() in {place} must continue exactly")
    saved = env.snapshot()
    for name, bad in (("half a snapshot", saved[: len(saved) // 2]), ("a text", "snapshot")):
        with _unchanged(env, f"restore() of {name}"), refuses(f"restore() of {name}", TypeError, ValueError):
            env.restore(bad)
