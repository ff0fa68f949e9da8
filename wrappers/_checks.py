"""Checks of the wrapped environment that several wrappers make when they are constructed."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from atari.env import AtariEnv
from atari.env.restorable import layers
from atari.games.actions import Action

Environment = gymnasium.Env[Any, Any]

# Attributes with the number of frames a step, in this order: ale-py's and our AtariEnv, Gymnasium's
# AtariPreprocessing and ours, its RepeatAction, its MaxAndSkipObservation and Stable-Baselines3's. (Gymnasium's
# StickyAction has a `num_repeats` with another meaning, which is 0.)
_SKIP_ATTRIBUTES = ("_frameskip", "frame_skip", "num_repeats", "_skip")


def require_atari(env: Environment, wrapper: str) -> AtariEnv:
    """The `AtariEnv` under `env`.

    Raises:
        TypeError: the innermost environment is no `AtariEnv`.
    """
    if not isinstance(env.unwrapped, AtariEnv):
        raise TypeError(f"{wrapper} reads the emulator of an atari.AtariEnv, got {env}; make one with atari.make()")
    return env.unwrapped


def require_pixels(env: Environment, wrapper: str) -> tuple[int, ...]:
    """The shape of the observations, (rows, columns) or (rows, columns, colours) of uint8.

    Raises:
        ValueError: the observations are not images.
    """
    space = env.observation_space
    if isinstance(space, spaces.Box) and space.dtype == np.uint8 and len(space.shape) >= 2:
        colours = space.shape[2:]
        if colours in ((), (1,), (3,)):
            return space.shape
    raise ValueError(
        f"{wrapper} works on pixels, but the observations are {space}; "
        "make the environment with obs_type='rgb' (not 'ram') and sound_obs=False"
    )


def require_image(observation: Any, shape: tuple[int, ...], wrapper: str) -> None:
    """Raise an error if an observation is not of the space that the wrapper was made for.

    Raises:
        TypeError: the observation is no array of uint8.
        ValueError: it has another shape.
    """
    if not isinstance(observation, np.ndarray) or observation.dtype != np.uint8:
        raise TypeError(f"{wrapper} takes images as NumPy arrays of uint8, shape {shape}, got {observation!r:.80}")
    if observation.shape != shape:
        raise ValueError(f"{wrapper} takes images of shape {shape}, got shape {observation.shape}")


def require_single_frames(env: Environment, wrapper: str) -> None:
    """Raise an error if frames would be skipped twice.

    Raises:
        ValueError: the environment, or a wrapper around it, already plays several frames a step.
    """
    for layer in layers(env):
        for name in _SKIP_ATTRIBUTES:
            skip = vars(layer).get(name, 1)
            if skip not in (0, 1):
                raise ValueError(
                    f"{wrapper} skips frames, but {type(layer).__name__} inside it already plays {skip} a step, so "
                    "that both together would skip too many; make the environment with frameskip=1 or from a "
                    "NoFrameskip ID, and use one wrapper that skips"
                )


def has_noop(env: Environment) -> bool:
    """Whether episodes can begin with NOOP, which the minimal sets of Backgammon and Video Checkers lack."""
    return not isinstance(env.action_space, spaces.Discrete) or "NOOP" in begin_meanings(env)


def action_meanings(env: Environment) -> list[str]:
    """The names of the actions, from the outermost wrapper that overrides them."""
    # With Gymnasium 0.29, `env.get_wrapper_attr` warns.
    overriding = (layer for layer in layers(env) if hasattr(type(layer), "get_action_meanings"))
    return next(overriding, env.unwrapped).get_action_meanings()  # type: ignore[attr-defined]


def begin_meanings(env: Environment) -> list[str]:
    """The names of the actions that begin episodes: the game's, if the agent of an `AtariEnv` has only some."""
    meanings, inner = action_meanings(env), env.unwrapped
    if isinstance(inner, AtariEnv) and meanings == inner.get_action_meanings():
        return [action.name for action in inner.task.begin_actions]
    return meanings


def noop_action(env: Environment) -> Any:
    """The NOOP action; in a continuous action space the stick at rest."""
    return action_meanings(env).index("NOOP") if isinstance(env.action_space, spaces.Discrete) else _AT_REST.copy()


_AT_REST = np.zeros(3, np.float32)
_FIRE = np.array([0, 0, 1], np.float32)


def step_named(env: Environment, name: str) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
    """Play a step of an action by name; if the action space is continuous, NOOP or FIRE.

    If the action is not in the action space, the `AtariEnv` plays it in place of the step's action. So it does with
    continuous actions, of which none exceeds a threshold of 1.
    """
    discrete = isinstance(env.action_space, spaces.Discrete)
    meanings = action_meanings(env) if discrete else []
    if name in meanings:
        return env.step(meanings.index(name))
    motion = (_FIRE if name == "FIRE" else _AT_REST).copy()
    if not discrete and not isinstance(env.unwrapped, AtariEnv):
        return env.step(motion)
    driver = require_atari(env, f"a {name}").driver
    driver.replacement = Action[name]
    try:
        return env.step(0 if discrete else motion)
    finally:
        driver.replacement = None


def draw(env: Environment, low: int, high: int) -> int:
    """A number within low..high-1 from the generator of the environment's episodes."""
    inner = env.unwrapped
    return inner.driver.draw(low, high) if isinstance(inner, AtariEnv) else int(inner.np_random.integers(low, high))
