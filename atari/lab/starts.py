"""`spread`: brings the environments of a vector to different moments of their games."""

from collections.abc import Callable
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from atari.base.gymnasium_versions import AutoresetMode, VectorEnv
from atari.base.validation import check_integer
from atari.cores.options import SEED_LIMIT
from atari.policy import LoadedPolicy
from atari.vector import AtariVectorEnv
from atari.vector.results import indexed

Lanes = npt.NDArray[np.int64]
Choose = Callable[[Any, Lanes], npt.NDArray[np.int64]]


def spread(
    envs: VectorEnv, seed: int, *, policy: Callable[..., Any] | None = None, steps: int = 27_000
) -> tuple[Any, dict[str, Any]]:
    """Bring each environment of a vector to a random moment of a game, so that they do not play in lockstep.

    After a reset all games begin together, so the first batches of a learner have beginnings alone. Here each
    environment plays until its game is over. It then goes on from a state of this game, with the draws that followed.
    Each state is equally probable. `seed`, the environments' states and the policy decide the result; the number of
    threads does not.

    **Scores of games that go on from such a state are no evaluation**: their beginnings were played by another policy.

    Args:
        envs: an `AtariVectorEnv` after a reset, with batches of all environments; or a wrapper of one with its own
            `step`, `reset`, `snapshot` and `restore`. Other wrappers go around the vector afterwards.
        seed: the seed of the moments, of random actions and of the policy, within 0..2**32-1.
        policy: a function of observations, or of observations and lanes, that chooses actions; see
            `atari.policy.Policy`. It must take the observations of the vector. None plays random actions.
        steps: the most steps that are played; the moment in a longer game is within them.

    Returns:
        The observations and `info` of `AtariVectorEnv.observe`.

    Raises:
        TypeError: `envs` is no such vector.
        ValueError: the seed or `steps` is out of range; the batches are smaller than the vector; it has several players
            or continuous actions; or a policy would play several games.
        gymnasium.error.ResetNeeded, RuntimeError: the vector was not reset, or is being played (between `send` and
            `recv`).

    An error of the policy is raised after the environments have got back their states.

    Example:
        >>> import atari
        >>> from atari.lab import spread
        >>> envs = atari.AtariVectorEnv("breakout", 4, preset="dqn2015")
        >>> observations, info = envs.reset(seed=0)
        >>> observations, info = spread(envs, seed=0)
        >>> info["episode_frame_number"], info["lives"]
        (array([1094,  177,  509, 1049], dtype=int32), array([1, 4, 2, 1], dtype=int32))
    """
    vector, played = _checked(envs), cast(Any, envs)
    rng = np.random.default_rng(check_integer("seed", seed, 0, SEED_LIMIT - 1))
    limit = check_integer("steps", steps, 1, 10**9)
    start = played.snapshot()
    chooser = None if policy is None else _begun(policy, vector, rng)
    try:
        moments = _moments(played, vector, chooser, rng, limit)
    except BaseException:
        if vector.started:  # after an error of the engine, a reset must follow
            played.restore(None, start)
        raise
    played.restore(None, moments)
    return vector.observe()


def _checked(envs: Any) -> AtariVectorEnv:
    """The vector in `envs`, if `spread` takes it."""
    vector = getattr(envs, "unwrapped", None)
    if not isinstance(vector, AtariVectorEnv):
        raise TypeError(f"spread takes an AtariVectorEnv, got {type(envs).__name__}; a single environment has one game")
    if not hasattr(type(envs), "restore"):
        raise TypeError(
            f"spread plays and restores the vector itself, which {type(envs).__name__} would not notice; give "
            "envs.unwrapped, before the wrappers are made"
        )
    if vector.batch_size != vector.num_envs:
        raise ValueError(f"spread needs batches of all environments, got batch_size={vector.batch_size}")
    if vector.task.players > 1 or vector.continuous:
        many = f"players={vector.task.players}" if vector.task.players > 1 else "continuous=True"
        raise ValueError(f"spread plays games of one player by the indices of actions, got {many}")
    return vector


def _begun(policy: Any, vector: AtariVectorEnv, rng: np.random.Generator) -> LoadedPolicy:
    """The policy, after `begin` for all environments."""
    if len(set(vector.games)) > 1:
        names = ", ".join(dict.fromkeys(game.id for game in vector.games))
        raise ValueError(f"a policy plays one game, and the vector has {names}; leave the policy out")
    loaded = LoadedPolicy(policy)
    seeds = rng.integers(SEED_LIMIT, size=vector.num_envs)
    actions = [action.name for action in vector.options.actions[0]]
    loaded.begin(vector.games[0].id, actions, np.arange(vector.num_envs), seeds)
    return loaded


def _random(vector: AtariVectorEnv, rng: np.random.Generator) -> Choose:
    """Random actions of each environment's game."""
    allowed = vector.options.action_masks()
    if allowed is None:
        allowed = np.ones((vector.num_envs, len(vector.options.actions[0])), np.bool_)
    return lambda _, lanes: (rng.random(allowed[lanes].shape) * allowed[lanes]).argmax(1)


def _moments(
    envs: Any, vector: AtariVectorEnv, policy: LoadedPolicy | None, rng: np.random.Generator, limit: int
) -> list[Any]:
    """A snapshot of each environment at a random moment of the game that it now plays to its end.

    The sample is a reservoir of one: the n-th state of a game replaces the one before with the probability 1 / n.
    """
    choose, mode = policy or _random(vector, rng), vector.autoreset_mode
    moments, (observations, info) = list(envs.snapshot()), vector.observe()
    lanes, frames = np.arange(vector.num_envs), info["episode_frame_number"].copy()
    states, ended = np.ones(vector.num_envs, np.int64), np.zeros(vector.num_envs, np.bool_)
    for _ in range(limit):
        observations, _, terminations, truncations, info = envs.step(choose(observations, lanes), env_id=lanes)
        over, numbers = terminations | truncations, info["episode_frame_number"]
        if mode == AutoresetMode.DISABLED and over.any():
            mask = np.isin(np.arange(vector.num_envs), lanes[over])
            first, info = envs.reset(options={"reset_mask": mask})
            observations, numbers = indexed(first, lanes), info["episode_frame_number"][lanes]
        same_game = numbers >= frames[lanes]
        within = same_game & ~over
        states[lanes] += within
        chosen = lanes[within & (rng.random(len(lanes)) * states[lanes] < 1)].tolist()
        for lane, snapshot in zip(chosen, envs.snapshot(chosen), strict=True):
            moments[lane] = snapshot
        begun = same_game & (ended[lanes] if mode == AutoresetMode.NEXT_STEP else over)
        if policy is not None and begun.any():
            policy.begin_episodes(lanes[begun])
        ended[lanes], frames[lanes] = over, numbers
        observations, lanes = indexed(observations, same_game), lanes[same_game]
        if not lanes.size:
            break
    return moments
