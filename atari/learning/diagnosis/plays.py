"""`play_games`: the games of an evaluation with every step kept, and the states of their steps, reached again."""

from collections import defaultdict
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from atari.base.validation import check_integer
from atari.env.lane_snapshot import LaneSnapshot
from atari.lab.labels import Labels, labels_of
from atari.learning.evaluation.evaluate import EvaluatedPolicy, _Games, episode_seed
from atari.policy import LoadedPolicy
from atari.policy.needs import needs_of
from atari.policy.watched import WatchedPolicy
from atari.task import Task
from atari.vector import AtariVectorEnv

_MOST_LANES, _MOST_GAMES = 64, 10_000
_BLOCK = 512  # steps

Array = npt.NDArray[Any]
Progress = Callable[[int, int], Any]


@dataclass(frozen=True, eq=False)
class Play:
    """One whole game. Row t of each array of T rows belongs to step t; the state is that after the step.

    Attributes:
        seed: the seed of the game.
        score: the sum of all rewards, not clipped; `rewards` lacks those that a reset pays.
        frames: the length in emulated frames, no-ops included.
        truncated: whether the limit of frames has stopped the game.
        first_lives: the lives before the first step.
        actions: (T,) uint8, indices of the task's `action_set`.
        rewards: (T,) int32, the game's own, not clipped.
        lives: (T,) int16.
        rams: (T, 128) uint8.
        scores: (T, A) float32, the policy's score of each action of the task before the step, such as action values or
            logits; -inf for actions that the policy lacks; None for a policy that gives no scores.
        resets: the steps after which a reset followed within the game, because a life was lost.
    """

    seed: int
    score: float
    frames: int
    truncated: bool
    first_lives: int
    actions: npt.NDArray[np.uint8]
    rewards: npt.NDArray[np.int32]
    lives: npt.NDArray[np.int16]
    rams: npt.NDArray[np.uint8]
    scores: npt.NDArray[np.float32] | None
    resets: tuple[int, ...]

    def __len__(self) -> int:
        """The number of steps."""
        return len(self.actions)

    @cached_property
    def lives_before(self) -> npt.NDArray[np.int16]:
        """The lives before each step, (T,) int16."""
        return np.concatenate(([np.int16(self.first_lives)], self.lives[:-1])).astype(np.int16)

    @cached_property
    def totals(self) -> npt.NDArray[np.int64]:
        """The score of the game after each step, (T,) int64, without rewards that a reset pays."""
        return np.cumsum(self.rewards, dtype=np.int64)


class Place(Protocol):
    """A step of a game, such as a `Moment`."""

    @property
    def play(self) -> int:
        """The number of the game."""

    @property
    def step(self) -> int:
        """The number of the step; the state is that after the step, and -1 is the state before the first one."""


@dataclass(frozen=True, eq=False)
class Plays(Sequence[Play]):
    """The games of a policy, in their order, see `play_games`.

    Attributes:
        task: the task that was played.
        actions: the names of its actions.
        labels: all labels of its game; `labels.names` is empty for a game without labels.
        epsilon: the probability of a random action.
        seed: the seed of the whole.
        policy: the policy, which keeps the scores of its last call.
        player: plays the task by this policy: its `make(lanes)` makes the same environments.
        games: the games.

    Example:
        >>> from atari import Task
        >>> from atari.learning import load_policy
        >>> from atari.learning.diagnosis.plays import play_games
        >>> plays = play_games(load_policy("random"), Task.of("breakout"), games=2, seed=0)
        >>> len(plays), plays[0].rams.shape == (len(plays[0]), 128)
        (2, True)
    """

    task: Task
    actions: tuple[str, ...]
    labels: Labels
    epsilon: float
    seed: int
    policy: WatchedPolicy
    player: EvaluatedPolicy
    games: tuple[Play, ...]

    def __len__(self) -> int:
        return len(self.games)

    def __getitem__(self, number: Any) -> Any:
        return self.games[number]

    @property
    def scores(self) -> npt.NDArray[np.float64]:
        """The scores of the games, (games,) float64."""
        return np.array([play.score for play in self.games])

    def states(self, moments: Sequence[Place]) -> list[LaneSnapshot]:
        """The states of steps, for environments of `player.make`, in the order of the moments.

        No state is kept during play: the games are played again by their seeds and actions, up to 64 at a time, without
        the policy. A policy's own memory of earlier observations is not in a state.

        Args:
            moments: objects with `play` and `step`, see `Place`.

        Raises:
            IndexError: there is no such game or step; nothing is played.

        Example:
            >>> from atari import Task
            >>> from atari.learning import load_policy
            >>> from atari.learning.diagnosis.moments import Moment
            >>> from atari.learning.diagnosis.plays import play_games
            >>> plays = play_games(load_policy("random"), Task.of("breakout"), games=1, seed=0)
            >>> (state,) = plays.states([Moment(play=0, step=20, kind="life")])
            >>> envs = plays.player.make(1)
            >>> _ = envs.reset(seed=1)
            >>> envs.restore([0], [state])
            >>> bool((envs.ram()[0] == plays[0].rams[20]).all())
            True
        """
        wanted: defaultdict[int, defaultdict[int, list[int]]] = defaultdict(lambda: defaultdict(list))
        for number, moment in enumerate(moments):
            if not 0 <= moment.play < len(self) or not -1 <= moment.step < len(self[moment.play]):
                steps = f"; it has the steps -1..{len(self[moment.play]) - 1}" if 0 <= moment.play < len(self) else ""
                raise IndexError(f"there is no step {moment.step} of game {moment.play} of {len(self)} games{steps}")
            wanted[moment.play][moment.step].append(number)
        found: dict[int, LaneSnapshot] = {}
        # Games of about equal length are played together, so that few lanes wait.
        games = sorted(wanted, key=lambda game: max(wanted[game]))
        for start in range(0, len(games), _MOST_LANES):
            self._replay({game: wanted[game] for game in games[start : start + _MOST_LANES]}, found)
        return [found[number] for number in range(len(moments))]

    def _replay(self, wanted: dict[int, defaultdict[int, list[int]]], found: dict[int, LaneSnapshot]) -> None:
        """Play some games again, and put the states of the wanted steps into `found`, by the moment's number."""
        plays = [self.games[game] for game in wanted]
        last = np.array([max(steps) for steps in wanted.values()])
        with closing(self.player.make(len(plays))) as envs:
            envs.reset(seed=np.array([play.seed for play in plays]), options={"new_game": True})
            for step in range(-1, int(last.max()) + 1):
                lanes = np.flatnonzero(last >= step)
                if step >= 0:
                    chosen = np.array([plays[lane].actions[step] for lane in lanes], np.int64)
                    envs.step(chosen, env_id=None if len(lanes) == len(plays) else lanes)  # the first is faster
                for lane, steps in zip(range(len(plays)), wanted.values(), strict=True):
                    if step in steps:
                        (state,) = envs.snapshot([lane])
                        found |= dict.fromkeys(steps[step], state)
                _go_on(envs, [lane for lane in lanes.tolist() if step in plays[lane].resets])


def _go_on(envs: AtariVectorEnv, lanes: Sequence[int]) -> None:
    """Reset lanes that have lost a life, where the same game goes on, as an evaluation does."""
    if not lanes:
        return
    mask = np.zeros(envs.num_envs, np.bool_)
    mask[lanes] = True
    envs.reset(seed=np.full(len(lanes), -1), options={"reset_mask": mask})


def play_games(
    policy: LoadedPolicy,
    task: Task,
    games: int,
    seed: int,
    *,
    epsilon: float = 0.0,
    num_threads: int = 1,
    progress: Progress | None = None,
) -> Plays:
    """Let a policy play whole games of a task, and keep each step.

    `evaluate` plays the same games, with the same scores, if task, seed and epsilon are equal.

    A step takes 135 bytes of memory, and 4 more for each action of the task if the policy gives scores. A game of
    108,000 frames with a frame skip of 4 so takes at most 4 MB, or 6 MB with scores of 18 actions; most games take a
    tenth of this.

    Args:
        policy: the policy, see `load_policy`.
        task: the task, such as `played_task` makes from a game, a protocol and a policy.
        games: the number of games.
        seed: the seed of all games, 0..2**32-1.
        epsilon: the probability of a random action, such as the `epsilon` of a protocol.
        num_threads: threads of the vector environment.
        progress: called with the number of games that have ended and the number of all games, after each end of a game.

    Raises:
        TypeError, ValueError: an argument is of the wrong kind or out of range; the policy does not fit the task, or
            returns no actions.
        FileNotFoundError: the game's ROM file does not exist.

    Example:
        >>> from atari.learning import evaluate, load_policy
        >>> from atari.learning.diagnosis.plays import play_games
        >>> from atari.learning.evaluation.played import played_task, resolve_games
        >>> from atari.learning.evaluation.protocols import PROTOCOLS
        >>> policy, protocol = load_policy("random"), PROTOCOLS["dopamine"]
        >>> task = played_task(resolve_games("breakout")[0], protocol, policy)
        >>> plays = play_games(policy, task, 3, seed=0, epsilon=protocol.epsilon)
        >>> tuple(plays.scores) == evaluate(policy, "breakout", "dopamine", episodes=3, seed=0)["breakout"].scores
        True
    """
    games = check_integer("games", games, 1, _MOST_GAMES)
    seed = check_integer("seed", seed, 0, 2**32 - 1)
    watched = WatchedPolicy(policy)
    player = EvaluatedPolicy(watched, task, epsilon)
    seeds = np.array([episode_seed(seed, task.game, game) for game in range(games)], np.int64)
    lanes = -(-games // -(-games // _MOST_LANES))  # as `evaluate`: networks on other batches may round differently
    ended = 0

    def report(_: int) -> None:
        nonlocal ended
        ended += 1
        if progress is not None:
            progress(ended, games)

    with closing(player.make(lanes, num_threads)) as envs:
        steps = _Steps(envs, watched, task)
        played = _Games(steps, player, seeds, report)  # type: ignore[arg-type]
        while played.active.any():
            played.step()
    results = [one for one in played.ended if one is not None]
    return Plays(
        task=task,
        actions=tuple(action.name for action in task.action_set),
        labels=labels_of(task.definition),
        epsilon=epsilon,
        seed=seed,
        policy=watched,
        player=player,
        games=tuple(
            Play(int(own), *result, **steps.kept[game])
            for game, (own, result) in enumerate(zip(seeds, results, strict=True))
        ),
    )


@dataclass
class _Lane:
    """The game of a lane so far: blocks of its steps, and the steps in the block that is being filled."""

    game: int
    first_lives: int = 0
    blocks: list[Array] = field(default_factory=list)
    filled: int = 0
    resets: list[int] = field(default_factory=list)

    @property
    def steps(self) -> int:
        return len(self.blocks) * _BLOCK + self.filled


class _Steps:
    """Environments that keep the steps of the games of an evaluation, which `_Games` plays.

    `kept[game]` has the arrays of an ended game by the names of `Play`. A lane is open while a game is played in it;
    lane i plays games i, i + lanes, ...
    """

    def __init__(self, envs: AtariVectorEnv, policy: WatchedPolicy, task: Task) -> None:
        self._envs, self._policy = envs, policy
        self.num_envs = envs.num_envs
        self.kept: dict[int, dict[str, Any]] = {}
        every = [action.name for action in task.action_set]
        own = needs_of(policy, task.definition).actions
        self._columns = np.array([every.index(name) for name in own or every])
        self._num_actions = len(every)
        self._lanes = [_Lane(lane - envs.num_envs) for lane in range(envs.num_envs)]
        self._open = np.zeros(envs.num_envs, np.bool_)
        self._rows = np.zeros((envs.num_envs, 0), np.dtype([]))

    def reset(self, *, seed: Any, options: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
        """Reset some lanes: to begin new games, or to go on after lost lives."""
        mask = options["reset_mask"]
        observations, info = self._envs.reset(seed=seed, options=options)
        for lane in np.flatnonzero(mask).tolist():
            if options.get("new_game"):
                self._lanes[lane] = _Lane(self._lanes[lane].game + self.num_envs, int(info["lives"][lane]))
            else:
                self._lanes[lane].resets.append(self._lanes[lane].steps - 1)
        if options.get("new_game"):
            self._open |= mask
        else:
            self._close(info, mask)  # a game may end in the reset
        return observations, info

    def step(self, actions: npt.NDArray[np.int64]) -> tuple[Any, ...]:
        """Play a step of all lanes, and keep that of the open lanes, whose actions the policy has chosen last."""
        lanes = np.flatnonzero(self._open)
        results = self._envs.step(actions)
        info = results[4]
        scores = self._policy.last_scores
        if not self._rows.shape[1]:
            self._rows = np.zeros((self.num_envs, _BLOCK), self._row_type(scores is not None))
        at = lanes, np.array([self._lanes[lane].filled for lane in lanes])
        self._rows["actions"][at] = actions[lanes]
        self._rows["rewards"][at] = info["reward"][lanes]
        self._rows["lives"][at] = info["lives"][lanes]
        self._rows["rams"][at] = self._envs.ram(of="result")[lanes]
        if scores is not None:
            every = np.full((len(lanes), self._num_actions), -np.inf, np.float32)
            every[:, self._columns] = scores
            self._rows["scores"][at] = every
        for lane in lanes.tolist():
            own = self._lanes[lane]
            own.filled += 1
            if own.filled == _BLOCK:
                self._cut(lane)
        self._close(info, self._open)
        return results

    def _row_type(self, scored: bool) -> np.dtype[Any]:
        fields: list[Any] = [("actions", "u1"), ("rewards", "<i4"), ("lives", "<i2"), ("rams", "u1", (128,))]
        return np.dtype(fields + [("scores", "<f4", (self._num_actions,))] * scored)

    def _cut(self, lane: int) -> None:
        """Move the filled rows of a lane into a block of its game."""
        own = self._lanes[lane]
        own.blocks.append(self._rows[lane, : own.filled].copy())
        own.filled = 0

    def _close(self, info: dict[str, Any], lanes: npt.NDArray[np.bool_]) -> None:
        """Keep the arrays of the games that have ended in some lanes."""
        over = info.get("_episode", np.zeros_like(lanes)) & lanes
        for lane in np.flatnonzero(over).tolist():
            self._cut(lane)
            own = self._lanes[lane]
            rows = np.concatenate(own.blocks)
            arrays = {name: np.ascontiguousarray(rows[name]) for name in rows.dtype.names or ()}
            facts = {"first_lives": own.first_lives, "resets": tuple(own.resets)}
            self.kept[own.game] = {"scores": None, **arrays, **facts}
        self._open &= ~over
