"""`compare`: results of evaluations beside published ones, in human-normalised scores."""

import json
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from atari.base import durable, notebook
from atari.base.text_table import aligned
from atari.base.validation import check_integer
from atari.games.catalog import games
from atari.learning.evaluation.protocols import GAME_SETS, EvaluationProtocol, differences, refusal
from atari.learning.evaluation.published import Published, are_alike, read_table
from atari.learning.evaluation.results import Result, changes_of
from atari.learning.evaluation.statistics import (
    Estimate,
    Floats,
    References,
    atari5_estimate,
    estimate_of_episodes,
    estimate_of_runs,
    human_normalised,
    mean_estimate,
)


@dataclass(frozen=True)
class Row:
    """An agent in a comparison.

    Attributes:
        name: the agent's name.
        runs: the number of trainings whose scores are known one by one; None if only their mean is known.
        frames: the emulator frames of its training; None is not known.
        median, mean: the median and the mean over games of the mean of runs, human-normalised.
        iqm: the interquartile mean over games and runs.
        protocol: how the scores came about.
        scores: by game, the scores of runs, not normalised.
        means: by game, the mean of the scores with its interval: of the episodes of one run, or of several runs.
    """

    name: str
    runs: int | None
    frames: int | None
    median: Estimate
    mean: Estimate
    iqm: Estimate
    protocol: str
    scores: Mapping[str, tuple[float, ...]]
    means: Mapping[str, Estimate]


@dataclass(frozen=True, repr=False)
class Comparison:
    """Agents beside each other, see `compare`. Its text has two tables."""

    rows: tuple[Row, ...]
    games: tuple[str, ...]
    human: str
    references: References
    mixed: bool
    notes: tuple[str, ...]

    def normalised(self, row: Row) -> dict[str, Floats]:
        """By game, the human-normalised scores of a row's runs, (runs,) float64."""
        return human_normalised({game: np.array(scores) for game, scores in row.scores.items()}, self.references)

    def __str__(self) -> str:
        title = f"human-normalised scores (table {self.human}), games: {len(self.games)}"
        if self.mixed:
            title = f"MIXED PROTOCOLS OR BUDGETS, not a fair comparison: {title}"
        overview: list[Sequence[object]] = [("agent", "runs", "frames", "median", "mean", "IQM")]
        for row in self.rows:
            frames = "?" if row.frames is None else f"{row.frames:,}"
            overview.append((row.name, "?" if row.runs is None else row.runs, frames, row.median, row.mean, row.iqm))
        table: list[Sequence[object]] = [("game", "random", "human", *(row.name for row in self.rows))]
        for game in self.games:
            means = (f"{row.means[game]:,.1f}" for row in self.rows)
            table.append((game, *(f"{score:,.1f}" for score in self.references[game]), *means))
        if len(self.rows) > len(self.games):
            table = list(zip(*table, strict=True))
        return "\n".join(
            [title, "", *aligned(overview, bool), "", *aligned(table, bool), "", *(f"- {note}" for note in self.notes)]
        )

    def __repr__(self) -> str:
        return f"Comparison({', '.join(row.name for row in self.rows)}, {len(self.games)} games)"

    def _repr_html_(self) -> str:
        return notebook.report(str(self))

    def to_json(self) -> dict[str, Any]:
        """The whole comparison as the types of JSON."""
        return {"format": "atari comparison 1", **asdict(self)}

    def save(self, file: str | PathLike[str]) -> None:
        """Write a JSON file; an existing one is replaced.

        Raises:
            OSError: the file cannot be written.
        """
        durable.write_file(Path(file), (json.dumps(self.to_json(), indent=1) + "\n").encode())

    def plot(self, file: str | PathLike[str]) -> None:
        """Draw the summaries with their intervals, and performance profiles; the file's ending decides the format.

        Raises:
            gymnasium.error.DependencyNotInstalled: Matplotlib is not installed.
            ValueError: Matplotlib does not know the format.
            OSError: the file cannot be written.
        """
        from atari.learning.evaluation.plot import plot  # here, because it imports Matplotlib

        plot(self, Path(file))


def compare(
    results: Result | Sequence[Result] | Mapping[str, Result | Sequence[Result]],
    to: str | Sequence[str] | None = None,
    *,
    frames: int | None = None,
    human: str = "noop57",
    mixed: bool = False,
    repetitions: int = 2000,
    seed: int = 0,
) -> Comparison:
    """Put results of evaluations beside each other and beside published results, on the games that all of them have.

    A normalised score is (score - random) / (human - random). With one result of each game, the bootstrap draws its
    episodes again, and the intervals are about this policy. With several results of a game, from trainings with
    different seeds, the bootstrap draws runs again, as for published agents; the intervals are about the algorithm.

    Results of policies with different names are different agents, with a row each. Trainings of one agent, whose
    policies have different names, such as paths, are given by the agent's name: `compare({"mine": [result, other]})`.
    `compare({"mine": result, "theirs": other})` has two agents.

    Most published scores are of training games, with exploration. The notes say so.

    Scores are compared at budgets of training that differ by 1 % at most, and nothing is extrapolated: a budget after
    the last or before the first score of a published agent is refused. With `mixed`, the agent has its last scores
    before that budget, or else its first scores, and its row has their frames.

    Args:
        results: results of `evaluate`. Those of one policy's name are one agent's: other games, or other trainings. A
            mapping has the results of each agent by a name for it.
        to: names of published agents, see `Published.names`; () is none. None is "dopamine/rainbow" beside one agent,
            and none beside several.
        frames: emulator frames of training at which to compare; None is the `training_frames` of the results. If both
            are not known, published agents have their final scores.
        human: the table of human and random scores, see `Published.human_scores`.
        mixed: compare agents of different protocols or budgets nevertheless. The comparison then says so.
        repetitions: the number of the bootstrap's drawings.
        seed: the seed of the bootstrap, 0..2**32-1.

    Returns:
        A `Comparison`, which prints as two tables, with methods `save(file)` (JSON) and `plot(file)`.

        - `rows`: the agents, the evaluated ones first: `name`, `runs`, `frames`, `protocol`, `scores` and `means` by
            game, and `median`, `mean` and `iqm`; these and each of `means` have `value`, `low` and `high`, the interval
            of 95 %;
        - `games`: the games that are compared;
        - `human`: the name of the human table, and `references`: by game, the scores of random play and of a human;
        - `mixed`: whether protocols or budgets differ;
        - `notes`: sentences on what the scores depend on.

    Raises:
        TypeError, ValueError: an argument is of the wrong kind, such as a result in place of a published agent, a name
            is not known (the nearest is suggested), the protocols or budgets differ, the human table is for another
            protocol, a game was played in another mode or with interventions, a result has variants, or no game is
            left.

    Example:
        >>> from atari.learning import compare, evaluate
        >>> result = evaluate("random", ["pong", "breakout"], "dopamine", episodes=2)
        >>> comparison = compare(result, "dopamine/rainbow", frames=10_000_000, repetitions=50)
        >>> [(row.name, row.frames) for row in comparison.rows]
        [('random', 10000000), ('dopamine/rainbow', 10000000)]
    """
    agents = _agents(results)
    results = [result for own in agents.values() for result in own]
    to = _check_published(to, len(agents))
    others = [Published(name) for name in to]
    repetitions = check_integer("repetitions", repetitions, 1, 100_000)
    seed = check_integer("seed", seed, 0, 2**32 - 1)
    references = Published.human_scores(human)
    faults: list[str] = []
    protocol = _common_protocol(results, faults)
    mixes = any(len({result.training_frames for result in own}) > 1 for own in agents.values())
    compared = others or mixes or frames is not None
    trained = {result.training_frames for result in results} if compared else set()
    played = ((one.game, one.task) for result in results for one in result.games)
    found, frames = comparison_faults(protocol, played, to, trained, frames=frames, human=human)
    faults += found
    if faults and not mixed:
        raise ValueError(f"these are not comparable: {'; '.join(faults)}; mixed=True compares them, and says so")
    games_of = [{one.game for result in own for one in result.games} for own in agents.values()]
    every, shared = set.union(*games_of), set.intersection(*games_of)
    known = [{game for game in shared & {*other.games} if len(_scores_at(other, game, frames))} for other in others]
    common = [game for game in references if game in shared.intersection(*known)]
    if not common:
        raise ValueError(f"there is no game that all of {', '.join([*agents, human, *to])} have scores of")
    references = {game: references[game] for game in common}
    bootstrap = {"repetitions": repetitions, "seed": seed}
    rows = [
        *(_own_row(name, own, references, frames, bootstrap) for name, own in agents.items()),
        *(_published_row(other, references, frames, bootstrap) for other in others),
    ]
    comparison = Comparison(tuple(rows), tuple(common), human, references, bool(faults), ())
    return replace(comparison, notes=tuple(_notes(comparison, faults, sorted(every - set(common)), others, frames)))


def _notes(
    comparison: Comparison,
    faults: Sequence[str],
    left_out: Sequence[str],
    others: Sequence[Published],
    frames: int | None,
) -> Iterator[str]:
    yield from (f"MIXED: {fault}" for fault in faults)
    if left_out:
        yield f"left out, because not all have scores of them: {', '.join(left_out)}"
    for protocol in dict.fromkeys(row.protocol for row in comparison.rows):
        yield f"{' and '.join(row.name for row in comparison.rows if row.protocol == protocol)}: {protocol}"
    for other in others:
        if frames is not None and not budget_faults(other, frames):
            first, last = other.interval(frames)
            if first < last:
                yield f"{other.name} at {frames:,} frames: the mean of its games of frames {first:,} to {last:,}"
    if "video_pinball" in comparison.games and comparison.human == "noop57":
        yield "Video Pinball's random score here is 16,256.9; other tables have 0, which changes means"
    if set(comparison.games) >= set(GAME_SETS["atari5"]):
        estimates = (f"{row.name} {atari5_estimate(comparison.normalised(row)):.3f}" for row in comparison.rows)
        yield f"Atari-5's estimate of the median over 57 games: {', '.join(estimates)}"


def _agents(results: Any) -> dict[str, list[Result]]:
    if isinstance(results, Mapping) and results:
        return {str(name): _check_results(own) for name, own in results.items()}
    agents: dict[str, list[Result]] = {}
    for result in _check_results(results):
        agents.setdefault(result.policy, []).append(result)
    return agents


def _check_results(results: Any) -> list[Result]:
    results = [results] if isinstance(results, Result) else results
    if not isinstance(results, Sequence) or not results or not all(isinstance(one, Result) for one in results):
        raise TypeError(f"results must be a Result of evaluate(), or several, got {results!r:.100}")
    for result in results:
        if len({one.game for one in result.games}) < len(result.games):
            raise ValueError(
                f"the result of {result.policy} has variants, which it compares itself: print it; results without "
                "variants are compared with others"
            )
    return list(results)


def _check_published(to: Any, agents: int) -> list[str]:
    if to is None:
        return [] if agents > 1 else ["dopamine/rainbow"]
    names: list[Any] = [to] if isinstance(to, (str, Result)) else list(to)
    if any(isinstance(name, Result) for name in names):
        raise TypeError(
            "`to` has names of published agents, such as 'dopamine/rainbow', and a Result is none; results are "
            "compared with each other in a list, as compare([result, other], to=())"
        )
    return names


def _common_protocol(results: Sequence[Result], faults: list[str]) -> EvaluationProtocol:
    first = results[0].protocol
    for result in results[1:]:
        if different := differences(first, result.protocol):
            faults.append(
                f"the results are of protocols {first.name} and {result.protocol.name}: {', '.join(different)}"
            )
    return first


def comparison_faults(
    protocol: EvaluationProtocol,
    played: Iterable[tuple[str, Mapping[str, Any]]],
    to: Iterable[str],
    trained: Collection[int | None],
    *,
    frames: int | None = None,
    human: str = "noop57",
) -> tuple[list[str], int | None]:
    """Why agents cannot be compared with published ones, in words, and the frames of training to compare them at.

    It is known before a game is played; `compare` finds the same after the games.

    Args:
        protocol: the protocol by which the agents are evaluated.
        played: the id of each game, and its task as the object of `Task.to_json`.
        to: names of published agents.
        trained: the frames of training of the agents; None are not known.
        frames, human: see `compare`.

    Raises:
        TypeError, ValueError: a name or `frames` is of the wrong kind or not known.
    """
    faults: list[str] = []
    frames = _common_frames(trained, frames, faults)
    faults += [*_human_faults(human, protocol), *_game_faults(played)]
    for other in map(Published, to):
        found = (refusal(protocol, other), *budget_faults(other, frames))
        faults += [f"{other.name}: {fault}" for fault in found if fault]
    return faults, frames


def _game_faults(played: Iterable[tuple[str, Mapping[str, Any]]]) -> list[str]:
    """The games that are played in another mode or difficulty, with interventions or with delays, in words."""
    changed = [(game, changes) for game, task in played if game in games and (changes := changes_of(game, task))]
    return [
        f"{game} is played with another {' and '.join(changes)} than in scores of others" for game, changes in changed
    ]


def _common_frames(trained: Collection[int | None], frames: int | None, faults: list[str]) -> int | None:
    """The budget at which agents are compared: `frames`, or else the smallest of theirs."""
    known = set(trained)
    given = {number for number in known if number is not None}
    if frames is not None:
        frames = check_integer("frames", frames, 1, 10**15)
        if not are_alike({*given, frames}):
            faults.append(f"the policies were trained for {_listed(known)} frames, not for {frames:,}")
        return frames
    if len(known) > 1 and not (None not in known and are_alike(given)):
        faults.append(f"the policies were trained for different numbers of frames: {_listed(known)}")
        return None
    return min(given, default=None)


def _listed(numbers: set[int | None]) -> str:
    return " and ".join(
        "unknown" if number is None else f"{number:,}" for number in sorted(numbers, key=lambda n: n or 0)
    )


def _human_faults(human: str, protocol: EvaluationProtocol) -> list[str]:
    """The fault of a human table that is not for scores of the protocol, in words."""
    if human == "noop57" or (human == "nature2015" and protocol.name == "dqn2015"):
        return []
    meaning = read_table("human")["tables"][human]["meaning"]
    return [f"the human table {human} is not for scores of {protocol.name} ({meaning}); use noop57"]


def budget_faults(other: Published, frames: int | None) -> list[str]:
    """The reason why a published agent has no scores after `frames` of training; None is its final scores."""
    try:
        if frames is not None:
            other.interval(frames)
    except ValueError as error:
        return [str(error).removeprefix(f"{other.name} ")]
    return []


def _frames_at(other: Published, frames: int | None) -> int | None:
    """The frames at which a published agent is compared: `frames`, or else its last scores before, or its first."""
    if frames is None or not budget_faults(other, frames):
        return other.final_frames if frames is None else frames
    before = [budget for budget in other.budgets if budget < frames]
    return max(before, default=min(other.budgets, default=None))


def _scores_at(other: Published, game: str, frames: int | None) -> Floats:
    at = _frames_at(other, frames)
    return other.final(game) if at is None or (at == other.final_frames != frames) else other.at(game, at)


def _own_row(
    name: str, results: Sequence[Result], references: References, frames: int | None, bootstrap: dict[str, int]
) -> Row:
    played = {game: [one for result in results for one in result.games if one.game == game] for game in references}
    runs = {game: np.array([one.mean for one in several]) for game, several in played.items()}
    if all(len(several) == 1 for several in played.values()):
        episodes = {game: np.array(several[0].scores) for game, several in played.items()}
        estimates = estimate_of_episodes(human_normalised(episodes, references), **bootstrap)
    else:
        estimates = estimate_of_runs(human_normalised(runs, references), **bootstrap)
    count = sum(len(one.scores) for several in played.values() for one in several)
    trained = {result.training_frames for result in results}
    return Row(
        name=name,
        runs=max(map(len, runs.values())),
        frames=trained.pop() if frames is None and len(trained) == 1 else frames,
        protocol=f"{results[0].protocol}; {count:,} games, played after the training",
        scores={game: tuple(scores.tolist()) for game, scores in runs.items()},
        means={
            game: mean_estimate(several[0].scores if len(several) == 1 else runs[game], **bootstrap)
            for game, several in played.items()
        },
        **estimates,
    )


def _published_row(other: Published, references: References, frames: int | None, bootstrap: dict[str, int]) -> Row:
    scores = {game: _scores_at(other, game, frames) for game in references}
    runs = max(map(len, scores.values()))
    return Row(
        name=other.name,
        runs=runs if runs > 1 else None,
        frames=_frames_at(other, frames),
        protocol=f"{other.title}, {other.protocol['phase']}; {other.source['repo']}, {other.source['licence']}",
        scores={game: tuple(values.tolist()) for game, values in scores.items()},
        means={game: mean_estimate(values, **bootstrap) for game, values in scores.items()},
        **estimate_of_runs(human_normalised(scores, references), **bootstrap),
    )
