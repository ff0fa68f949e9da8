"""`search`: a continuation that passes where a game was lost or stood still, found by forks of states before."""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from os import PathLike
from typing import Any, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from atari.base.validation import check_integer
from atari.env.lane_snapshot import LaneSnapshot
from atari.learning.diagnosis.findings import percent
from atari.learning.diagnosis.moments import Moment
from atari.learning.diagnosis.plays import Plays
from atari.learning.evaluation.evaluate import EvaluatedPolicy
from atari.recording import RecordReplay
from atari.recording.replay.record_replay import shadow_env
from atari.recording.replay.recorded_core import ReplayRecorder
from atari.vector import AtariVectorEnv

STEPS_A_SECOND = 8000
"""The steps of all forks that a second of a search's budget stands for, about as many as a core plays by a network."""
AHEAD = (10, 20, 40, 80, 160, 320)
"""The numbers of steps before a moment from which a search begins, one after the other."""
MARGIN = 120
"""The steps after the moment that a continuation must survive."""
LANES = 32
"""The forks that are played together."""

_BRANCH = 8
"""The steps between two states that the tree keeps."""
_SEALED = 32
"""The steps before a lost life whose states the tree drops: the life is often lost when its end has been shown."""
_ROLLOUT = 64
"""The most steps that the tree plays from one of its states."""
_NODES = 512

Actions = npt.NDArray[np.uint8]
IntArray = npt.NDArray[np.int64]


class Way(NamedTuple):
    """How the actions of a try are chosen.

    Attributes:
        name: the words for it.
        epsilon: the probability of a random action at each step at which none is held.
        held: the most steps for which a random action is held.
    """

    name: str
    epsilon: float
    held: int = 1


POLICY = Way("the policy itself", 0.0)
NOISES = tuple(Way(f"the policy with {percent(epsilon)} random actions", epsilon) for epsilon in (0.05, 0.1, 0.3))
RANDOM = Way("random actions", 1.0, 16)
TREE = "a tree search"

_TRIED = (POLICY, *NOISES, RANDOM) * (LANES // 4)
_BRANCHES = (NOISES[1], NOISES[2], RANDOM, RANDOM)


class Part(NamedTuple):
    """Steps of one environment: the state before them, with its generators, and the actions, indices of the task's."""

    state: LaneSnapshot
    actions: Actions


@dataclass(frozen=True, eq=False)
class Saved:
    """A continuation that passes a moment, see `search`.

    Attributes:
        moment: the moment that it passes.
        ahead: the steps before the moment at which it begins.
        score: the score of the game there.
        chosen: the name of the action that the policy chose there.
        value: the policy's score of this action, such as its value; None for a policy that gives no scores.
        way: how the continuation was found: the name of a `Way`, or "a tree search".
        gained: the points that it wins.
        recorded: the points that the game won from there to the moment.
        passed, tries: how many of how many tries from there pass, by all ways but the policy itself and the tree; 0 of
            0 if the budget ended before one of the tries did.
        own_passed, own_tries: the same for the policy itself, with other draws of sticky actions.
        parts: the steps. The generators of the second part and of later ones differ from those at the end of the part
            before; all else is equal.
    """

    moment: Moment
    ahead: int
    score: float
    chosen: str
    value: float | None
    way: str
    gained: int
    recorded: int
    passed: int
    tries: int
    own_passed: int
    own_tries: int
    parts: tuple[Part, ...]

    @property
    def state(self) -> LaneSnapshot:
        """The state that the continuation begins from."""
        return self.parts[0].state

    @property
    def actions(self) -> Actions:
        """The actions of all parts, (steps,) uint8, indices of the task's `action_set`."""
        return np.concatenate([part.actions for part in self.parts])

    def __str__(self) -> str:
        value = "" if self.value is None else f" (its value: {self.value:.3g})"
        tries = (
            f" Of {self.tries} tries with random actions {self.passed} pass, and {self.own_passed} of {self.own_tries} "
            "of the policy itself."
        )
        return (
            f"{self.ahead} steps before, at {self.score:,g} points, the policy chose {self.chosen}{value}; "
            f"{self.way} passes and wins {self.gained:,} points, where the game won {self.recorded:,}."
            f"{tries if self.tries else ''}"
        )

    def write(self, path: str | PathLike[str], player: EvaluatedPolicy) -> None:
        """Record the continuation in a replay (.a26r), see `record_parts`."""
        record_parts(path, player, self.parts)


def steps_of(seconds: float) -> int:
    """The steps of a budget in seconds. It does not depend on the machine, so that a search is always the same.

    Raises:
        TypeError, ValueError: `seconds` is no number above 0.

    Example:
        >>> from atari.learning.diagnosis.search import steps_of
        >>> steps_of(2.0)
        16000
    """
    if isinstance(seconds, bool) or not isinstance(seconds, (int, float)):
        raise TypeError(f"seconds must be a number, got {seconds!r}")
    if not 0 < seconds <= 86_400:
        raise ValueError(f"seconds must be above 0 and at most 86400, got {seconds}")
    return max(1, round(STEPS_A_SECOND * seconds))


def search(plays: Plays, moment: Moment, *, steps: int = 10 * STEPS_A_SECOND, seed: int = 0) -> Saved | None:
    """Look for a continuation of a game that passes a moment, or return None if none is found.

    From states 10, 20, 40, ... steps before the moment, forks are played: by the policy itself, by the policy with 5,
    10 and 30 % random actions, and by random actions that are held. Then a tree grows from the state: its branches go
    on from states that forks have reached, of which the deeper and less visited are preferred. The forks have
    generators of their own, so the search does not know the draws of sticky actions.

    A lost life, or the end of a game, is passed if no life is lost from the fork to 120 steps after the moment. A
    plateau, or the limit of frames, is passed by points that come before the recorded game's, within the same time. The
    state nearest to the moment is taken whose continuation also wins more points than the game did, else the nearest;
    of its continuations the one with most points. A policy with a memory begins it anew at the state.

    Args:
        plays: the games, see `play_games`.
        moment: the moment of one of them.
        steps: the most steps of all forks together, see `steps_of`.
        seed: the seed of all draws, 0..2**32-1. The same arguments give the same result.

    Raises:
        TypeError, ValueError: an argument is of the wrong kind or out of range.
        IndexError: there is no such game or step.

    Example:
        >>> from atari import Task
        >>> from atari.learning import load_policy
        >>> from atari.learning.diagnosis.moments import Moment
        >>> from atari.learning.diagnosis.plays import play_games
        >>> from atari.learning.diagnosis.search import search
        >>> plays = play_games(load_policy("random"), Task.of("breakout"), games=1, seed=0)
        >>> step = int((plays[0].lives < plays[0].lives_before).argmax())
        >>> saved = search(plays, Moment(0, step, "life"), steps=20_000)
        >>> saved is None or len(saved.actions) == saved.ahead + 120
        True
    """
    left = check_integer("steps", steps, 1, 10**12)
    check_integer("seed", seed, 0, 2**32 - 1)
    begins = _begins(plays, moment)
    states = plays.states([replace(moment, step=moment.step - ahead) for ahead in begins])
    best: Saved | None = None
    with closing(_Forks(plays.player, [seed, moment.play, moment.step])) as forks:
        for number, (ahead, state) in enumerate(zip(begins, states, strict=True)):
            forks.budget = left // (len(begins) - number)
            left -= forks.budget
            found = _search_from(plays, moment, ahead, state, forks)
            left += max(0, forks.budget)
            if found is not None and (best is None or found.gained > found.recorded):
                best = found
            if best is not None and best.gained > best.recorded:
                break
    return best


def _begins(plays: Plays, moment: Moment) -> list[int]:
    """The steps before a moment from which a search begins: not before an earlier lost life, nor before the game."""
    play = plays[moment.play] if 0 <= moment.play < len(plays) else None
    if play is None or not 0 <= moment.step < len(play):
        plays.states([moment])  # raises the error
        return []
    lost = np.flatnonzero(play.lives[: moment.step] < play.lives_before[: moment.step])
    first = int(lost[-1]) + 1 if len(lost) else -1
    found = [ahead for ahead in AHEAD if moment.step - ahead >= first]
    return found or ([moment.step - first] if moment.step > first else [])


def _search_from(plays: Plays, moment: Moment, ahead: int, state: LaneSnapshot, forks: "_Forks") -> Saved | None:
    """Search from one state; half of the budget is for the tree."""
    play, first = plays[moment.play], moment.step - ahead + 1
    lives = int(play.lives_before[first])
    goal = Goal(ahead + MARGIN, None)
    if moment.kind in ("plateau", "limit"):
        paid = np.flatnonzero(play.rewards[first:] > 0)
        goal = Goal(ahead + MARGIN, min(ahead + MARGIN, int(paid[0]) if len(paid) else ahead + MARGIN))
    root = Node(state, 0, 0, lives, None, np.zeros(0, np.uint8))
    tries = forks.play([root] * len(_TRIED), _TRIED, goal)
    passed = [one for one in (*tries, *forks.grow(root, goal)) if one.passed and one.way != POLICY]
    if not passed:
        return None
    best = max(passed, key=lambda one: (one.node.gained, -one.node.depth))
    counted = tries if len(tries) == len(_TRIED) else []  # the first that end pass more often than all do
    own = [one for one in counted if one.way == POLICY]
    others = [one for one in counted if one.way != POLICY]
    scores = None if play.scores is None else play.scores[first]
    action = int(play.actions[first])
    return Saved(
        moment=moment,
        ahead=ahead,
        score=float(play.totals[first - 1]) if first else 0.0,
        chosen=plays.actions[action],
        value=None if scores is None else float(scores[action]),
        way=TREE if best.from_tree else best.way.name,
        gained=best.node.gained,
        recorded=int(play.rewards[first : moment.step + 1].sum()),
        passed=sum(one.passed for one in others),
        tries=len(others),
        own_passed=sum(one.passed for one in own),
        own_tries=len(own),
        parts=best.node.parts(),
    )


class Goal(NamedTuple):
    """What a continuation must reach: to survive some steps, or to win points before some steps are over."""

    steps: int
    points_before: int | None

    def reached(self, depth: int, gained: int) -> bool:
        """Whether a fork that has lost no life has passed."""
        return depth >= self.steps if self.points_before is None else gained > 0 and depth <= self.points_before

    def missed(self, depth: int) -> bool:
        """Whether a fork can no longer pass."""
        return self.points_before is not None and depth >= self.points_before


@dataclass(eq=False)
class Node:
    """A state that forks have reached.

    Attributes:
        state: the state, with generators.
        depth: the steps since the search's state.
        gained: the points since then.
        lives: the lives there.
        parent: the node from which the fork began that has reached it; None for the search's state.
        actions: the actions since the parent's state.
        start: the parent's state with the generators of the fork.
        visits: the number of forks that began here.
    """

    state: LaneSnapshot
    depth: int
    gained: int
    lives: int
    parent: Optional["Node"]
    actions: Actions
    start: LaneSnapshot | None = None
    visits: int = 0

    def parts(self) -> tuple[Part, ...]:
        """The steps from the search's state to this one."""
        if self.parent is None or self.start is None:
            return ()
        return (*self.parent.parts(), Part(self.start, self.actions))


@dataclass(eq=False)
class Try:
    """A fork that has ended, and the last node of its steps."""

    way: Way
    node: Node
    passed: bool
    from_tree: bool = False


class _Forks:
    """Environments that play forks, and the steps that are left.

    Attributes:
        budget: the steps that may still be played.
    """

    def __init__(self, player: EvaluatedPolicy, seed: Sequence[int]) -> None:
        self._player, self._rng = player, np.random.default_rng(seed)
        self._envs = player.make(LANES)
        self._envs.reset(seed=self._rng.integers(2**31, size=LANES))
        self.budget = 0

    def close(self) -> None:
        """Close the environments."""
        self._envs.close()

    def play(self, roots: Sequence[Node], ways: Sequence[Way], goal: Goal) -> list[Try]:
        """Play forks from nodes to their ends, as far as half of the budget goes; unfinished forks are left out."""
        kept, self.budget = self.budget // 2, self.budget - self.budget // 2
        tries: list[Try] = []
        for start in range(0, len(roots), LANES):
            tries += self._round(roots[start : start + LANES], ways[start : start + LANES], goal, goal.steps)[0]
        self.budget += kept
        return tries

    def grow(self, root: Node, goal: Goal) -> list[Try]:
        """Grow a tree from a node until the budget is used; returns the forks that came to an end."""
        nodes, tries = [root], list[Try]()
        while self.budget >= LANES:
            weights = np.array([(_BRANCH + node.depth) / (1 + node.visits) ** 2 for node in nodes])
            chosen = self._rng.choice(len(nodes), size=LANES, p=weights / weights.sum())
            for number in chosen.tolist():
                nodes[number].visits += 1
            ways = [_BRANCHES[lane % len(_BRANCHES)] for lane in range(LANES)]
            ended, reached = self._round([nodes[number] for number in chosen], ways, goal, _ROLLOUT)
            tries += [replace(one, from_tree=True) for one in ended]
            nodes = [root, *(nodes + reached)[1:][-_NODES:]]
        return tries

    def _round(self, roots: Sequence[Node], ways: Sequence[Way], goal: Goal, most: int) -> tuple[list[Try], list[Node]]:
        """Play a fork from each node, `most` steps at most; returns the forks that have ended, and the new nodes."""
        lanes = np.arange(len(roots))
        self._envs.restore(lanes, [node.state for node in roots], own_generators=True)
        starts = self._envs.snapshot(lanes)
        observations = _rows(self._envs.observe()[0], lanes)
        self._player.begin(lanes, self._rng.integers(2**31, size=len(lanes)))
        chooser = _Chooser(self._player, ways, self._rng)
        actions = np.zeros((most, len(lanes)), np.uint8)
        gained = np.array([node.gained for node in roots])
        lives = np.array([node.lives for node in roots])
        depth = np.array([node.depth for node in roots])
        tries: list[Try] = []
        nodes: list[list[Node]] = [[] for _ in roots]

        def node(lane: int, step: int) -> Node:
            (state,) = self._envs.snapshot([lane])
            played = actions[: step + 1, lane].copy()
            own = int(depth[lane]), int(gained[lane]), int(lives[lane])
            return Node(state, *own, roots[lane], played, starts[lane])

        for step in range(most):
            if not len(lanes) or self.budget < len(lanes):
                break
            self.budget -= len(lanes)
            chosen = chooser.act(observations, lanes)
            actions[step, lanes] = chosen
            observations, _, ended, truncated, info = self._envs.step(chosen, env_id=lanes)
            lost = (ended & ~truncated) | (info["lives"] < lives[lanes])
            gained[lanes] += info["reward"]
            lives[lanes] = info["lives"]
            depth[lanes] += 1
            over = np.zeros(len(lanes), np.bool_)
            for row, lane in enumerate(lanes.tolist()):
                passed = not lost[row] and goal.reached(int(depth[lane]), int(gained[lane]))
                over[row] = lost[row] or passed or truncated[row] or goal.missed(int(depth[lane]))
                if over[row]:
                    tries.append(Try(ways[lane], node(lane, step), bool(passed)))
                    if lost[row]:
                        nodes[lane] = [one for one in nodes[lane] if one.depth < depth[lane] - _SEALED]
                elif (step + 1) % _BRANCH == 0:
                    nodes[lane].append(node(lane, step))
            lanes, observations = lanes[~over], _rows(observations, ~over)
        return tries, [one for own in nodes for one in own]


class _Chooser:
    """Chooses the actions of forks, each by its way."""

    def __init__(self, player: EvaluatedPolicy, ways: Sequence[Way], rng: np.random.Generator) -> None:
        self._player, self._rng = player, rng
        self._epsilon = np.array([way.epsilon for way in ways])
        self._most = np.array([way.held for way in ways])
        self._held, self._left = np.zeros(len(ways), np.int64), np.zeros(len(ways), np.int64)
        self._actions = len(player.task.action_set)

    def act(self, observations: Any, lanes: IntArray) -> IntArray:
        """The actions of some lanes, (n,), for their observations, (n, ...)."""
        begin = (self._left[lanes] == 0) & (self._rng.random(len(lanes)) < self._epsilon[lanes])
        drawn = lanes[begin]
        self._held[drawn] = self._rng.integers(self._actions, size=len(drawn))
        self._left[drawn] = self._rng.integers(self._most[drawn]) + 1
        holds = self._left[lanes] > 0
        chosen = self._held[lanes]
        if not holds.all():
            chosen[~holds] = self._player.act(_rows(observations, ~holds), lanes[~holds])
        self._left[lanes[holds]] -= 1
        return chosen


def _rows(observations: Any, rows: Any) -> Any:
    if isinstance(observations, dict):
        return {key: value[rows] for key, value in observations.items()}
    return observations[rows]


def record_parts(path: str | PathLike[str], player: EvaluatedPolicy, parts: Sequence[Part]) -> None:
    """Record steps in a replay (.a26r) that begins at the state of the first part.

    Each part begins with a snapshot in the file, so that its score counts from 0 there. The steps of a recorded game
    are one part: a state of `Plays.states`, and the actions after it.

    Args:
        path: the file of the replay; one of this name is replaced.
        player: the player of the task, such as `Plays.player`.
        parts: the steps.

    Raises:
        ValueError: the name has another suffix, or there is no part.
        OSError: the file cannot be written.

    Example:
        >>> from atari import Task
        >>> from atari.learning import load_policy
        >>> from atari.learning.diagnosis.moments import Moment
        >>> from atari.learning.diagnosis.plays import play_games
        >>> from atari.learning.diagnosis.search import Part, record_parts
        >>> from atari.recording import Replay
        >>> plays = play_games(load_policy("random"), Task.of("breakout"), games=1, seed=0)
        >>> (state,) = plays.states([Moment(0, 9, "life")])
        >>> record_parts("steps.a26r", plays.player, [Part(state, plays[0].actions[10:20])])
        >>> replay = Replay.load("steps.a26r")
        >>> replay.frames_total, bool(replay.verify())
        (40, True)
    """
    if not parts:
        raise ValueError("a replay of no steps cannot be made; give a part or more")
    with closing(player.make(1)) as envs:
        (lane,) = envs.lanes
        envs.reset(seed=0)
        envs.restore([0], [parts[0].state])
        shadow: Any = shadow_env(envs.options, 0)
        shadow.reset(seed=0)
        core = shadow.core
        lane.copy_to(core)
        with closing(RecordReplay(shadow, path)) as recorded:
            for number, (state, actions) in enumerate(parts):
                if number:
                    envs.restore([0], [state])
                    lane.copy_to(core)
                    recorded.recorder.record_restore(core.snapshot())
                _record(envs, shadow.core, recorded.recorder, actions)


def _record(envs: AtariVectorEnv, core: Any, recorder: ReplayRecorder, actions: Actions) -> None:
    """Play steps in a vector of one lane, and their frames on a core that is recorded."""
    (lane,) = envs.lanes
    for action in actions.tolist():
        before = lane.frame_number
        lane.record_moves()
        envs.step(np.array([action]))
        recorder.begin_step()
        for move, strength in lane.take_moves()[: lane.frame_number - before]:
            core.act(move, strength)
        recorder.end_step()
