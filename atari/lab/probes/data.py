"""The states of a probe: episodes of observations and RAM, split into training, validation and test."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.base.validation import check_integer, check_probability
from atari.cores import ByteArray
from atari.games.catalog import games
from atari.lab import atari_ari
from atari.lab.labels import byte_index
from atari.task import Task
from atari.task.observation_kinds import KINDS, with_image
from atari.task.resolution import is_id
from atari.task.task import GameLike
from atari.vector import AtariVectorEnv
from atari.vector.results import ends_of_stacks

Policy = Callable[[Any, npt.NDArray[np.int64]], Any]

TRAINING_SHARE, VALIDATION_SHARE = 0.7, 0.1
MIN_LENGTH = 64
ENTROPY = 0.6


@dataclass(frozen=True)
class EpisodeStates:
    """The states of an episode: `observations` (t, ...) uint8 and `ram` (t, 128) uint8; `task` was played."""

    observations: ByteArray
    ram: ByteArray
    task: Task | None = None


@dataclass(frozen=True)
class Split:
    """States: `observations` (n, ...) uint8 and `labels` (n, number of labels) uint8."""

    observations: ByteArray
    labels: ByteArray

    def __len__(self) -> int:
        return len(self.labels)


@dataclass(frozen=True)
class ProbeData:
    """The three splits.

    `names` are the remaining labels, `entropies` has all labels, in nats. `duplicates` is the number of test states
    that were removed because training or validation has the same observation.
    """

    train: Split
    validation: Split
    test: Split
    names: tuple[str, ...]
    entropies: Mapping[str, float]
    duplicates: int


def play_episodes(
    game: GameLike,
    steps: int,
    policy: Policy | None = None,
    *,
    seed: int = 0,
    epsilon: float = 0.2,
    num_envs: int = 8,
    **options: Any,
) -> list[EpisodeStates]:
    """Play a game and return the states of its episodes, the unfinished ones too.

    Args:
        game: an ID, a game's name, the path of a game file, a `Game` or an `atari.Task`.
        steps: number of steps of all lanes together; each is a state.
        policy: a function of images (num_envs, ...) and the numbers of the lanes that returns actions (num_envs,), such
            as `atari.learning.load_policy` returns; None is random. If it has `begin` and `begin_episodes`, they are
            called as `atari.learning.Policy` describes.
        seed: seed of the lanes and the random actions.
        epsilon: probability of a random action instead of the policy's.
        num_envs: number of lanes that are played together.
        **options: options of `AtariVectorEnv`. Without any, a game that is no ID and no task has AtariARI's
            observations: one grayscale frame (1, 210, 160). Encoders may need other sizes and stacks.

    Returns:
        A list of `EpisodeStates`, with `observations` (t, ...) uint8, `ram` (t, 128) uint8 and the `task`.

    Raises:
        TypeError, ValueError: as `AtariVectorEnv`; or a number is out of range.

    Example:
        >>> from atari.lab.probes import play_episodes
        >>> episodes = play_episodes("breakout", 400, img_height=42, img_width=42, stack_num=1)
        >>> episodes[0].observations.shape[1:], episodes[0].ram.shape[1:]
        ((1, 42, 42), (128,))
    """
    check_integer("steps", steps, 1, 2**40)
    check_probability("epsilon", epsilon)
    if policy is not None and not callable(policy):
        raise TypeError(f"policy must be a function; atari.learning.load_policy returns one, got {policy!r:.80}")
    kind = with_image(gray=True, ram=True)
    if isinstance(game, str) and is_id(game):
        game = Task.of(game)
    if isinstance(game, Task):
        kind = with_image(gray=not game.kind.colours, ram=True)
    elif not options:
        options = {"img_height": None, "img_width": None, "stack_num": 1}
    envs = AtariVectorEnv(game, num_envs, **{"num_threads": 1, "game_info": True, "obs_type": kind, **options})
    if not envs.task.kind.is_dict:
        dicts = " or ".join(repr(name) for name in KINDS if KINDS[name].is_dict)
        raise ValueError(f"the states of a probe are images and RAM, {dicts}, not {envs.task.obs_type!r}")
    generator = np.random.default_rng(seed)
    lanes = np.arange(num_envs)
    parts: list[list[tuple[ByteArray, ByteArray]]] = [[] for _ in lanes]
    episodes: list[EpisodeStates] = []
    try:
        observation, _ = envs.reset(seed=seed)
        # NEXT_STEP: the step after an end begins the next episode, and perhaps a new stack.
        begins = ended = renewed = stacks_ended = np.zeros(num_envs, np.bool_)
        begin, begin_episodes = getattr(policy, "begin", None), getattr(policy, "begin_episodes", None)
        if begin is not None:
            names = [action.name for action in envs.task.action_set]
            seeds = np.random.SeedSequence(seed).generate_state(num_envs).astype(np.int64)
            begin(envs.task.game, names, lanes, seeds)
        for step in range(0, steps, num_envs):
            if begin_episodes is not None and renewed.any():
                begin_episodes(lanes[renewed])
            for lane in lanes[: steps - step]:
                if begins[lane]:
                    episodes.append(_stacked(parts[lane], envs.task))
                    parts[lane] = []
                parts[lane].append((observation["image"][lane].copy(), observation["ram"][lane].copy()))
            actions = generator.integers(envs.single_action_space.n, size=num_envs)
            if policy is not None:
                chosen = np.asarray(policy(observation["image"], lanes))
                actions = np.where(generator.random(num_envs) < epsilon, actions, chosen)
            observation, _, terminated, truncated, info = envs.step(actions)
            begins, ended = ended, terminated | truncated
            renewed, stacks_ended = stacks_ended, ends_of_stacks(envs.task, terminated, truncated, info)
    finally:
        envs.close()
    return episodes + [_stacked(part, envs.task) for part in parts if part]


def split_episodes(
    episodes: Sequence[EpisodeStates],
    labels: Mapping[str, int] | str,
    *,
    entropy: float = ENTROPY,
    min_length: int = MIN_LENGTH,
    seed: int = 0,
) -> ProbeData:
    """Split episodes as AtariARI does: 70 % of them are for training, 10 % for validation, 20 % for the test.

    Episodes of `min_length` states or fewer are left out, and labels whose bytes have a low entropy. Test states that
    training or validation also has, with the same observation, are removed.

    Args:
        episodes: enough for three splits that are not empty, at least four.
        labels: the place in RAM of each label; or the id of the episodes' game, for AtariARI's labels of it.
        entropy: the least entropy of a label over all states, in nats.
        min_length: longest length of the episodes that are left out.
        seed: seed for the order of the episodes.

    Returns:
        A `ProbeData`: `train`, `validation` and `test`, each with `observations` (n, ...) uint8 and `labels` (n, number
        of labels) uint8; the `names` of the labels; `entropies` of all labels, in nats; and `duplicates`, the number of
        test states that were removed.

    Raises:
        TypeError, ValueError: there are too few episodes for three splits, a label has no place in RAM, AtariARI does
            not have the game, no label has the entropy, or no test state is left.

    Example:
        >>> from atari.lab.probes import play_episodes, split_episodes
        >>> episodes = play_episodes("breakout", 3000, img_height=21, img_width=21, stack_num=1)
        >>> data = split_episodes(episodes, "breakout")
        >>> data.names[:2]
        ('ball_x', 'ball_y')
    """
    for episode in episodes:
        if not isinstance(episode, EpisodeStates):
            raise TypeError(f"episodes are what play_episodes returns, got {episode!r:.80}")
    if isinstance(labels, str):
        game = games.find(labels)
        others = {episode.task.game for episode in episodes if episode.task is not None} - {game.id}
        if others:
            raise ValueError(f"the labels are of {game.id}, and the episodes of {', '.join(sorted(others))}")
        labels = atari_ari.indices(game)
    elif not isinstance(labels, Mapping):
        raise TypeError(f"labels must be a game's id, or places in RAM such as {{'ball_x': 99}}, got {labels!r:.80}")
    places = {name: byte_index(index) for name, index in labels.items()}
    long = [episode for episode in episodes if len(episode.ram) > min_length]
    order = np.random.default_rng(seed).permutation(len(long))
    first, second = int(TRAINING_SHARE * len(long)), int((TRAINING_SHARE + VALIDATION_SHARE) * len(long) + 1e-9)
    if not 0 < first < second < len(long):
        raise ValueError(
            f"there are {len(long)} episodes of more than {min_length} states, too few for training, validation and "
            "test; play more steps"
        )
    ram = np.concatenate([episode.ram for episode in long])
    entropies = {name: _entropy(ram[:, index]) for name, index in places.items()}
    names = tuple(name for name in places if entropies[name] >= entropy)
    if not names:
        raise ValueError(f"no label has an entropy of {entropy} nats; play more steps, or lower entropy=")
    columns = [places[name] for name in names]
    parts = [[long[number] for number in part] for part in np.split(order, [first, second])]
    train, validation, test = (_join(part, columns) for part in parts)
    known = {_digest(row) for split in (train, validation) for row in split.observations}
    new = np.array([_digest(row) not in known for row in test.observations])
    if not new.any():
        raise ValueError("training or validation has all states of the test; play more steps")
    left = Split(test.observations[new], test.labels[new])
    return ProbeData(train, validation, left, names, entropies, int((~new).sum()))


def check_data(data: Any) -> None:
    """Refuse what is not a `ProbeData`.

    Raises:
        TypeError: it is something else.
    """
    if not isinstance(data, ProbeData):
        raise TypeError(f"data must be a ProbeData, as split_episodes returns, got {data!r:.80}")


def _stacked(rows: list[tuple[ByteArray, ByteArray]], task: Task) -> EpisodeStates:
    observations, rams = zip(*rows, strict=True)
    return EpisodeStates(np.stack(observations), np.stack(rams), task)


def _join(episodes: Sequence[EpisodeStates], columns: Sequence[int]) -> Split:
    observations = np.concatenate([episode.observations for episode in episodes])
    return Split(observations, np.concatenate([episode.ram[:, columns] for episode in episodes]))


def _entropy(values: ByteArray) -> float:
    shares = np.bincount(values) / len(values)
    shares = shares[shares > 0]
    return float(-(shares * np.log(shares)).sum())


def _digest(row: ByteArray) -> bytes:
    return hashlib.blake2b(row.tobytes(), digest_size=16).digest()
