"""What several wrappers ask of the environment beneath them, checked when they are put around it."""

from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from atari.actions import Action
from atari.env import AtariEnv

Environment = gymnasium.Env[Any, Any]

# Where known environments and wrappers keep the number of frames they play a step: ale-py's and our AtariEnv,
# Gymnasium's AtariPreprocessing and ours, its RepeatAction, its MaxAndSkipObservation and Stable-Baselines3's. (In its
# StickyAction, `num_repeats` is something else, and 0.)
_SKIP_ATTRIBUTES = ("_frameskip", "frame_skip", "num_repeats", "_skip")


def layers(env: Environment) -> Iterator[Environment]:
    """The environment and all it wraps, from the outside in."""
    while isinstance(env, gymnasium.Wrapper):
        yield env
        env = env.env
    yield env


def require_atari(env: Environment, wrapper: str) -> AtariEnv:
    """The `AtariEnv` under `env`.

    Raises:
        TypeError: it is another environment.
    """
    if not isinstance(env.unwrapped, AtariEnv):
        raise TypeError(f"{wrapper} reads the emulator of an atari.AtariEnv, got {env}; make one with atari.make()")
    return env.unwrapped


def require_pixels(env: Environment, wrapper: str) -> tuple[int, ...]:
    """The shape of the observations, (rows, columns) or (rows, columns, colours) of uint8.

    Raises:
        ValueError: the observations are no pictures.
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


def require_single_frames(env: Environment, wrapper: str) -> None:
    """Refuse to skip frames twice.

    Raises:
        ValueError: the environment, or a wrapper around it, already plays several frames a step.
    """
    for layer in layers(env):
        for name in _SKIP_ATTRIBUTES:
            skip = vars(layer).get(name, 1)
            if skip not in (0, 1):
                raise ValueError(
                    f"{wrapper} skips frames, but {type(layer).__name__} beneath it already plays {skip} a step, so "
                    "that both together would skip too many; make the environment with frameskip=1 or from a "
                    "NoFrameskip ID, and use one wrapper that skips"
                )


def has_noop(env: Environment) -> bool:
    """Whether doing nothing is one of the actions: not in the minimal sets of Backgammon and Video Checkers."""
    return not isinstance(env.action_space, spaces.Discrete) or "NOOP" in env.get_wrapper_attr("get_action_meanings")()


def noop_action(env: Environment) -> Any:
    """The action that does nothing: index 0, or the stick at rest of a continuous action space."""
    return 0 if isinstance(env.action_space, spaces.Discrete) else np.zeros(3, np.float32)


def step_noop(env: Environment) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
    """A step of doing nothing; where that is no action, the emulator is told directly, for a frame."""
    if has_noop(env):
        return env.step(noop_action(env))
    atari = require_atari(env, "a NOOP")
    reward = atari.play_frames(Action.NOOP, 1)
    return atari._observation(), reward, atari.core.game_over, atari.core.truncated, atari._info()
