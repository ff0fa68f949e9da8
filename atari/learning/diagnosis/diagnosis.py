"""`diagnose`: where the games of a policy end, what it does there, and what gets it on."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from atari.base.validation import check_integer
from atari.learning.diagnosis.behaviour import behaviour
from atari.learning.diagnosis.findings import RESTARTS, Finding, is_new
from atari.learning.diagnosis.groups import Group, groups, words
from atari.learning.diagnosis.moments import Moment
from atari.learning.diagnosis.plays import Plays, play_games
from atari.learning.diagnosis.search import Saved, search, steps_of
from atari.learning.diagnosis.training_log import Standstill, standstill
from atari.learning.evaluation.played import EvaluatedGame, played_task, resolve_games, usual_protocol
from atari.learning.evaluation.protocols import EvaluationProtocol, find_protocol
from atari.learning.frontier import MOST, Frontier, write_frontier
from atari.learning.policies import load_policy
from atari.policy import LoadedPolicy
from atari.task.task import GameLike

Progress = Callable[[str, int, int], Any]
"""Is called with the name of a part of the work, what of it is done, and all of it."""

_FRONTIERS = 20
"""The most moments whose states go into the file of a frontier."""


@dataclass(frozen=True, eq=False)
class Search:
    """A search for a continuation.

    Attributes:
        group: the number of the group of the moment.
        moment: the moment.
        saved: the continuation; None: none was found.
    """

    group: int
    moment: Moment
    saved: Saved | None


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """A diagnosis of a policy, see `diagnose`. As text it is what `atari diagnose` prints.

    Attributes:
        policy: the name of the policy.
        protocol: the protocol of the games.
        plays: the games, with every step.
        groups: where games end, lose lives and stand still, and what is common there.
        findings: what the agent does not do, see or reach, and where it plays at random or in a loop.
        searches: continuations from moments of the groups.
        standstill: when the score of the training stopped to rise; None without a log, or if it rose to the end.
        run: the run folder of the policy; None for another policy.
        training: the fields of the task and the options of the training; None without a run folder.

    Example:
        >>> from atari.learning import diagnose
        >>> diagnosis = diagnose("noop", "pong", games=1, frontiers=0)
        >>> diagnosis.policy, len(diagnosis.plays), diagnosis.searches
        ('noop', 1, ())
    """

    policy: str
    protocol: EvaluationProtocol
    plays: Plays
    groups: tuple[Group, ...]
    findings: tuple[Finding, ...]
    searches: tuple[Search, ...]
    standstill: Standstill | None
    run: Path | None
    training: Mapping[str, Any] | None

    @property
    def options(self) -> tuple[str, ...]:
        """Options of `atari train` to try, the cheapest first; without those that the training had."""
        found = [option for finding in self.findings for option in finding.options]
        found += self.standstill.options if self.standstill is not None else ()
        if any(one.saved is not None and one.saved.own_passed == 0 for one in self.searches):
            found.append(RESTARTS)
        return tuple(one for one in dict.fromkeys(found) if self.training is None or is_new(one, self.training))

    def __str__(self) -> str:
        scores, game = self.plays.scores, self.plays.task.definition
        error = f" ± {scores.std(ddof=1) / len(scores) ** 0.5:,.1f}" if len(scores) > 1 else ""
        lines = [
            f"{self.policy} in {game.title}: {scores.mean():,.1f}{error} in {len(scores)} "
            f"game{'s' * (len(scores) > 1)} by {self.protocol.name}",
            "",
            "Where games end",
            *(f"  {words(group, game)}" for group in self.groups),
        ]
        if self.searches:
            lines += ["", "Continuations", *(f"  {self._continuation(one)}" for one in self.searches)]
        lines += ["", "What the agent does", *(f"  {finding}" for finding in self.findings or ["nothing stands out"])]
        if self.standstill is not None:
            lines += ["", "The training", f"  {self.standstill}"]
        if self.options:
            lines += ["", "To try", *(f"  {option}" for option in self.options)]
        return "\n".join(lines)

    def _continuation(self, one: Search) -> str:
        play = self.plays[one.moment.play]
        where = f"Game {one.moment.play} at {play.totals[one.moment.step]:,} points: "
        if one.saved is None:
            return f"{where}none found. That is no proof that there is none."
        text = str(one.saved)
        return where + text

    def frontier(self) -> Sequence[Moment]:
        """The moments whose states before them are the frontier: of the largest group of ends, in the best games."""
        ends = [group for group in self.groups if group.kind in ("spare", "end", "limit")]
        moments = sorted(ends[0].moments, key=lambda moment: -self.plays[moment.play].score) if ends else []
        return moments[:_FRONTIERS]

    def write_frontier(self, path: str | PathLike[str]) -> None:
        """Write the states before the ends of the best games, for `atari train --restart-from`.

        Raises:
            OSError: the file cannot be written.
        """
        write_frontier(path, self.plays.task, *frontier_of(self.plays, self.frontier()))


def diagnose(
    policy: Any,
    game: GameLike | EvaluatedGame | None = None,
    protocol: str | EvaluationProtocol | None = None,
    *,
    games: int = 100,
    seed: int = 0,
    seconds: float = 10.0,
    frontiers: int = 3,
    num_threads: int = 1,
    progress: Progress | None = None,
) -> Diagnosis:
    """Play whole games of a policy, and say where they end, what the agent does there, and what gets it on.

    The same arguments give the same diagnosis.

    Args:
        policy: a policy as `load_policy` takes it, such as the path of a run folder.
        game: the game; None is that of the policy.
        protocol: how the games are played, see `evaluate`; None is as in the policy's training.
        games: whole games.
        seed: the seed of all games and searches, 0..2**32-1.
        seconds: the time of a search on a fast core. It stands for a number of steps, so a slow core takes longer, and
            finds the same.
        frontiers: the number of moments from which continuations are searched; 0 searches none.
        num_threads: threads that play.
        progress: is called with the name of a part of the work, what is done, and all of it.

    Raises:
        TypeError, ValueError: an argument is of the wrong kind or out of range, or the policy does not fit the game or
            the protocol.
        FileNotFoundError: there is no such policy, or no ROM of the game.

    Example:
        >>> from atari.learning import diagnose
        >>> diagnosis = diagnose("random", "breakout", games=4, frontiers=1, seconds=0.5)
        >>> print(diagnosis)  # doctest: +ELLIPSIS
        random in Breakout: ...
    """
    steps = steps_of(seconds)
    frontiers = check_integer("frontiers", frontiers, 0, 1000)
    report = progress or (lambda part, done, total: None)
    loaded = load_policy(policy)
    found = _game_of(loaded, game)
    chosen = usual_protocol(loaded, found) if protocol is None else find_protocol(protocol)
    task = played_task(found, chosen, loaded)
    training = _training_of(policy)  # its errors come before the games, which take minutes
    plays = play_games(
        loaded,
        task,
        games,
        seed,
        epsilon=chosen.epsilon,
        num_threads=num_threads,
        progress=lambda done, total: report("games", done, total),
    )
    parts = groups(plays)
    report("behaviour", 0, 1)
    habits = behaviour(plays)
    searches = []
    for number, (group, moment) in enumerate(_searched(plays, parts, frontiers)):
        report("searches", number, frontiers)
        searches.append(Search(group, moment, search(plays, moment, steps=steps, seed=seed)))
    return Diagnosis(loaded.name, chosen, plays, parts, habits, tuple(searches), *training)


def frontier_of(plays: Plays, moments: Sequence[Moment], before: Sequence[int] = (100, 200, 300)) -> Frontier:
    """The states some steps before moments of games, with the scores there; of more than 4096, every n-th.

    Args:
        plays: the games, see `play_games`.
        moments: moments of these games.
        before: the numbers of steps before each moment. A game that is shorter has the state before its first step.

    Raises:
        IndexError: there is no such game.

    Example:
        >>> from atari import Task
        >>> from atari.learning import load_policy
        >>> from atari.learning.diagnosis.diagnosis import frontier_of
        >>> from atari.learning.frontier import write_frontier
        >>> from atari.learning.diagnosis.moments import moments_of
        >>> from atari.learning.diagnosis.plays import play_games
        >>> plays = play_games(load_policy("random"), Task.of("breakout"), games=2, seed=0)
        >>> found = frontier_of(plays, [one for one in moments_of(plays) if one.kind == "end"], before=[20, 40])
        >>> write_frontier("breakout.frontier", plays.task, *found)
        >>> len(found.scores)
        4
    """
    wanted: dict[tuple[int, int], Moment] = {}
    for moment in moments:
        for steps in before:
            step = max(-1, moment.step - steps)
            step -= step in plays[moment.play].resets  # where a lost life waits for its reset
            wanted[moment.play, step] = replace(moment, step=step)
    chosen = list(wanted.values())
    if len(chosen) > MOST:
        chosen = [chosen[index] for index in np.linspace(0, len(chosen) - 1, MOST).astype(int)]
    scores = [float(plays[one.play].totals[one.step]) if one.step >= 0 else 0.0 for one in chosen]
    return Frontier(tuple(plays.states(chosen)), tuple(scores))


def _game_of(policy: LoadedPolicy, game: GameLike | EvaluatedGame | None) -> EvaluatedGame:
    """The game that a policy plays.

    Raises:
        ValueError: there is none, or there are several.
    """
    if game is None:
        trained = getattr(policy, "task", None)
        alone = getattr(policy, "game", None) if trained is None else EvaluatedGame.of_policy(trained, {})
        if alone is None:
            raise ValueError(f"{policy.name} does not say which game it plays; name one, such as 'pong'")
        game = alone
    return only_game(resolve_games(game))


def only_game(games: Sequence[EvaluatedGame]) -> EvaluatedGame:
    """The game of a sequence of one game.

    Raises:
        ValueError: it has several.
    """
    if len(games) != 1:
        raise ValueError(f"a diagnosis is of one game, got {len(games)}; name one of them")
    return games[0]


def _searched(plays: Plays, parts: Sequence[Group], count: int) -> list[tuple[int, Moment]]:
    """The moments from which continuations are searched: of the largest groups in turn, where the score is median."""
    ends = [number for number, group in enumerate(parts) if group.kind != "life"] or list(range(len(parts)))
    queues = []
    for number in ends:
        moments = sorted(parts[number].moments, key=lambda one: abs(plays[one.play].score - parts[number].median))
        queues.append([(number, moment) for moment in moments])
    found: list[tuple[int, Moment]] = []
    while len(found) < count and any(queues):
        for queue in queues:
            if queue and len(found) < count:
                found.append(queue.pop(0))
    return found


def _training_of(policy: Any) -> tuple[Standstill | None, Path | None, Mapping[str, Any] | None]:
    """The standstill in the log of a policy's training, its run folder, and its options; None without a run folder.

    Raises:
        ValueError: the log has not the columns of a training.
    """
    if not isinstance(policy, (str, Path)) or not (Path(policy) / "config.json").is_file():
        return None, None, None
    from atari.learning.agent import read_options
    from atari.learning.run_folder import RunFolder

    folder = RunFolder.open(Path(policy))
    options, rows = vars(read_options(folder, to_train=False)), folder.rows()
    for name in ("step", "frames", "score"):
        if rows and name not in rows[0]:
            raise ValueError(f"{folder.path / 'log.csv'} is damaged: it has no column {name}; remove it to go without")
    return standstill(rows, options), folder.path, {**folder.config["task"], **options}
