"""`to_minari`: recorded episodes as a dataset of Minari, the Farama Foundation's format for offline learning.

A replay has no observations; playing it again produces them. A dataset has the environment's results to the byte,
because Minari's JPEG encoding is off.
"""

import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec

from atari.actions import Action
from atari.env import AtariEnv, ObsType
from atari.recording.replay.events import Event, Kind
from atari.recording.replay.replay import Replay
from atari.registration import stem

Source = Replay | str | PathLike[str]

_JUMPS = (Kind.RESET, Kind.SEED, Kind.RESTORE, Kind.LOAD)


def to_minari(
    replays: Source | Iterable[Source],
    dataset_id: str,
    *,
    obs_type: ObsType | None = None,
    core: str = "native",
    **metadata: Any,
) -> Any:
    """Write the episodes of replays as a Minari dataset, and return it (a `minari.MinariDataset`).

    An episode has n actions, rewards (float), terminations, truncations, and n + 1 observations and infos (`lives`,
    `episode_frame_number`, `frame_number`), as `AtariEnv` returned them. The data does not include the effects of
    wrappers: rewards are not clipped, observations are the environment's own, actions are numbers in its action space.
    Frames that wrappers play before an episode's first step (no-ops) are left out. Frames that wrappers play between
    two steps count to the later step. As in Minari's collector, the last step of an unfinished episode is truncated,
    and an episode without steps is left out. A new episode begins where the game was restored from a snapshot.

    Args:
        replays: `Replay`s or files, of one game with the same options.
        dataset_id: Minari's name of the dataset, such as "atari/breakout/human-v0". It must not exist.
        obs_type: "rgb", "grayscale" or "ram"; None is that of the recorded environment.
        core: the core to play the replays on.
        **metadata: passed to `minari.create_dataset_from_buffers`: `author`, `author_email`, `algorithm_name`,
            `code_permalink`, `description`, `data_format`, ...

    Raises:
        ValueError: there are no replays, they differ in game or options, or have no steps; or the dataset exists.
        gymnasium.error.DependencyNotInstalled: Minari is not installed.
    """
    minari = _import_minari()
    sources = [replays] if isinstance(replays, (Replay, str, PathLike)) else list(replays)
    loaded = [source if isinstance(source, Replay) else Replay.load(source) for source in sources]
    if not loaded:
        raise ValueError("to_minari needs at least one replay")
    for replay in loaded:
        if (replay.game, replay.options) != (loaded[0].game, loaded[0].options):
            raise ValueError(
                f"the replays of a dataset are of one game and the same options; {replay.path} and {loaded[0].path} "
                "differ"
            )
    if dataset_id in minari.list_local_datasets():
        raise ValueError(f"there is a dataset {dataset_id!r} already; delete it with minari.delete_dataset, or rename")
    changes = {} if obs_type is None else {"obs_type": obs_type}
    env = loaded[0].make_env(core=core, **changes)
    episodes = _episodes(loaded, changes, core, minari.data_collector.EpisodeBuffer)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", module="minari")  # it warns of missing metadata
        try:
            first = next(episodes, None)
            if first is None:
                raise ValueError(
                    "the replays have no steps of an environment; record with RecordReplay as the outermost wrapper"
                )
            return minari.create_dataset_from_buffers(
                dataset_id,
                _chain(first, episodes),
                env=_spec(loaded[0], changes),
                observation_space=env.observation_space,
                action_space=env.action_space,
                jpeg_encoding=False,
                **metadata,
            )
        finally:
            env.close()


@dataclass
class _Episode:
    """The collected steps of one episode."""

    observations: list[Any] = field(default_factory=list)
    actions: list[Any] = field(default_factory=list)
    rewards: list[float] = field(default_factory=list)
    terminations: list[bool] = field(default_factory=list)
    truncations: list[bool] = field(default_factory=list)
    infos: list[dict[str, int]] = field(default_factory=list)
    reward: float = 0.0
    continuous_action: tuple[float, ...] = ()

    @property
    def over(self) -> bool:
        return bool(self.rewards) and (self.terminations[-1] or self.truncations[-1])

    def see(self, env: AtariEnv) -> None:
        self.observations.append(env._get_obs())
        self.infos.append(env._info())

    def see_first(self, env: AtariEnv) -> None:
        """Drop what was collected before the first step, and collect its first observation."""
        self.observations, self.infos, self.reward = [], [], 0.0
        self.see(env)

    def step(self, env: AtariEnv, event: Event) -> None:
        self.actions.append(_action(env, event, self.continuous_action))
        self.rewards.append(self.reward)
        self.terminations.append(env.core.game_over)
        self.truncations.append(env.core.truncated)
        self.reward = 0.0
        self.see(env)

    def buffer(self, kind: Any) -> Any:
        """Return Minari's buffer. Observations that are dicts become a dict of arrays."""
        truncations = [*self.truncations[:-1], self.truncations[-1] or not self.terminations[-1]]
        return kind(
            observations=_columns(self.observations),
            actions=np.array(self.actions),
            rewards=self.rewards,
            terminations=self.terminations,
            truncations=truncations,
            infos=_columns(self.infos),
        )


def _episodes(replays: list[Replay], changes: dict[str, Any], core: str, kind: Any) -> Iterator[Any]:
    """Yield the episodes one at a time, so that only one is in memory."""
    for replay in replays:
        env = replay.make_env(core=core, **changes)
        episode = _Episode()
        try:
            for event, calls in replay.walk(env.core):
                if event.kind in _JUMPS and episode.rewards:
                    yield episode.buffer(kind)
                if event.kind in _JUMPS:
                    episode = _Episode()
                if event.ends_step and not episode.rewards:
                    episode.see_first(env)
                episode.reward += sum(call.reward for call in calls)
                if event.kind == Kind.CONTINUOUS_ACTION:
                    episode.continuous_action = event.floats
                elif event.ends_step and not episode.over:
                    episode.step(env, event)
            if episode.rewards:
                yield episode.buffer(kind)
        finally:
            env.close()


def _action(env: AtariEnv, event: Event, continuous_action: tuple[float, ...]) -> Any:
    if env.continuous:
        return np.array(continuous_action, np.float32)
    return np.int64(env._action_set.index(Action(event.numbers[0])))


def _columns(rows: list[Any]) -> Any:
    if isinstance(rows[0], dict):
        return {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return np.array(rows)


def _chain(first: Any, rest: Iterator[Any]) -> Iterator[Any]:
    yield first
    yield from rest


def _spec(replay: Replay, changes: dict[str, Any]) -> EnvSpec:
    """Return the specification of the environment, for `recover_environment` of the dataset."""
    env_id = replay.header.get("id") or f"ALE/{stem(replay.game.id)}-v5"
    return EnvSpec(
        id=env_id, entry_point="atari.env:AtariEnv", kwargs={"game": replay.game.id, **replay.options, **changes}
    )


def _import_minari() -> Any:
    try:
        import h5py  # noqa: F401 - Minari keeps its data with it
        import minari
        import PIL  # noqa: F401 - Minari needs it but does not depend on it
    except ImportError:
        raise gymnasium.error.DependencyNotInstalled(
            "a Minari dataset needs Minari: pip install 'atari-envs[minari]'"
        ) from None
    return minari
