"""The memory of the results of a vector environment's batch.

Observations are lent to the user without a copy: each array of observations owns a loan of the memory. When the last
of these arrays, with its views and tensors, no longer exists, the memory can be written again.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

import atari._emulator as _emulator
from atari.base.gymnasium_versions import AutoresetMode
from atari.task import Task
from atari.vector.options import VectorOptions

Bools = npt.NDArray[np.bool_]

_UINT8, _ndarray = np.dtype(np.uint8), np.ndarray  # looked up once, because every step uses them
# The keys of `info`, and the names of the engine's arrays (emulator/vector/batch.def) that they show.
COUNTERS = ("lives", "frame_number", "episode_frame_number")
GAME_INFO = {"reward": "game_reward", "elapsed_step": "elapsed_step", "terminated": "game_over"}


class Results:
    """The arrays of one batch.

    Args:
        engine: the engine that writes them.
        options: its options.
        out: the user's array, or dict of arrays, for the observations.
        steps: the number of rows for each environment.

    Raises:
        TypeError, ValueError: `out` does not fit.
    """

    def __init__(
        self, engine: _emulator.VectorEngine, options: VectorOptions, out: Any = None, *, steps: int = 1
    ) -> None:
        space, rows = options.observation_space(), options.batch_size * steps
        parts = space.spaces if isinstance(space, spaces.Dict) else {"": space}
        self._named = isinstance(space, spaces.Dict)
        self._shape = (rows, *(space.shape or ()))
        self._shapes = shapes = {name: (rows, *(part.shape or ())) for name, part in parts.items()}
        self._observation = _checked(out, shapes) if out is not None else _empty(shapes)
        self._part_names = pixels, ram = options.part_names()
        self.batch = _emulator.Batch(engine, self._observation.get(pixels), self._observation.get(ram), steps)
        self._arrays = arrays = self.batch.arrays
        self._final: dict[str, npt.NDArray[np.uint8]] = {}
        if options.autoreset_mode == AutoresetMode.SAME_STEP:
            written = {pixels: "final_pixels", ram: "final_ram"}
            self._final = {name: arrays[written[name]].reshape(shape) for name, shape in shapes.items()}
        self.of_reset = False
        """Whether the results are those of a reset, which ends no episode; the caller sets it."""
        # Lost lives appear as ends; a player who is out does not.
        ends = ("terminated", "truncated") if options.players == 1 else ("ended",)
        self._ends = [arrays[name] for name in ends if self._final]
        # Methods that copy an array, except the arrays of ended episodes.
        reward = arrays["reward"]
        copy_reward = reward.copy if options.players == 1 else partial(reward.astype, np.float64)
        if options.task.reward is not None:
            copy_reward = arrays["own_reward"].copy
        if options.task.zero_sum:
            copy_reward = partial(zero_sum, reward)
        self._copies = (copy_reward, *(arrays[name].copy for name in (*COUNTERS, "terminated", "truncated")))
        self._game_copies = [arrays[name].copy for name in GAME_INFO.values()] if options.game_info else []
        self._env_id_copy = arrays["env_id"].copy if options.batch_size < len(options.games) else None
        self._all_rows = _read_only(np.ones(rows, np.bool_))
        names = ("env_id", *COUNTERS, *(GAME_INFO if options.game_info else ()))
        self._info = {key: self._all_rows for name in names for key in (name, "_" + name)}
        # Valid for a batch of all environments.
        self._info["env_id"] = _read_only(np.arange(rows, dtype=np.int32) // steps)
        self._apply_layout = None if options.layout.is_engines else options.layout.apply
        # The user's own arrays are returned themselves.
        self._lenders = {} if out is not None else _lenders(self._observation)
        self._final_lenders = _lenders(self._final)
        self._all_lenders = [*self._lenders.values(), *self._final_lenders.values()]

    def aim(self, out: Any) -> None:
        """Write the next observations to another array of the user's, in a tenth of the time that new results need.

        The last results must have been read, and none of their arrays may be lent.

        Raises:
            TypeError, ValueError: `out` does not fit; nothing has changed.
        """
        pixels, ram = self._part_names
        if not self._named and type(out) is _ndarray and out.shape == self._shape:
            try:  # `aimed_at` checks the rest
                self.batch = self.batch.aimed_at(out if pixels == "" else None, out if ram == "" else None)
            except ValueError:
                _checked(out, self._shapes)
                raise
            self._observation = {"": out}
            return
        observation = _checked(out, self._shapes)
        self.batch = self.batch.aimed_at(observation.get(pixels), observation.get(ram))
        self._observation = observation

    def lent(self) -> bool:
        """Whether the user still holds observations in this memory."""
        for lender in self._all_lenders:  # noqa: SIM110, done at every step: a generator takes twice the time
            if lender.lent:
                return True
        return False

    def read(
        self, action_masks: npt.NDArray[np.bool_] | None, ended: bool
    ) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Loans of the observations, and copies of all other arrays; `ended` is the engine's return value."""
        of_reward, of_lives, of_frame, of_episode_frame, of_terminated, of_truncated = self._copies
        info: dict[str, Any] = (
            self._info.copy()
        )  # with all masks; written out without a loop, because every step runs it
        info["lives"], info["frame_number"], info["episode_frame_number"] = of_lives(), of_frame(), of_episode_frame()
        if self._env_id_copy is not None:
            info["env_id"] = self._env_id_copy()
        if self._game_copies:
            of_game_reward, of_game_steps, of_game_over = self._game_copies
            info["reward"], info["elapsed_step"], info["terminated"] = of_game_reward(), of_game_steps(), of_game_over()
        if action_masks is not None:
            info["action_mask"], info["_action_mask"] = action_masks[info["env_id"]], self._all_rows
        if ended:
            self._add_ends(info)
        return self._lend(self._observation, self._lenders), of_reward(), of_terminated(), of_truncated(), info

    def _add_ends(self, info: dict[str, Any]) -> None:
        arrays = self._arrays
        if not self.of_reset and any(array.any() for array in self._ends):
            ended = arrays["ended"].copy()
            final_info: dict[str, Any] = {}
            for name in COUNTERS:
                final_info[name], final_info["_" + name] = arrays["final_" + name].copy(), ended
            info["final_obs"], info["_final_obs"] = self._lend(self._final, self._final_lenders), ended
            info["final_info"], info["_final_info"] = {**final_info, **self._ended_games("final_")}, ended
        if self._game_copies:
            # Without a preset, `RecordEpisodeStatistics` adds this key, as around ale-py's; it must not exist yet.
            info.update(self._ended_games())

    def _ended_games(self, prefix: str = "") -> dict[str, Any]:
        """The statistics of games, as `info` has them; {} if none has ended."""
        names = (prefix + name for name in ("game_ended", "score", "frames", "seconds"))
        ended, score, frames, seconds = (self._arrays[name].copy() for name in names)
        if not ended.any():
            return {}
        episode = {"r": score, "l": frames.astype(np.int64), "t": seconds}
        return {"episode": {**episode, **{f"_{key}": ended for key in "rlt"}}, "_episode": ended}

    def _lend(self, parts: dict[str, npt.NDArray[np.uint8]], lenders: dict[str, Any]) -> Any:
        if self._apply_layout is not None:
            return self._apply_layout(self._lend_as_written(parts, lenders))
        return self._lend_as_written(parts, lenders)

    def _lend_as_written(self, parts: dict[str, npt.NDArray[np.uint8]], lenders: dict[str, Any]) -> Any:
        if not lenders:
            return dict(parts) if self._named else parts[""]
        if not self._named:
            return _ndarray(self._shape, _UINT8, lenders[""].lend())
        return {name: _ndarray(parts[name].shape, _UINT8, lender.lend()) for name, lender in lenders.items()}


_Step = tuple[Any, Any, Any, Any, dict[str, Any]]


class SequenceResults(Results):
    """The arrays of every step of a sequence, each with an axis of the steps after the first."""

    def __init__(self, engine: _emulator.VectorEngine, options: VectorOptions, steps: int) -> None:
        super().__init__(engine, options, steps=steps)
        self._steps = steps

    def read(self, action_masks: npt.NDArray[np.bool_] | None, ended: bool) -> _Step:
        """The arrays of `Results.read`, with the axis of the steps."""
        results: _Step = _map(
            super().read(action_masks, ended), lambda rows: rows.reshape(-1, self._steps, *rows.shape[1:])
        )
        return results


def with_played(results: _Step, played: npt.NDArray[np.int32], ram: npt.NDArray[np.uint8], *, every: bool) -> _Step:
    """The results of a sequence, with the number of steps played, and the RAM after the last step or `every` step."""
    info, all_rows = results[4], np.ones(len(played), np.bool_)
    info |= {"ram": ram, "_ram": all_rows, "steps": played, "_steps": all_rows}
    if every:
        mask = np.arange(ram.shape[1]) < played[:, None]
        info |= {f"_{name}": mask for name in ("env_id", "ram", "action_mask", *COUNTERS, *GAME_INFO) if name in info}
    return results


def pick_rows(results: _Step, rows: npt.NDArray[np.int64]) -> _Step:
    """Copies of some rows of the results of `Results.read`. Ends of other rows are left out of `info`."""
    observation, *signals, info = indexed(results, rows)
    for name in ("final_obs", "final_info", "episode"):
        if f"_{name}" in info and not info[f"_{name}"].any():
            del info[name], info[f"_{name}"]
    reward, terminated, truncated = signals
    return observation, reward, terminated, truncated, info


def indexed(part: Any, index: Any) -> Any:
    """An array at an index, such as a row or rows; a dict or tuple with each of its arrays at the index."""
    return _map(part, lambda array: array[index])


def _map(part: Any, function: Callable[[npt.NDArray[Any]], Any]) -> Any:
    if isinstance(part, dict):
        return {name: _map(value, function) for name, value in part.items()}
    return tuple(_map(value, function) for value in part) if isinstance(part, tuple) else function(part)


def _lenders(parts: dict[str, npt.NDArray[np.uint8]]) -> dict[str, _emulator.ArrayLender]:
    return {name: _emulator.ArrayLender(array) for name, array in parts.items()}


def zero_sum(reward: npt.NDArray[np.number[Any]]) -> npt.NDArray[np.float64]:
    """The rewards (rows, players), each minus the mean of the other players' rewards: one division of integers."""
    players = reward.shape[1]
    return (players * reward - reward.sum(axis=1, keepdims=True)) / (players - 1)


def _read_only(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    array.flags.writeable = False
    return array


def _empty(shapes: dict[str, tuple[int, ...]]) -> dict[str, npt.NDArray[np.uint8]]:
    return {name: np.zeros(shape, np.uint8) for name, shape in shapes.items()}


def _checked(out: Any, shapes: dict[str, tuple[int, ...]]) -> dict[str, npt.NDArray[np.uint8]]:
    parts = dict(out) if isinstance(out, dict) else {"": out}
    if parts.keys() != shapes.keys():
        raise TypeError(f"out must be {'a dict of ' + ' and '.join(shapes) if '' not in shapes else 'an array'}")
    for name, shape in shapes.items():
        array = parts[name]
        good = isinstance(array, _ndarray) and array.dtype == _UINT8 and array.shape == shape
        if not (good and (flags := array.flags).c_contiguous and flags.writeable):
            raise ValueError(f"out must be a writable C-contiguous uint8 array of shape {shape}")
    return parts


def ends_of_stacks(task: Task, terminations: Bools, truncations: Bools, info: Mapping[str, Any]) -> Bools:
    """The lanes in which a step ended a stack of images.

    Args:
        task: without `new_stack_after_life`, the vector must have `game_info`.
        terminations, truncations: results of the step, (num_envs,).
        info: the `info` of the step; with SAME_STEP its "final_info".
    """
    ended: Bools = terminations | truncations
    if task.new_stack_after_life:
        return ended
    return truncations | (ended & info.get("_episode", False))
