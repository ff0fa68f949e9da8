"""Results of `step` with four values, of Gym's first years, as those with five, and back."""

from typing import Any

import numpy as np

DoneStepType = tuple[Any, Any, Any, Any]
"""Observation, reward, done, info; for a vector arrays, with a list of infos or one dictionary of arrays."""

TerminatedTruncatedStepType = tuple[Any, Any, Any, Any, Any]
"""Observation, reward, terminated, truncated, info."""

_KEY = "TimeLimit.truncated"


def convert_to_terminated_truncated_step_api(step_returns: Any, is_vector_env: bool = False) -> Any:
    """Five values; what is done is truncated if `info["TimeLimit.truncated"]` is true.

    Example:
        >>> from atari.classic.utils.step_api_compatibility import convert_to_terminated_truncated_step_api
        >>> convert_to_terminated_truncated_step_api((0, 1.0, True, {"TimeLimit.truncated": True}))
        (0, 1.0, False, True, {})
    """
    if len(step_returns) == 5:
        return step_returns
    observations, rewards, dones, infos = step_returns
    if not is_vector_env:
        truncated = infos.pop(_KEY, False)
        return observations, rewards, dones and not truncated, dones and truncated, infos
    if isinstance(infos, dict):
        truncated = infos.pop(_KEY, np.zeros(len(dones), np.bool_))
    else:
        truncated = np.array([info.pop(_KEY, False) for info in infos], np.bool_)
    return observations, rewards, dones & ~truncated, dones & truncated, infos


def convert_to_done_step_api(step_returns: Any, is_vector_env: bool = False) -> Any:
    """Four values; at the end of an episode, `info["TimeLimit.truncated"]` says whether it was truncated alone."""
    if len(step_returns) == 4:
        return step_returns
    observations, rewards, terminated, truncated, infos = step_returns
    if not is_vector_env:
        if terminated or truncated:
            infos[_KEY] = truncated and not terminated
        return observations, rewards, terminated or truncated, infos
    dones = np.logical_or(terminated, truncated)
    alone = np.logical_and(truncated, np.logical_not(terminated))
    if isinstance(infos, dict):
        if dones.any():
            infos[_KEY] = alone
    else:
        for lane in np.flatnonzero(dones):
            infos[lane][_KEY] = bool(alone[lane])
    return observations, rewards, dones, infos


def step_api_compatibility(step_returns: Any, output_truncation_bool: bool = True, is_vector_env: bool = False) -> Any:
    """Five values with `output_truncation_bool`, else four."""
    convert = convert_to_terminated_truncated_step_api if output_truncation_bool else convert_to_done_step_api
    return convert(step_returns, is_vector_env)
