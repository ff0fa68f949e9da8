"""`check_vector`: the contract of vector environments, for authors of vectors and their wrappers."""

import copy
import inspect
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector.utils import batch_space

from atari.base.gymnasium_versions import AutoresetMode
from atari.testing.contract import broken_by, check_copies, check_maker, refuses, require, require_in, require_same
from atari.testing.env import MakeEnv, some_actions
from atari.vector.results import indexed

MakeVector = Callable[[], Any]
"""The function returns a `gymnasium.vector.VectorEnv`."""

Bools = npt.NDArray[np.bool_]
Results = list[tuple[Any, ...]]


def check_vector(
    make: MakeVector, *, single: MakeEnv | None = None, steps: int = 60, copies: bool = True, atomic: bool = True
) -> None:
    """Check that vector environments keep Gymnasium's interface, and the contract of this package's vectors.

    The checks cover the spaces, the shape and dtype of every result, the masks of `info`, seeds (environment i gets
    seed + i), observations that must not change later, the autoreset mode with its final observations, actions that
    must be refused, copies, and, if the vector has them, `out`, `send` and `recv`, `snapshot` and `restore`.

    Args:
        make: a function without parameters that makes the vector, with batches of all environments. Episodes must end
            within `steps`; pass it a low limit, for example `max_episode_steps=20`.
        single: makes one such environment. Environment i must play like it with the seed of i.
        steps: number of steps of random actions in a comparison.
        copies: whether the vector can be copied and pickled, and then continues from its state.
        atomic: whether a step that raises an error has played nothing. Gymnasium's `SyncVectorEnv` plays environments
            until one raises.

    Raises:
        ContractError: the vector breaks the contract; the message has the call, and the expected and the actual result.
        TypeError, ValueError: `make` is no function, or makes a vector that cannot be checked.

    Example:
        >>> import atari
        >>> from atari.testing import check_vector
        >>> options = {"obs_type": "ram", "max_episode_steps": 20}
        >>> check_vector(
        ...     lambda: atari.AtariVectorEnv("ALE/Pong-v5", 2, **options),
        ...     single=lambda: atari.make("ALE/Pong-v5", **options),
        ... )
    """
    check_maker("check_vector", make, "MyVectorEnv(...)")
    envs, twin = _made(make), _made(make)
    mode = _mode(envs)
    _check_spaces(envs)
    actions = some_actions(envs.action_space, steps)
    with refuses("step() before the first reset()"):
        envs.step(actions[0])
    results = _check_results(envs, mode, actions)
    _check_ends(mode, results)
    _check_seeds(envs, twin, mode, actions)
    if single is not None:
        for lane in range(envs.num_envs):
            _check_lane(results, single, lane, mode, actions)
    _check_refusals(envs, twin, mode, actions if atomic else [])
    if copies:
        _check_copies(envs, mode, actions)
    if "out" in inspect.signature(envs.step).parameters:
        _check_out(envs, twin, mode, actions)
    if hasattr(envs, "send") and hasattr(envs, "recv"):
        _check_send(envs, twin, actions[0])
    if hasattr(envs, "snapshot"):
        _check_snapshots(envs, twin, mode, actions)
    for each in (envs, twin):
        each.close()


def _made(make: MakeVector) -> Any:
    with broken_by("make()"):
        envs = make()
    fits = isinstance(envs, gymnasium.vector.VectorEnv)
    require(fits, f"make() must return a gymnasium.vector.VectorEnv, got {envs!r}")
    rows = getattr(envs, "batch_size", envs.num_envs)
    if rows != envs.num_envs:
        raise ValueError(f"check_vector needs batches of all {envs.num_envs} environments, got batch_size={rows}")
    return envs


def _mode(envs: Any) -> AutoresetMode:
    mode = envs.metadata.get("autoreset_mode")
    require(isinstance(mode, AutoresetMode), f'metadata["autoreset_mode"] must be an AutoresetMode, got {mode!r}')
    return mode


def _check_spaces(envs: Any) -> None:
    for name in ("observation", "action"):
        single, batched = getattr(envs, f"single_{name}_space"), getattr(envs, f"{name}_space")
        expected = batch_space(single, envs.num_envs)
        same = batched == expected or (name == "action" and batched.shape[:1] == (envs.num_envs,))
        require(same, f"{name}_space must be single_{name}_space for {envs.num_envs} environments, got {batched}")


def ended(result: tuple[Any, ...]) -> Bools:
    """The environments (n,) whose episode a step has ended; with several players, the episode of all."""
    ends: Bools = result[2] | result[3]
    return np.logical_and.reduce(ends.reshape(len(ends), -1), axis=1)


def _rollout(envs: Any, mode: AutoresetMode, actions: list[Any]) -> Results:
    """The results of these actions; without an autoreset, the results of a reset follow the end of an episode."""
    results: Results = []
    for action in actions:
        results.append(copy.deepcopy(envs.step(action)))
        if mode == AutoresetMode.DISABLED and ended(results[-1]).any():
            results.append(copy.deepcopy(envs.reset(options={"reset_mask": ended(results[-1])})))
    return results


def _rollout_from(envs: Any, seed: Any, mode: AutoresetMode, actions: list[Any]) -> Results:
    return [copy.deepcopy(envs.reset(seed=seed)), *_rollout(envs, mode, actions)]


def _check_results(envs: Any, mode: AutoresetMode, actions: list[Any]) -> Results:
    """Check each result, and return the results from `reset(seed=3)` on."""
    observation, info = envs.reset(seed=3)
    results = [copy.deepcopy((observation, info))]
    kept = [(observation, results[0][0])]
    _check_observation_and_info(envs, observation, info, "reset(seed=3)")
    for number, action in enumerate(actions, 1):
        call = f"step() number {number} after reset(seed=3)"
        result = envs.step(action)
        _check_signals(envs, result, call)
        _check_observation_and_info(envs, result[0], result[4], call)
        if mode == AutoresetMode.SAME_STEP and ended(result).any():
            _check_final(envs, result, call)
        results.append(copy.deepcopy(result))
        kept.append((result[0], results[-1][0]))
        if mode == AutoresetMode.DISABLED and ended(result).any():
            mask = ended(result)
            observation, info = envs.reset(options={"reset_mask": mask})
            results.append(copy.deepcopy((observation, info)))
            rows = [indexed(observation, lane) for lane in np.flatnonzero(~mask)]
            before = [indexed(result[0], lane) for lane in np.flatnonzero(~mask)]
            require_same(before, rows, "rows", "reset() with a reset_mask must leave other environments as they are")
    for observation, copied in kept:
        sentence = "a later step must not change an observation that was returned"
        require_same(copied, observation, "the observation", sentence)
    return results


def _check_observation_and_info(envs: Any, observation: Any, info: Any, call: str) -> None:
    require_in(envs.observation_space, observation, call)
    require(isinstance(info, dict), f"{call} must return a dict of info, got {info!r:.60}")
    for name in info:
        mask = info.get(f"_{name}")
        fits = isinstance(mask, np.ndarray) and (mask.dtype, mask.shape) == (np.bool_, (envs.num_envs,))
        seen = f"{mask.dtype} {mask.shape}" if isinstance(mask, np.ndarray) else repr(mask)
        sentence = f"{call} must return info[{name!r}] with the mask '_{name}', bool ({envs.num_envs},), got {seen}"
        require(name.startswith("_") or fits, sentence)


def _check_signals(envs: Any, result: tuple[Any, ...], call: str) -> None:
    require(len(result) == 5, f"{call} must return five results, got {len(result)}")
    rewards = result[1]
    fits = isinstance(rewards, np.ndarray) and rewards.dtype.kind in "fiu" and rewards.shape[:1] == (envs.num_envs,)
    seen = f"{rewards.dtype} {rewards.shape}" if isinstance(rewards, np.ndarray) else f"{rewards!r:.60}"
    require(fits, f"{call} must return an array of {envs.num_envs} rewards, got {seen}")
    for name, ends in (("terminations", result[2]), ("truncations", result[3])):
        fits = isinstance(ends, np.ndarray) and (ends.dtype, ends.shape) == (np.bool_, rewards.shape)
        seen = f"{ends.dtype} {ends.shape}" if isinstance(ends, np.ndarray) else f"{ends!r:.60}"
        require(fits, f"{call} must return {name} bool {rewards.shape}, got {seen}")


def _check_final(envs: Any, result: tuple[Any, ...], call: str) -> None:
    ends, info = ended(result), result[4]
    require("final_obs" in info, f"{call} ended an episode and must return info['final_obs'], got {sorted(info)}")
    lacking = np.flatnonzero(ends & ~info["_final_obs"])
    require(not len(lacking), f"{call} ended the episodes of {lacking.tolist()}, and '_final_obs' is False there")
    for lane in np.flatnonzero(ends):
        require_in(
            envs.single_observation_space, indexed(info["final_obs"], lane), f"{call}: info['final_obs'][{lane}]"
        )


def _steps(results: Results) -> Results:
    """The results of steps, without the results of resets."""
    return [result for result in results if len(result) == 5]


def _check_ends(mode: AutoresetMode, results: Results) -> None:
    """Check that the final observation comes first, and then the reset's."""
    if not any(ended(result).any() for result in _steps(results)):
        raise ValueError(
            f"no episode ended within {len(_steps(results))} steps, so check_vector cannot check the ends; make "
            "environments with a low max_episode_steps, or pass more steps"
        )
    pairs = []
    for result, after in zip(results, [*results[1:], None], strict=True):
        for lane in np.flatnonzero(ended(result)) if len(result) == 5 else ():
            if mode == AutoresetMode.SAME_STEP:
                pairs.append((indexed(result[4]["final_obs"], lane), indexed(result[0], lane)))
            elif after is not None:
                pairs.append((indexed(result[0], lane), indexed(after[0], lane)))
                _check_reset_step(after, lane)
    shown = "info['final_obs']" if mode == AutoresetMode.SAME_STEP else "the observation of the step that ended it"
    require(
        not pairs or any(_differ(final, first) for final, first in pairs),
        f"{shown} must be the last one of the episode, but it is that of the next reset in all {len(pairs)} ends",
    )


def _check_reset_step(after: tuple[Any, ...], lane: Any) -> None:
    """Check that in NEXT_STEP the step after an end resets: its reward is 0 and it ends nothing."""
    if len(after) == 5:
        reward = after[1][lane]
        require(not np.any(reward), f"the step after an end resets and must pay 0, but environment {lane} got {reward}")
        require(not ended(after)[lane], f"the step after an end resets and must end nothing (environment {lane})")


def _differ(one: Any, other: Any) -> bool:
    if isinstance(one, dict):
        return any(_differ(one[name], other[name]) for name in one)
    return not np.array_equal(one, other)


def _check_seeds(envs: Any, twin: Any, mode: AutoresetMode, actions: list[Any]) -> None:
    expected = _rollout_from(envs, 3, mode, actions)
    seen = _rollout_from(twin, 3, mode, actions)
    require_same(expected, seen, "results", "reset(seed=3) must give the same results in two vectors")
    seen = _rollout_from(envs, 3, mode, actions)
    require_same(expected, seen, "results", "reset(seed=3) must start everything over in a used vector")
    seeds = [3 + lane for lane in range(envs.num_envs)]
    seen = _rollout_from(envs, seeds, mode, actions)
    require_same(expected, seen, "results", f"reset(seed=3) must give environment i the seed 3 + i, as seed={seeds}")


def _check_lane(results: Results, single: MakeEnv, lane: int, mode: AutoresetMode, actions: list[Any]) -> None:
    """Check that an environment of the vector plays like a single one."""
    env = single()
    parts = [indexed(results[0][0], lane)], [env.reset(seed=3 + lane)[0]]
    over, number = False, 0
    for result in results[1:]:
        if len(result) == 2:  # a reset of the environments whose episode is over
            if over:
                parts = [indexed(result[0], lane)], [env.reset()[0]]
                over = False
                require_same(parts[1], parts[0], "observation", f"environment {lane} must be reset as a single one")
            continue
        number += 1
        observation, reward, terminated, truncated, info = result
        mine = [indexed(observation, lane), float(reward[lane]), bool(terminated[lane]), bool(truncated[lane])]
        if over and mode == AutoresetMode.NEXT_STEP:
            theirs, over = [env.reset()[0], 0.0, False, False], False
        else:
            theirs = list(env.step(indexed(actions[number - 1], lane))[:4])
            over = theirs[2] or theirs[3]
            if over and mode == AutoresetMode.SAME_STEP:
                mine[0] = [indexed(info["final_obs"], lane) if mine[2] or mine[3] else None, mine[0]]
                theirs[0] = [theirs[0], env.reset()[0]]
                over = False
        sentence = f"step() number {number} must give environment {lane} what a single one of seed {3 + lane} gets"
        require_same(theirs, mine, "observation, reward, terminated, truncated", sentence)
    env.close()


def _check_refusals(envs: Any, twin: Any, mode: AutoresetMode, actions: list[Any]) -> None:
    for each in (envs, twin):
        each.reset(seed=6)
    wrong: list[Any] = [None, "NOOP"]
    space = envs.single_action_space
    if isinstance(space, spaces.Discrete):
        last = space.start + space.n
        wrong += [np.full(envs.num_envs, last), np.full(envs.num_envs - 1, space.start), np.full(envs.num_envs, 0.5)]
    for action in wrong:
        with refuses(f"step({action!r})"):
            envs.step(action)
    with refuses("reset(seed=-1)"):
        envs.reset(seed=-1)
    expected, seen = _rollout(twin, mode, actions), _rollout(envs, mode, actions)
    require_same(expected, seen, "results", "a step or a reset that was refused must change nothing")


def _check_copies(envs: Any, mode: AutoresetMode, actions: list[Any]) -> None:
    envs.reset(seed=7)
    _rollout(envs, mode, actions[: len(actions) // 2])
    calls = ("copy.deepcopy of the vector", "a pickle of the vector")
    check_copies(envs, lambda one: _rollout(one, mode, actions), calls, "the vector")


def _check_out(envs: Any, twin: Any, mode: AutoresetMode, actions: list[Any]) -> None:
    out = copy.deepcopy(envs.reset(seed=8)[0])
    twin.reset(seed=8)
    expected = copy.deepcopy(twin.step(actions[0]))
    try:
        seen = envs.step(actions[0], out=out)
    except ValueError:  # a layout that is not written in place
        seen = envs.step(actions[0])
    else:
        require_same(expected[0], out, "out", "step(actions, out=out) must fill out")
    require_same(expected, seen, "results", "step(actions, out=out) must return what step(actions) returns, or raise")


def _check_send(envs: Any, twin: Any, action: Any) -> None:
    for each in (envs, twin):
        each.reset(seed=9)
    with refuses("recv() without send()"):
        envs.recv()
    envs.send(action)
    with refuses("send() after send()"):
        envs.send(action)
    require_same(twin.step(action), envs.recv(), "results", "send() and recv() must return what step() returns")


def _check_snapshots(envs: Any, twin: Any, mode: AutoresetMode, actions: list[Any]) -> None:
    envs.reset(seed=10)
    saved = envs.snapshot()
    expected = _rollout(envs, mode, actions)
    for target, place in ((envs, "the same vector"), (twin, "another vector")):
        with broken_by(f"restore() in {place}"):
            target.restore(None, saved)
        require_same(
            expected, _rollout(target, mode, actions), "results", f"restore() in {place} must continue exactly"
        )
