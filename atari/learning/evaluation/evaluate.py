"""`evaluate`: a policy plays a fixed number of whole games by a named protocol."""

import json
import sys
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from atari.base.extras import import_extra, install_extra
from atari.base.validation import check_integer, check_name
from atari.learning.evaluation.played import EvaluatedGame, played_task, resolve_games
from atari.learning.evaluation.protocols import MAX_EPISODES, EvaluationProtocol, find_protocol
from atari.learning.evaluation.results import GameResult, Result, versions
from atari.learning.evaluation.variants import find_axes, variants_of
from atari.learning.policies import load_policy
from atari.policy import LoadedPolicy
from atari.policy.choice import Choice
from atari.policy.needs import needs_of
from atari.recording.replay.record_replay import RecordVectorReplay
from atari.task import Task
from atari.task.checks import NO_LIMIT
from atari.task.fields import GROUPS
from atari.task.task import GameLike
from atari.vector import AtariVectorEnv

_MOST_LANES = 64

IntArray = npt.NDArray[np.int64]

Progress = Callable[[int, int], Any]


class Workers(Protocol):
    """An object with `map`, such as `concurrent.futures.Executor` and the pools of `multiprocessing` and of Ray."""

    def map(self, function: Callable[[Any], Any], tasks: Iterable[Any], /) -> Iterable[Any]:
        """The results of the function for the tasks, in their order."""


def evaluate(
    policy: Any,
    games: GameLike | EvaluatedGame | Sequence[GameLike | EvaluatedGame],
    protocol: str | EvaluationProtocol = "machado2018",
    *,
    variants: str | Sequence[str] | None = None,
    episodes: int | None = None,
    seed: int = 0,
    num_envs: int | None = None,
    num_threads: int = 0,
    progress: Progress | None = None,
    workers: str | Workers | None = None,
    parts: int = 1,
) -> Result:
    """Let a policy play whole games, and return their scores: the game's own, not clipped, over all lives.

    The games that count are fixed before the first step: lane i, of `num_envs` that play at a time, plays the games
    i, i + num_envs, ... of each game to their ends. "The first 100 games that end", or "all games that end within n
    steps", would favour short games. In most games a bad game is a short one, so their mean would be too low; it would
    be too high in games that a good player ends soon.

    Each game has a seed of its own, made of `seed`, the game's id and its number. So the scores are the same for any
    `num_envs` and `num_threads`, and an evaluation of 50 games has the first 50 of 100 games. This requires a policy
    whose action depends neither on the other rows of its batch nor on generators that all lanes share. Networks on
    batches of another size may round differently, and choose another action where two are nearly equal; with equal
    `num_envs` and `parts` they give the same scores.

    `workers` changes no score: the same batches of the same environments are played in other processes. A task there is
    a game of `games`, or with `parts` a part of its episodes, and begins with a copy of the policy.

    Args:
        policy: a policy as `load_policy` takes it, such as a function of observations (n, ...) that returns actions
            (n,); in a string, "{game}" stands for the game's id; or a mapping from game id to one of these.
        games: a game, an environment ID, a `Task`, a set of `GAME_SETS` such as "atari26", or a sequence of these. It
            decides the mode, the difficulty and interventions, which must be those of the policy. An ID must have the
            protocol's sticky actions, and show RAM or images as the policy needs them. Other fields of a `Task` that
            differ from ALE's v5 must be the fields that are played.
        protocol: one of `PROTOCOLS`, or an `EvaluationProtocol` of your own. It decides the actions, sticky actions,
            frame skip, how games begin, the effect of a lost life, and the limit, whatever environment the policy was
            trained in. The policy decides the observations, see `Policy`. A policy without `task` or `environment` gets
            RAM if `games` is an ID or a `Task` of RAM, else the images of the protocol's preset. If the protocol has
            all 18 actions and the policy was trained with the game's minimal actions, its actions are translated.
        variants: axes, by which the task of each game is also played with one change at a time: "modes",
            "difficulties", "interventions" (each of the package for the game, added to the task's) and "delays" (of 3,
            6 and 12 frames, of actions and of observations), with commas between. Only "modes*difficulties" plays a
            product. All variants of a game have the same seeds. They are in `Result.variants`.
        episodes: whole games of each game and variant; None is the protocol's number.
        seed: the seed of all games, 0..2**32-1.
        num_envs: games that are played at a time; None is up to 64.
        num_threads: threads of the vector environment; 0 is one for each core of the machine, with `workers` one.
        progress: called with the number of games that have ended and the number of all games, before the first game and
            after each end of a game; with `workers` after each task. Without it, the number of games of an evaluation
            with variants is printed on stderr before the first.
        workers: "ray", the cluster of Ray that this process is connected to; or an object with a method
            `map(function, tasks)`, such as `concurrent.futures.ProcessPoolExecutor`; None is this process. Workers must
            be able to import the policy's modules, and to read the files of its source.
        parts: the number of parts into which the episodes of each game are divided: part i has the episodes i,
            i + parts, ..., of which `num_envs` are played at a time. Several workers then play one game.

    Raises:
        TypeError, ValueError: an argument is of the wrong kind or out of range, the policy does not fit the protocol,
            or it returns no actions.
        FileNotFoundError: the file of the policy, or the ROM file of a game, does not exist.

    Example:
        >>> from atari.learning import evaluate
        >>> def noop(observations):
        ...     return [0] * len(observations)
        >>> result = evaluate(noop, "pong", "dopamine", episodes=2, seed=0)
        >>> result["pong"].scores
        (-21.0, -21.0)
    """
    protocol = find_protocol(protocol)
    chosen = resolve_games(games)
    episodes = check_integer("episodes", protocol.episodes if episodes is None else episodes, 1, MAX_EPISODES)
    seed = check_integer("seed", seed, 0, 2**32 - 1)
    parts = check_integer("parts", parts, 1, episodes)
    lanes = _lanes(num_envs, -(-episodes // parts))
    elsewhere = None if workers is None else find_workers(workers)
    loaded: dict[Any, LoadedPolicy] = {}
    axes = None if variants is None else find_axes(variants)
    policies: list[LoadedPolicy] = []
    played: list[Task] = []
    for game in chosen:
        own = _policy(policy, game.id, loaded)
        given = played_task(game, protocol, own)
        tasks = (given,) if axes is None else variants_of(given, axes)
        played += tasks
        policies += [own] * len(tasks)
    players = [EvaluatedPolicy(own, task, protocol.epsilon) for own, task in zip(policies, played, strict=True)]
    seeds = [tuple(episode_seed(seed, task.game, episode) for episode in range(episodes)) for task in played]
    work = [
        _Work(_source(policy, task.game), task, protocol.epsilon, each[part::parts], lanes, num_threads)
        for task, each in zip(played, seeds, strict=True)
        for part in range(parts)
    ]
    if axes is not None and progress is None:
        print(f"{len(played)} tasks, {episodes:,} games of each: {len(played) * episodes:,} games", file=sys.stderr)
    done = _play_all(work, [player for player in players for _ in range(parts)], elsewhere, progress)
    results = [_joined(done[start : start + parts]) for start in range(0, len(done), parts)]
    frames = {getattr(one, "training_frames", None) for one in policies}
    return Result(
        policy=_name(policy, policies),
        protocol=protocol,
        seed=seed,
        games=tuple(results),
        training_frames=frames.pop() if len(frames) == 1 else None,
        versions=versions(),
    )


def record_games(
    policy: Any,
    game: GameLike | EvaluatedGame,
    protocol: str | EvaluationProtocol,
    seeds: Sequence[int],
    path: str | Path,
) -> list[tuple[float, int]]:
    """Record whole games of an evaluation in a replay (.a26r), and return the score and the length in frames of each.

    Args:
        policy, protocol: see `evaluate`.
        game: a game, an ID or a `Task`, see `evaluate`.
        seeds: a seed for each game, 0..2**32-1, such as the `seeds` in a `Result`.
        path: the file of the replay.

    Raises:
        TypeError, ValueError, FileNotFoundError: as `evaluate`.
        OSError: the replay cannot be written.

    Example:
        >>> from atari.learning import evaluate, record_games
        >>> result = evaluate("random", "pong", "dopamine", episodes=2)["pong"]
        >>> played = record_games("random", "pong", "dopamine", result.seeds, "games.a26r")
        >>> played == list(zip(result.scores, result.frames))
        True
    """
    (found,), protocol = resolve_games(game), find_protocol(protocol)
    loaded = _policy(policy, found.id, {})
    return EvaluatedPolicy(loaded, played_task(found, protocol, loaded), protocol.epsilon).record(seeds, path)


def episode_seed(seed: int, game: str, episode: int) -> int:
    """The seed of a game of an evaluation, 0..2**31-1."""
    words = np.random.SeedSequence([seed, zlib.crc32(game.encode()), episode]).generate_state(1)
    return int(words[0]) >> 1


def _policy(policy: Any, game_id: str, loaded: dict[Any, LoadedPolicy]) -> LoadedPolicy:
    """The policy of a game; `loaded` keeps policies that several games share."""
    source = _source(policy, game_id)
    key = source if isinstance(source, str) else id(source)
    if key not in loaded:
        loaded[key] = load_policy(source)
    return loaded[key]


def _source(policy: Any, game_id: str) -> Any:
    """The policy of a game, or its source, from which workers make it."""
    if isinstance(policy, Mapping):
        if game_id not in policy:
            raise ValueError(f"there is no policy for {game_id}; there are some for {', '.join(map(str, policy))}")
        policy = policy[game_id]
    return str(policy).replace("{game}", game_id) if isinstance(policy, (str, Path)) else policy


def _name(policy: Any, policies: Sequence[LoadedPolicy]) -> str:
    if isinstance(policy, (str, Path)):
        return str(policy)
    names = {one.name for one in policies}
    return names.pop() if len(names) == 1 else f"{len(policies)} policies"


def _report(progress: Progress | None, before: int, total: int) -> Callable[[int], Any]:
    return lambda done: progress(before + done, total) if progress else None


def _lanes(num_envs: int | None, episodes: int) -> int:
    """The number of episodes of a part that are played at a time."""
    if num_envs is None:
        rounds = -(-episodes // _MOST_LANES)
        return -(-episodes // rounds)
    return min(check_integer("num_envs", num_envs, 1, 100_000), episodes)


class EvaluatedPolicy:
    """A policy in the environments of a task. It translates the policy's actions, and makes some of them random.

    Args:
        policy: the policy.
        task: the task that is played, from `played_task`.
        epsilon: the probability of a random action.

    Raises:
        ValueError: the policy needs an environment that does not exist, or has an action that the task lacks.
        FileNotFoundError: the game's ROM file does not exist.
    """

    def __init__(self, policy: LoadedPolicy, task: Task, epsilon: float) -> None:
        self.task = task
        self._policy, self._epsilon = policy, epsilon
        self._generators: dict[int, np.random.Generator] = {}
        needs = needs_of(policy, task.definition)
        self.stored_observations: Literal["seen", "screen"] = "screen" if needs.task is None else "seen"
        """The observations of data sets of its games, unless a user names others: see `write_dataset`."""
        self._options = needs.options
        every = tuple(action.name for action in task.action_set)
        self._names = every if needs.actions is None else needs.actions
        if missing := [name for name in self._names if name not in every]:
            raise ValueError(
                f"the policy has the action {missing[0]!r} in {task.game}, where this protocol has {', '.join(every)}; "
                "choose a protocol with all 18 actions, such as 'machado2018', or a policy with these"
            )
        self._every = len(every)
        self._indices = np.array([every.index(name) for name in self._names])
        self.max_frames = task.max_num_frames_per_episode or NO_LIMIT
        try:
            self.make(1).close()  # so that errors are raised before the first game of an evaluation
        except TypeError as error:  # the options may be from a file
            raise ValueError(f"the environment of the policy: {error}") from error

    def make(self, lanes: int, num_threads: int = 1) -> AtariVectorEnv:
        """Environments of the game. They wait for a reset after the end of a game or a life."""
        run: dict[str, Any] = {"autoreset_mode": "Disabled", "num_threads": num_threads, "game_info": True}
        return AtariVectorEnv(self.task, lanes, **run, **self._options)

    def facts(self) -> dict[str, Any]:
        """The options of the policy's observations, as the types of JSON."""
        options = {name: str(value) if name in ("rom", "dtype") else value for name, value in self._options.items()}
        return {name: getattr(self.task, name) for name in GROUPS["observation"]} | options

    def begin(self, lanes: IntArray, seeds: IntArray) -> None:
        """Begin games in some lanes, each with its seed."""
        for lane, seed in zip(lanes.tolist(), seeds.tolist(), strict=True):
            self._generators[lane] = np.random.default_rng([seed, 1])  # the policy may use the seed itself
        self._policy.begin(self.task.game, self._names, lanes, seeds)

    def begin_episodes(self, lanes: IntArray) -> None:
        """Begin the episodes after a lost life in some lanes, where the games go on."""
        if self.task.new_stack_after_life:
            self._policy.begin_episodes(lanes)

    def act(self, observations: Any, lanes: IntArray) -> IntArray:
        """The actions of some lanes, (n,) indices of the environment's actions.

        Raises:
            ValueError: the policy returns no actions.
        """
        chosen = self._indices[self._policy(observations, lanes)]
        if self._epsilon > 0:
            for row, lane in enumerate(lanes.tolist()):
                generator = self._generators[lane]
                if generator.random() < self._epsilon:
                    chosen[row] = generator.integers(self._every)
        return chosen

    def choices(self, seed: int, steps: int) -> npt.NDArray[np.uint8]:
        """How `act` has chosen the action of each step of the game of a seed, (steps,), see `Choice`."""
        choices = np.full(steps, Choice.of(self._policy), np.uint8)
        generator = np.random.default_rng([seed, 1])
        for step in range(steps if self._epsilon > 0 else 0):
            if generator.random() < self._epsilon:
                generator.integers(self._every)
                choices[step] = Choice.EXPLORATION
        return choices

    def record(self, seeds: Sequence[int], path: str | Path) -> list[tuple[float, int]]:
        """Record whole games in a replay, see `record_games`."""
        with closing(RecordVectorReplay(self.make(1), path)) as envs:
            played = _Games(envs, self, np.array(seeds, np.int64), lambda done: None)
            while played.active.any():
                played.step()
        return [(score, frames) for score, frames, _ in filter(None, played.ended)]


@dataclass(frozen=True)
class _Work:
    """Episodes of one task, which one worker plays. `policy` is a policy or its source; it can be pickled."""

    policy: Any
    task: Task
    epsilon: float
    seeds: tuple[int, ...]
    lanes: int
    num_threads: int
    version: str = version("atari-envs")


def _play_all(
    work: Sequence[_Work], players: Sequence[EvaluatedPolicy], workers: Workers | None, progress: Progress | None
) -> list[GameResult]:
    results: list[GameResult] = []
    elsewhere = None if workers is None else iter(workers.map(_play_elsewhere, work))
    total, before = sum(len(part.seeds) for part in work), 0
    _report(progress, before, total)(0)
    for part, player in zip(work, players, strict=True):
        report = _report(progress, before, total)
        if elsewhere is None:
            results.append(_play(part, player, part.num_threads, report))
        else:
            results.append(next(elsewhere))
            report(len(part.seeds))
        before += len(part.seeds)
    return results


def _play_elsewhere(work: _Work) -> GameResult:
    if (own := version("atari-envs")) != work.version:
        raise RuntimeError(f"a worker has atari-envs {own}, and the evaluation was begun with {work.version}")
    player = EvaluatedPolicy(load_policy(work.policy), work.task, work.epsilon)
    return _play(work, player, work.num_threads or 1, lambda done: None)


def _joined(parts: Sequence[GameResult]) -> GameResult:
    """The result of a game, joined from its parts: part i has the episodes i, i + parts, ..."""

    def joined(name: str) -> tuple[Any, ...]:
        columns = [getattr(part, name) for part in parts]
        return tuple(columns[episode % len(parts)][episode // len(parts)] for episode in range(sum(map(len, columns))))

    scores, frames, truncated, seeds = map(joined, ("scores", "frames", "truncated", "seeds"))
    return replace(parts[0], scores=scores, frames=frames, truncated=truncated, seeds=seeds)


def _play(work: _Work, player: EvaluatedPolicy, num_threads: int, report: Callable[[int], Any]) -> GameResult:
    lanes = min(work.lanes, len(work.seeds))
    with closing(player.make(lanes, num_threads)) as envs:
        games = _Games(envs, player, np.array(work.seeds, np.int64), report)
        while games.active.any():
            games.step()
    scores, frames, truncated = zip(*filter(None, games.ended), strict=True)
    played: Mapping[str, Any] = {}
    with suppress(ValueError):  # a game without a file has no JSON
        played = json.loads(work.task.to_json())
    return GameResult(work.task.game, scores, frames, truncated, work.seeds, player.facts(), played)


class _Games:
    """The games of an evaluation that are being played, and the results of the ended games.

    `number[lane]` is the game of a lane; lane i plays games i, i + lanes, ... `ended` has (score, frames, truncated) by
    game. A lane is active until the last of its games has ended.
    """

    def __init__(
        self,
        envs: AtariVectorEnv | RecordVectorReplay,
        player: EvaluatedPolicy,
        seeds: IntArray,
        report: Callable[[int], Any],
    ) -> None:
        self._envs, self._player, self._seeds, self._report = envs, player, seeds, report
        self._limit = player.max_frames
        self.active = np.ones(envs.num_envs, np.bool_)
        self.number = np.arange(envs.num_envs)
        self.ended: list[tuple[float, int, bool] | None] = [None] * len(seeds)
        self._done = 0
        self._observations: Any = None
        self._begin(self.active.copy())

    def step(self) -> None:
        """Play a step of all active lanes, and begin new games, or go on after a lost life, where one has ended."""
        rows = np.flatnonzero(self.active)
        actions = np.zeros(len(self.active), np.int64)
        actions[rows] = self._player.act(_rows(self._observations, rows, len(self.active)), rows)
        self._observations, _, terminations, truncations, info = self._envs.step(actions)
        stopped = (terminations | truncations) & self.active
        if not stopped.any():
            return
        over = self._record(info, stopped, truncations)
        lost_lives = stopped & ~over
        if lost_lives.any():
            keep = np.full(lost_lives.sum(), -1)  # the generators: the same game goes on
            self._observations, info = self._envs.reset(seed=keep, options={"reset_mask": lost_lives})
            over |= self._record(info, lost_lives, np.zeros_like(over))  # it may end in the reset
            self._player.begin_episodes(np.flatnonzero(lost_lives))
        self._begin(over)

    def _record(
        self, info: dict[str, Any], lanes: npt.NDArray[np.bool_], truncations: npt.NDArray[np.bool_]
    ) -> npt.NDArray[np.bool_]:
        """Keep the results of the games that have ended in some lanes, and return the mask of these lanes."""
        over: npt.NDArray[np.bool_] = info.get("_episode", np.zeros_like(lanes)) & lanes
        for lane in np.flatnonzero(over).tolist():
            score, frames = float(info["episode"]["r"][lane]), int(info["episode"]["l"][lane])
            self.ended[self.number[lane]] = (score, frames, bool(truncations[lane]) or frames >= self._limit)
            self._done += 1
            self._report(self._done)
        self.number[over] += len(lanes)
        self.active &= self.number < len(self._seeds)
        return over

    def _begin(self, lanes: npt.NDArray[np.bool_]) -> None:
        lanes = lanes & self.active
        if not lanes.any():
            return
        rows = np.flatnonzero(lanes)
        seeds = self._seeds[self.number[rows]]
        self._observations, _ = self._envs.reset(seed=seeds, options={"reset_mask": lanes, "new_game": True})
        self._player.begin(rows, seeds)


def _rows(observations: Any, rows: IntArray, count: int) -> Any:
    if len(rows) == count:
        return observations
    if isinstance(observations, dict):
        return {key: value[rows] for key, value in observations.items()}
    return observations[rows]


class RayWorkers:
    """The cluster of Ray that this process is connected to. Without a connection, Ray starts on this machine.

    Each task has one CPU. A task whose worker or node is lost is done again elsewhere.

    Raises:
        gymnasium.error.DependencyNotInstalled: Ray is not installed.
    """

    def __init__(self) -> None:
        self._ray = import_extra("ray", f"workers='ray' needs Ray: {install_extra('ray')}")

    def map(self, function: Callable[[Any], Any], tasks: Iterable[Any], /) -> Iterator[Any]:
        """The results of the function for the tasks, in their order. An error cancels the other tasks."""
        remote = self._ray.remote(function)
        pending = [remote.remote(task) for task in tasks]
        try:
            for result in pending:
                yield self._ray.get(result)
        except BaseException:
            _, running = self._ray.wait(pending, num_returns=len(pending), timeout=0)
            for result in running:
                self._ray.cancel(result)
            raise


def find_workers(workers: Any) -> Workers:
    """The workers of an argument: a name, or an object with `map`.

    Raises:
        TypeError: the object has no `map`.
        ValueError: no workers have this name.
        gymnasium.error.DependencyNotInstalled: the package that they need is not installed.
    """
    if isinstance(workers, str):
        check_name("workers", workers, ["ray"])
        return RayWorkers()
    if not callable(getattr(workers, "map", None)):
        raise TypeError(f"workers is 'ray' or has a method map(function, tasks), got {workers!r}")
    return workers
