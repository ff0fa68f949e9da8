"""The episodes of replays, played again, as arrays: the results of `AtariEnv` at each step, or what an agent saw."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import groupby
from os import PathLike
from typing import Any, Literal, TypeAlias

import gymnasium
import numpy as np
import numpy.typing as npt

from atari.env.env import AtariEnv, ObsType
from atari.games.actions import Action
from atari.recording.replay.events import Event, Kind
from atari.recording.replay.observations import JUMPS, State, Tape, check_observable
from atari.recording.replay.replay import Replay
from atari.recording.stacks import Stacking, stacking_of
from atari.task import Task
from atari.wrappers import RamObservation

Source: TypeAlias = Replay | str | PathLike[str]
DatasetObsType: TypeAlias = ObsType | Literal["dict"]


@dataclass(frozen=True)
class EpisodeArrays:
    """One episode of n steps.

    `observations` is an array with n + 1 rows or a dict of such arrays, `infos` a dict of such arrays. `actions`,
    `rewards` (float64), `terminations` and `truncations` (bool) have n rows. The last step of an unfinished episode is
    truncated.
    """

    observations: Any
    actions: npt.NDArray[Any]
    rewards: npt.NDArray[np.float64]
    terminations: npt.NDArray[np.bool_]
    truncations: npt.NDArray[np.bool_]
    infos: dict[str, Any]


def load_replays(replays: Source | Iterable[Source]) -> list[Replay]:
    """The replays of a dataset.

    Raises:
        ValueError: there is no replay, or their tasks differ; or as `Replay.load`.
        FileNotFoundError: as `Replay.load`.
    """
    sources = [replays] if isinstance(replays, (Replay, str, PathLike)) else list(replays)
    loaded = [source if isinstance(source, Replay) else Replay.load(source) for source in sources]
    if not loaded:
        raise ValueError("a dataset needs at least one replay")
    first = loaded[0]
    for replay in loaded[1:]:
        if difference := _difference(first, replay):
            raise ValueError(f"a data set has one task; {first.path} and {replay.path} differ in {difference}")
    return loaded


def _difference(first: Replay, other: Replay) -> str:
    """The fields in which the tasks of two replays differ; "" if none."""
    if first.game != other.game:
        return f"game: {first.game.id} and {other.game.id}"
    pairs = first.task.differences(other.task)
    return "; ".join(f"{name}: {mine!r} and {theirs!r}" for name, (mine, theirs) in pairs.items())


def facts_of_replays(replays: list[Replay]) -> dict[str, Any]:
    """The metadata of a data set of replays: as `Replay.facts`, with the seeds and the interventions of all."""
    on = sorted({name for replay in replays for name in replay.switched_on})
    seeds = [seed for replay in replays for seed in replay.seeds]
    return {**replays[0].facts, **({"switched_on": on} if on else {}), "core_seeds": seeds}


def replay_env(
    replay: Replay, obs_type: DatasetObsType | None, core: str = "native", image: ObsType | None = None
) -> gymnasium.Env[Any, Any]:
    """The environment whose observations a dataset has; its `unwrapped` is an `AtariEnv`.

    "dict" is an image and the RAM, as from `RamObservation`. `image` is "rgb" or "grayscale"; None is the recorded
    environment's kind of image, or "rgb" if it had RAM alone.

    Raises:
        TypeError, ValueError: as `Replay.make_env`.
    """
    env = replay.make_env(core=core, **changed_options(replay, obs_type, image))
    return RamObservation(env) if obs_type == "dict" else env


def replayed_episodes(
    replays: Iterable[Replay],
    obs_type: DatasetObsType | None = None,
    core: str = "native",
    image: ObsType | None = None,
) -> Iterator[EpisodeArrays]:
    """Yield the episodes that have steps; only one is in memory. `replay_env` documents the arguments."""
    for replay in replays:
        env = replay_env(replay, obs_type, core, image)
        try:
            yield from _of_replay(replay, env)
        finally:
            env.close()


def check_seen(task: Task) -> None:
    """Refuse a task whose observations a data set with one frame of each state does not hold.

    Raises:
        ValueError: observations are dicts, have sound or a drawn delay, or actions are delayed.
    """
    screens = 'write the screens: observations="screen" (--observations screen)'
    if task.kind.is_dict:
        raise ValueError(
            f"obs_type={task.obs_type!r} shows dicts of image and RAM, and a data set of what the agent saw has one "
            f"array; {screens}, beside which the RAM is stored"
        )
    if task.action_delay not in (0, (0, 0)):
        raise ValueError(
            f"action_delay={task.action_delay} lets actions arrive after the steps in which an agent chose them, and a "
            f"replay has them where they arrived; {screens}"
        )
    check_observable(task, own=True)


def seen_episodes(replays: Iterable[Replay], core: str = "native") -> Iterator[EpisodeArrays]:
    """Yield the episodes that have steps, with what the agent of the recorded task saw; only one is in memory.

    `observations` has the newest "image" of each state, (n + 1, ...), or the newest RAM vector if the agent sees RAM;
    and the "ram" of the machine, (n + 1, 128). `infos` has "stack" too, (n + 1,) uint8, see `Stacking`.

    Raises:
        ValueError: see `Replay.observations`; or a stack does not follow from its newest frame.
    """
    for replay in replays:
        observed = replay.observed(core=core)
        try:
            for _, states in groupby(observed.states(), key=lambda state: state.episode):
                yield _seen_arrays(replay.task, observed.tape, states)
        finally:
            observed.tape.close()


def _seen_arrays(task: Task, tape: Tape, states: Iterator[State]) -> EpisodeArrays:
    images, rams, infos, steps = [], [], [], []
    before = None
    for state in states:
        if task.stack_num is None:
            stack, stacking = state.observation[None], Stacking.BEGUN if state.begins else Stacking.ADDED
        else:
            stack = state.observation
            stacking = stacking_of(before, stack, state.begins, task.padding)
        before = stack
        images.append(stack[-1])
        rams.append(tape.ram())
        frames = {name: int(getattr(tape, name)) for name in ("lives", "episode_frame_number", "frame_number")}
        infos.append({**frames, "stack": np.uint8(stacking)})
        steps.append((state.action, state.reward, state.terminated, state.truncated))
    actions, rewards, terminations, truncations = zip(*steps[1:], strict=True)
    if not task.continuous:
        actions = tuple(task.action_set.index(Action(action)) for action in actions)
    return EpisodeArrays(
        observations={"image": np.array(images), "ram": np.array(rams)},
        actions=np.array(actions, np.float32 if task.continuous else np.int64),
        rewards=np.array(rewards, np.float64),
        terminations=np.array(terminations, np.bool_),
        truncations=np.array([*truncations[:-1], truncations[-1] or not terminations[-1]], np.bool_),
        infos=_columns(infos),
    )


def changed_options(replay: Replay, obs_type: DatasetObsType | None, image: ObsType | None) -> dict[str, Any]:
    """The options in which the `AtariEnv` of `replay_env` differs from the recorded one."""
    if obs_type == "dict":
        obs_type = image or ("rgb" if replay.options.get("obs_type") == "ram" else None)
    return {} if obs_type is None else {"obs_type": obs_type}


@dataclass
class _EpisodeSteps:
    """The collected steps of one episode."""

    env: gymnasium.Env[Any, Any]
    observations: list[Any] = field(default_factory=list)
    actions: list[Any] = field(default_factory=list)
    rewards: list[float] = field(default_factory=list)
    terminations: list[bool] = field(default_factory=list)
    truncations: list[bool] = field(default_factory=list)
    infos: list[dict[str, int]] = field(default_factory=list)
    reward: float = 0.0
    continuous_action: tuple[float, ...] = ()

    @property
    def atari(self) -> AtariEnv:
        return self.env.unwrapped  # type: ignore[return-value]

    @property
    def over(self) -> bool:
        return bool(self.rewards) and (self.terminations[-1] or self.truncations[-1])

    def see(self) -> None:
        observation = self.atari.observe()
        if isinstance(self.env, RamObservation):
            observation = self.env.observation(observation)
        self.observations.append(observation)
        self.infos.append(self.atari.driver.info())

    def see_first(self) -> None:
        """Drop the frames before the first step, and collect its first observation."""
        self.observations, self.infos, self.reward = [], [], 0.0
        self.see()

    def step(self, event: Event) -> None:
        self.actions.append(_action(self.atari, event, self.continuous_action))
        self.rewards.append(self.reward)
        self.terminations.append(self.atari.core.game_over)
        self.truncations.append(self.atari.core.truncated)
        self.reward = 0.0
        self.see()

    def arrays(self) -> EpisodeArrays:
        return EpisodeArrays(
            observations=_columns(self.observations),
            actions=np.array(self.actions),
            rewards=np.array(self.rewards, np.float64),
            terminations=np.array(self.terminations, np.bool_),
            truncations=np.array([*self.truncations[:-1], self.truncations[-1] or not self.terminations[-1]], np.bool_),
            infos=_columns(self.infos),
        )


def _of_replay(replay: Replay, env: gymnasium.Env[Any, Any]) -> Iterator[EpisodeArrays]:
    episode = _EpisodeSteps(env)
    for event, calls in replay.walk(episode.atari.core):
        if event.kind in JUMPS and episode.rewards:
            yield episode.arrays()
        if event.kind in JUMPS:
            episode = _EpisodeSteps(env)
        if event.ends_step and not episode.rewards:
            episode.see_first()
        episode.reward += sum(call.reward for call in calls)
        if event.kind == Kind.CONTINUOUS_ACTION:
            episode.continuous_action = event.floats
        elif event.ends_step and not episode.over:
            episode.step(event)
    if episode.rewards:
        yield episode.arrays()


def _action(env: AtariEnv, event: Event, continuous_action: tuple[float, ...]) -> Any:
    if env.continuous:
        return np.array(continuous_action, np.float32)
    return np.int64(env.driver.actions.index(Action(event.numbers[0])))


def _columns(rows: list[Any]) -> Any:
    if isinstance(rows[0], dict):
        return {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return np.array(rows)
