"""A vector environment beside single environments of the same tasks: every byte and every key of `info` is equal.

The single environments and the rules of the three autoreset modes, written here, are the oracle of the vector.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from gymnasium import spaces

import atari
from atari.registry.making import make_env
from atari.task import Task

COUNTERS = ("lives", "frame_number", "episode_frame_number")
DTYPES: Mapping[str, type] = {
    "lives": np.int32,
    "frame_number": np.int32,
    "episode_frame_number": np.int32,
    "reward": np.int32,
    "elapsed_step": np.int32,
    "terminated": np.bool_,
}
"""The dtypes of a vector's `info` for the keys of a single environment's."""
KINDS: Mapping[str, type] = {"reward": float, "terminated": bool}
"""The types of a single environment's `info`, where they are not int."""


@dataclass
class Lane:
    """A single environment, and the row of the vector's results that follows from its results."""

    task: Task
    single: Any
    done: bool = False
    steps: int = 0
    observation: Any = None
    reward: float = 0.0
    ends: tuple[bool, bool] = (False, False)
    info: dict[str, Any] = field(default_factory=dict)
    final: tuple[Any, dict[str, Any]] | None = None

    def begin(self, seed: int | None, **options: Any) -> None:
        """Reset the environment, for the results of a reset."""
        observation, info = self.single.reset(seed=seed, options=options)
        assert ("seeds" in info) == (seed is not None)
        info.pop("seeds", None)
        self.observation, self.info, self.final = observation, self._checked(info), None
        self.reward, self.ends, self.done, self.steps = 0.0, (False, False), False, 0

    def repeat(self) -> None:
        """Show the last results again: the lane is not played."""
        self.reward, self.final = 0.0, None
        self.info = {name: value for name, value in self.info.items() if name != "episode"}
        if "reward" in self.info:
            self.info["reward"] = 0.0

    def play(self, action: Any, same_step: bool) -> None:
        """Step the environment, and with `same_step` reset it after an end."""
        observation, reward, over, cut, info = self.single.step(action)
        self.observation, self.reward, self.info, self.final = observation, reward, self._checked(info), None
        self.steps += 1
        reported = self.task.life_loss_info and over and not self.single.unwrapped.core.game_over
        # ale-py reports a limit that is reached with a lost life as the lost life alone; a single environment reports
        # both, and so does a vector at `max_episode_steps`, which ale-py does not have.
        self.ends = over, cut and (not reported or self.steps >= (self.task.max_episode_steps or self.steps + 1))
        self.done = cut or (over and not reported)
        if not (self.done and same_step):
            return
        ended = {name: self.info[name] for name in COUNTERS}
        if (game := self._ended_game(cut)) is not None:
            ended["episode"] = game
        self.final = observation, ended
        # The counters and a game that ended inside the reset are those of the reset; the others are those of the step.
        kept = {name: value for name, value in self.info.items() if name not in (*COUNTERS, "episode")}
        observation, info = self.single.reset()
        info = self._checked(info)
        self.observation, self.done, self.steps = observation, False, 0
        self.info = {**info, **kept}

    def _ended_game(self, cut: bool) -> dict[str, Any] | None:
        """The statistics of the game that the last step ended. Tasks without wrappers have none in `info`."""
        if self.task.preprocessed:
            return self.info.get("episode")
        driver = self.single.unwrapped.driver
        game = driver.ended
        driver.ended = None
        return game or (driver.played.statistics(driver.core) if cut else None)

    def _checked(self, info: dict[str, Any]) -> dict[str, Any]:
        whole = ("reward", "elapsed_step", "terminated") if self.task.preprocessed else ()
        assert info.keys() - {"episode"} == {*COUNTERS, *whole}, sorted(info)
        assert "episode" not in info or self.task.preprocessed
        for name in (*COUNTERS, *whole):
            assert type(info[name]) is KINDS.get(name, int), f"{name} is {info[name]!r}"
        return info


class Lanes:
    """A vector beside a single environment for each of its lanes; each method plays both and compares all results.

    Args:
        tasks: the task of each lane; they differ in games, modes and difficulties only.
        mode: the autoreset mode.
        singles: the environments, in place of those that the tasks make.
        num_threads: see `AtariVectorEnv`.
    """

    def __init__(
        self, tasks: Sequence[Task], mode: str, singles: Sequence[Any] | None = None, num_threads: int = 1
    ) -> None:
        self.mode = mode
        self.envs = atari.AtariVectorEnv(list(tasks), num_threads=num_threads, autoreset_mode=mode)
        made = [make_env(task) for task in tasks] if singles is None else singles
        self.lanes = [Lane(task, single) for task, single in zip(tasks, made, strict=True)]
        self.ends = 0
        self._saved: Any = None
        self._actions = self.envs.options.actions
        for index, lane in enumerate(self.lanes):
            assert lane.single.observation_space == self.envs.single_observation_space
            assert lane.single.action_space == self.envs.single_action_space or self.envs.options.mixed
            assert self.envs.tasks[index] == lane.task

    @property
    def done(self) -> bool:
        """Whether the episode of some lane has ended, and not begun again."""
        return any(lane.done for lane in self.lanes)

    def reset(self, seed: Any = None, mask: Sequence[bool] | None = None, **options: Any) -> None:
        """Reset both. The k-th lane that is reset gets the seed `seed + k`, or element k of a sequence."""
        chosen = [index for index in range(len(self.lanes)) if mask is None or mask[index]]
        masked = {} if mask is None else {"reset_mask": np.array(mask, np.bool_)}
        observation, info = self.envs.reset(seed=seed, options={**masked, **options})
        for index, lane in enumerate(self.lanes):
            if index not in chosen:
                lane.repeat()
                continue
            lane.begin(_seed_of(seed, chosen.index(index)), **options)
        self._compare(observation, None, info, "reset")

    def observe(self) -> None:
        """Compare what the vector shows without playing."""
        observation, info = self.envs.observe()
        for lane in self.lanes:
            lane.repeat()
        self._compare(observation, None, info, "observe")

    def step(self, actions: Sequence[Any]) -> None:
        """A step of both; row i is an action of the single environment i."""
        rows = [
            self._actions[index].index(lane.task.action_set[action]) if isinstance(action, int) else action
            for index, (lane, action) in enumerate(zip(self.lanes, actions, strict=True))
        ]
        observation, reward, terminated, truncated, info = self.envs.step(np.asarray(rows))
        for lane, action in zip(self.lanes, actions, strict=True):
            if lane.done and self.mode == "Disabled":
                lane.repeat()
            elif lane.done:
                lane.begin(None)
            else:
                lane.play(action, self.mode == "SameStep")
                self.ends += lane.done or lane.final is not None
        self._compare(observation, (reward, terminated, truncated), info, "step")

    def sample(self, generator: np.random.Generator) -> list[Any]:
        """A random action for each lane."""
        return [random_action(lane.single.action_space, generator) for lane in self.lanes]

    def save(self) -> None:
        """Keep the state of both."""
        states = [
            (lane.single.snapshot(), lane.done, lane.steps, lane.observation, lane.info, lane.ends)
            for lane in self.lanes
        ]
        self._saved = self.envs.snapshot(), states

    def restore(self, indices: Iterable[int]) -> None:
        """Return some lanes of both to the last `save`."""
        chosen = list(indices)
        snapshots, states = self._saved
        self.envs.restore(chosen, [snapshots[index] for index in chosen])
        for index in chosen:
            lane = self.lanes[index]
            state, lane.done, lane.steps, lane.observation, lane.info, lane.ends = states[index]
            lane.single.restore(state)

    def close(self) -> None:
        """Close all environments."""
        self.envs.close()
        for lane in self.lanes:
            lane.single.close()

    def _compare(
        self, observation: Any, signals: tuple[Any, Any, Any] | None, info: dict[str, Any], where: str
    ) -> None:
        for index, lane in enumerate(self.lanes):
            _same(observation, index, lane.observation, f"the observation of the {where}")
        if signals is not None:
            reward, terminated, truncated = signals
            own = self.lanes[0].task.reward is not None
            _column(reward, [lane.reward for lane in self.lanes], np.float64 if own else np.int32, "the reward")
            for name, array, number in (("terminated", terminated, 0), ("truncated", truncated, 1)):
                _column(array, [lane.ends[number] for lane in self.lanes], np.bool_, name)
        wanted = {
            "env_id": (list(range(len(self.lanes))), np.int32),
            **{
                name: ([lane.info[name] for lane in self.lanes], dtype)
                for name, dtype in DTYPES.items()
                if name in self.lanes[0].info
            },
        }
        if self.envs.options.mixed and not self.envs.options.task.continuous:
            masks = [[action in lane.task.action_set for action in self._actions[0]] for lane in self.lanes]
            wanted["action_mask"] = masks, np.bool_
        games = [lane.info.get("episode") for lane in self.lanes]
        finals = self.mode == "SameStep" and signals is not None and any(any(lane.ends) for lane in self.lanes)
        _same_keys(info, [*wanted, *["episode"] * any(games), *["final_obs", "final_info"] * finals], where)
        for name, (values, dtype) in wanted.items():
            _column(info[name], values, dtype, f"info[{name!r}] of the {where}")
            _column(info[f"_{name}"], [True] * len(self.lanes), np.bool_, f"info['_{name}'] of the {where}")
        if any(games):
            _same_games(info, games, f"info of the {where}")
        if finals:
            self._compare_finals(info)

    def _compare_finals(self, info: dict[str, Any]) -> None:
        ended = [lane.final is not None for lane in self.lanes]
        finals = info["final_info"]
        for name, array in (("_final_obs", info["_final_obs"]), ("_final_info", info["_final_info"])):
            _column(array, ended, np.bool_, name)
        for index, lane in enumerate(self.lanes):
            shown = _zeros(lane.observation) if lane.final is None else lane.final[0]
            _same(info["final_obs"], index, shown, "final_obs")
        games = [lane.final and lane.final[1].get("episode") for lane in self.lanes]
        _same_keys(finals, [*COUNTERS, *["episode"] * any(games)], "final_info")
        for name in COUNTERS:
            values = [0 if lane.final is None else lane.final[1][name] for lane in self.lanes]
            _column(finals[name], values, np.int32, f"final_info[{name!r}]")
            _column(finals[f"_{name}"], ended, np.bool_, f"final_info['_{name}']")
        if any(games):
            _same_games(finals, games, "final_info")


def random_action(space: spaces.Space[Any], generator: np.random.Generator) -> Any:
    """A random action; of a continuous space often at its ends."""
    if isinstance(space, spaces.Discrete):
        return int(generator.integers(space.n))
    assert isinstance(space, spaces.Box)
    ends = np.where(generator.random(3) < 0.5, space.low, space.high)
    return np.where(generator.random(3) < 0.3, ends, generator.uniform(space.low, space.high)).astype(np.float32)


def _seed_of(seed: Any, number: int) -> int | None:
    """The seed of the lane that is reset as number `number`."""
    if seed is None or isinstance(seed, int):
        return None if seed is None else seed + number
    value = seed[number]
    return None if value is None or value < 0 else int(value)


def _same_keys(info: Mapping[str, Any], keys: Sequence[str], where: str) -> None:
    """Check that `info` has these keys, each with a mask."""
    wanted = {*keys, *(f"_{name}" for name in keys)}
    assert {*info} == wanted, (
        f"info of the {where} lacks {sorted(wanted - {*info})}, and has beside these {sorted({*info} - wanted)}"
    )


def _column(array: Any, values: Sequence[Any], dtype: Any, name: str) -> None:
    """Check the dtype and the values of an array with a row for each lane."""
    assert array.dtype == dtype, f"{name} has the dtype {array.dtype}, not {np.dtype(dtype)}"
    assert array.tolist() == list(values), f"{name} is {array.tolist()}, and of the single environments {values}"


def _same_games(info: dict[str, Any], games: Sequence[dict[str, Any] | None], where: str) -> None:
    """Check the statistics of the games that ended in each lane."""
    ended = [game is not None for game in games]
    _column(info["_episode"], ended, np.bool_, f"_episode in {where}")
    episode = info["episode"]
    assert {*episode} == {"r", "l", "t", "_r", "_l", "_t"}, sorted(episode)
    for name, dtype in (("r", np.float64), ("l", np.int64)):
        values = [0 if game is None else game[name] for game in games]
        _column(episode[name], values, dtype, f"episode[{name!r}] in {where}")
    assert episode["t"].dtype == np.float64
    assert all(math.isfinite(seconds) and seconds >= 0 for seconds in episode["t"].tolist())
    for name in ("_r", "_l", "_t"):
        _column(episode[name], ended, np.bool_, f"episode[{name!r}] in {where}")


def _same(batch: Any, row: int, expected: Any, name: str) -> None:
    """Check that a row of observations is equal to the byte."""
    if isinstance(expected, dict):
        assert batch.keys() == expected.keys(), f"{name} has the parts {sorted(batch)}"
        for part in expected:
            _same(batch[part], row, expected[part], f"{part} of {name}")
        return
    assert batch.dtype == expected.dtype, f"{name} has the dtype {batch.dtype}"
    shown = batch[row]
    assert shown.shape == expected.shape, f"{name} has the shape {shown.shape}, not {expected.shape}"
    if not np.array_equal(shown, expected):
        raise AssertionError(
            f"{int((shown != expected).sum())} of {expected.size} bytes of {name} differ in lane {row}"
        )


def _zeros(observation: Any) -> Any:
    return (
        {part: np.zeros_like(value) for part, value in observation.items()}
        if isinstance(observation, dict)
        else np.zeros_like(observation)
    )
