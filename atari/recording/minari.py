"""`to_minari`: recorded episodes as a dataset of Minari, the Farama Foundation's format for offline learning.

A replay has no observations; playing it again produces them. A dataset has the environment's results to the byte,
because Minari's JPEG encoding is off.
"""

import json
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.envs.registration import EnvSpec, WrapperSpec

from atari.base import durable
from atari.base.extras import import_extra, install_extra
from atari.base.writer_process import write_apart
from atari.env.env import ObsType
from atari.recording.episodes import (
    DatasetObsType,
    EpisodeArrays,
    Source,
    changed_options,
    facts_of_replays,
    load_replays,
    replay_env,
    replayed_episodes,
)
from atari.recording.replay.replay import Replay
from atari.task.env_ids import stem

NO_STEPS = "the replays have no steps of an environment; record with RecordReplay as the outermost wrapper"


def to_minari(
    replays: Source | Iterable[Source],
    dataset_id: str,
    *,
    obs_type: DatasetObsType | None = None,
    core: str = "native",
    **metadata: Any,
) -> Any:
    """Write the episodes of replays as a Minari dataset, and return it (a `minari.MinariDataset`).

    Its metadata have, as JSON, the `task` that was played, the `core_seeds` and the `package`, as `Replay.facts`.

    An episode has n actions, rewards (float), terminations, truncations, and n + 1 observations and infos (`lives`,
    `episode_frame_number`, `frame_number`), as `AtariEnv` returned them. The data does not include the effects of
    wrappers: rewards are not clipped, observations are the environment's own, actions are numbers in its action space.
    Frames that wrappers play before an episode's first step (no-ops) are left out. Frames that wrappers play between
    two steps count to the later step. As in Minari's collector, the last step of an unfinished episode is truncated,
    and an episode without steps is left out. A restored snapshot begins a new episode.

    Args:
        replays: `Replay`s or files, of one game with the same options.
        dataset_id: Minari's name of the dataset, such as "atari/breakout/human-v0". It must not exist.
        obs_type: "rgb", "grayscale", "ram", or "dict": {"image": pixels, "ram": (128,)}, as from
            `atari.wrappers.RamObservation`, which the dataset's environment has; None keeps the recorded one.
        core: the core to play the replays on.
        **metadata: passed to `minari.create_dataset_from_buffers`: `author`, `author_email`, `algorithm_name`,
            `code_permalink`, `description`, `data_format`, ...

    Raises:
        ValueError: there are no replays, they differ in game or options, or have no steps; or the dataset exists.
        OSError: the dataset cannot be written, for example because the disk is full; nothing of it stays.
        gymnasium.error.DependencyNotInstalled: Minari is not installed.

    Example:
        >>> import atari
        >>> from atari.recording import RecordReplay, to_minari
        >>> env = RecordReplay(atari.AtariEnv("pong"), "game.a26r")
        >>> observation, info = env.reset(seed=0)
        >>> for _ in range(10):
        ...     observation = env.step(2)[0]
        >>> env.close()
        >>> dataset = to_minari("game.a26r", "atari/pong/example-v0", author="me")  # doctest: +SKIP
        >>> dataset.total_steps  # doctest: +SKIP
        10
    """
    import_minari()
    loaded = load_replays(replays)
    episodes = replayed_episodes(loaded, obs_type, core)
    facts = {name: json.dumps(value) for name, value in facts_of_replays(loaded).items()}
    return write_minari(episodes, dataset_id, loaded[0], obs_type, core=core, facts=facts, options=metadata)


def write_minari(
    episodes: Iterator[EpisodeArrays],
    dataset_id: str,
    replay: Replay,
    obs_type: DatasetObsType | None,
    *,
    core: str = "native",
    image: ObsType | None = None,
    facts: Mapping[str, str],
    options: Mapping[str, Any] | None = None,
) -> Any:
    """Write the episodes of replays as `to_minari` does, and return the dataset.

    Args:
        episodes: the episodes.
        dataset_id: the name.
        replay: one of the replays.
        obs_type, core, image: see `replay_env`.
        facts: added to the metadata.
        options: passed to `minari.create_dataset_from_buffers`.
    """
    minari = import_minari()
    check_new_dataset(minari, dataset_id)
    first = next(episodes, None)
    if first is None:
        raise ValueError(NO_STEPS)
    with replay_env(replay, obs_type, core, image) as env:
        own = {"observation_space": _space(first.observations), "action_space": env.action_space}
    made = {"env": _spec(replay, obs_type, image), **own, "jpeg_encoding": False, **(options or {})}
    root = minari.storage.datasets_root_dir.get_dataset_path("")
    with (
        durable.naming(root / dataset_id),
        # The dataset gets its name when it is complete: Minari's lists leave out names that begin with a dot.
        TemporaryDirectory(prefix=".", suffix=".part", dir=root, ignore_cleanup_errors=True) as folder,
    ):
        arguments = {"folder": folder, "dataset_id": dataset_id, "options": made, "facts": dict(facts)}
        write_apart("minari", arguments, (vars(episode) for episode in chain([first], episodes)))
        _move(Path(folder), root)
    return minari.load_dataset(dataset_id)


def _space(observations: Any) -> spaces.Space[Any]:
    """The space of the observations in arrays (n + 1, ...) uint8, or in a dict of them."""
    if isinstance(observations, dict):
        return spaces.Dict({name: _space(rows) for name, rows in observations.items()})
    return spaces.Box(0, 255, observations.shape[1:], np.uint8)


def _move(source: Path, target: Path) -> None:
    """Move what is in a folder into another one, whose own files stay."""
    for entry in source.iterdir():
        if not (target / entry.name).exists():
            entry.rename(target / entry.name)
        elif entry.is_dir():
            _move(entry, target / entry.name)


def _spec(replay: Replay, obs_type: DatasetObsType | None, image: ObsType | None) -> EnvSpec:
    """Return the specification of the environment, for `recover_environment` of the dataset.

    Its frame skip is the task's, also if a wrapper played the skip around an environment of single frames.
    """
    env_id = replay.header.get("id") or f"ALE/{stem(replay.game.id)}-v5"
    dict_wrapper = WrapperSpec("RamObservation", "atari.wrappers.ram_observation:RamObservation", {})
    return EnvSpec(
        id=env_id,
        entry_point="atari.env:AtariEnv",
        kwargs={
            "game": replay.game.id,
            **replay.options,
            **changed_options(replay, obs_type, image),
            "frameskip": replay.task.frameskip,
        },
        additional_wrappers=(dict_wrapper,) if obs_type == "dict" else (),
    )


def check_new_dataset(minari: Any, dataset_id: str) -> None:
    """Raise ValueError if a dataset has this name."""
    if dataset_id in minari.list_local_datasets():
        raise ValueError(
            f"there is a dataset {dataset_id!r} already; delete it with minari.delete_dataset, or choose another name"
        )


def import_minari() -> Any:
    """Return the module, or raise as `import_extra`, also without the packages that it needs for its files."""
    need = f"a Minari dataset needs Minari: {install_extra('minari')}"
    import_extra("h5py", need)  # Minari keeps its data with it
    import_extra("PIL", need)  # Minari needs it but does not depend on it
    return import_extra("minari", need)
