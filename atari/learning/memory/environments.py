"""The options of a `ReplayMemory` that a vector environment decides."""

from typing import Any

import numpy as np
from gymnasium import spaces

from atari.base.gymnasium_versions import AutoresetMode
from atari.vector import AtariVectorEnv
from atari.vector.env import vector_of


def options_for(envs: Any, num_envs: int | None = None) -> dict[str, Any]:
    """The number of environments, shapes, and autoreset mode; from an `AtariVectorEnv` also the padding.

    Raises:
        TypeError, ValueError: see `ReplayMemory.for_env`.
    """
    made = vector_of(envs, num_envs, {})
    stack_num, stacks_ram, padding = 4, False, {}
    if made is not envs:
        stack_num, stacks_ram = made.task.stack_num or 1, not made.task.kind.image
        padding = {"padding": made.task.padding}
        made = AtariVectorEnv(made.task.replace(stack_num=None if stacks_ram else 1), made.num_envs)
    envs = made
    observation, action = envs.single_observation_space, envs.single_action_space
    parts = observation.spaces if isinstance(observation, spaces.Dict) else {"": observation}
    for name, part in parts.items():
        if not isinstance(part, spaces.Box) or part.dtype != np.uint8:
            raise TypeError(f"a ReplayMemory stores observations of uint8, and these are {part} {name}".rstrip())
    if not isinstance(action, (spaces.Discrete, spaces.Box, spaces.MultiDiscrete, spaces.MultiBinary)):
        raise TypeError(f"a ReplayMemory stores actions that are arrays, and these are {action}")
    shapes = {name: tuple(part.shape or ()) for name, part in parts.items()}
    stacks = {name: stack_num if stacks_ram or len(shape) >= 2 else 1 for name, shape in shapes.items()}
    options = {
        "num_envs": envs.num_envs,
        "observation_shape": shapes if isinstance(observation, spaces.Dict) else shapes[""],
        "stack_num": stacks,
        "autoreset_mode": envs.metadata.get("autoreset_mode", AutoresetMode.NEXT_STEP),
        "action_shape": tuple(action.shape or ()),
        "action_dtype": action.dtype,
    }
    unwrapped = getattr(envs, "unwrapped", envs)
    return {**options, **_atari_options(unwrapped), **padding} if isinstance(unwrapped, AtariVectorEnv) else options


def _atari_options(envs: AtariVectorEnv) -> dict[str, Any]:
    task = envs.task
    single = 1 if task.kind.image else None
    if task.stack_num != single:
        raise ValueError(
            f"a ReplayMemory makes the stacks: make the environments with stack_num={single}, not {task.stack_num}"
        )
    if not envs.options.layout.is_engines:
        raise ValueError("a ReplayMemory stores what the engine writes: leave channels_last and dtype out")
    if envs.batch_size != envs.num_envs:
        raise ValueError("a ReplayMemory stores steps of all environments: leave batch_size out")
    if task.life_loss_info or task.seamless_lives:
        raise ValueError(
            "a ReplayMemory begins a stack anew after each end: it does not serve life_loss_info, "
            "nor episodic_life of a preset whose stack goes on after a lost life"
        )
    return {"padding": task.padding}
