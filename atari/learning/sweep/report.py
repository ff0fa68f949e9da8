"""The results of a sweep beside published agents, and the page about all its runs."""

import html
import math
import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from statistics import fmean

from atari.base.typed_table import in_text
from atari.learning.evaluation.compare import Comparison, budget_faults, compare
from atari.learning.evaluation.protocols import EvaluationProtocol
from atari.learning.evaluation.published import Published
from atari.learning.evaluation.results import Result
from atari.learning.evaluation.statistics import mean_estimate
from atari.learning.pages import comparison_part, learning_curves, write_page
from atari.learning.run_folder import RunFolder
from atari.learning.sweep.plan import TrainingRun
from atari.learning.sweep.processes import Settings


def planned_frames(runs: Sequence[TrainingRun]) -> int | None:
    """The emulator frames of trainings of all steps; None if they differ, or one may stop earlier, at a score.

    A training ends with the update that reaches its steps, at most one update after them. It is compared at these
    frames, as publications name theirs.
    """
    frames: set[int | None] = set()
    for options in (run.options for run in runs):
        low, high = options.task.frames
        steps = None if options.stop_score is not None else options.total_steps
        frames.add(None if steps is None else round(steps * sum(range(low, high)) / (high - low)))
    return frames.pop() if len(frames) == 1 else None


def comparable_agents(runs: Sequence[TrainingRun], protocol: EvaluationProtocol) -> list[str]:
    """The published agents of a protocol that have scores of all games of the runs, at the frames of the trainings."""
    frames, games = planned_frames(runs), {run.options.task.game for run in runs}
    if frames is None:
        return []
    agents = [Published(name) for name in protocol.comparable]
    fitting = [agent for agent in agents if games <= {*agent.games} and not budget_faults(agent, frames)]
    return [agent.name for agent in fitting if all(len(agent.at(game, frames)) for game in games)]


def compare_runs(
    name: str, runs: Sequence[TrainingRun], results: Sequence[Result], to: Sequence[str], mixed: bool
) -> Comparison | None:
    """The runs, as an agent `name`, beside published ones: median, mean and IQM with intervals over games and seeds.

    Each combination of a grid is an agent. None if no game has scores of random play and of a human.

    Raises:
        ValueError: see `compare`.
    """
    frames = planned_frames(runs)
    own: dict[str, list[Result]] = {}
    for run, result in zip(runs, results, strict=True):
        agent, trained = run.combination or name, frames if frames else result.training_frames
        own.setdefault(agent, []).append(replace(result, policy=agent, training_frames=trained))
    if not {run.options.task.game for run in runs} & {*Published.human_scores()}:
        return None
    unequal = len({result.training_frames for each in own.values() for result in each}) > 1  # stopped at a score
    comparison = compare(own, to, mixed=mixed or unequal)
    if to:
        return comparison
    budget = "other numbers of" if frames is None else f"{frames:,}"
    text = f"no published agent of protocol {results[0].protocol.name} has scores of these games at {budget} frames"
    return replace(comparison, notes=(*comparison.notes, text))


def grid_rows(runs: Sequence[TrainingRun], results: Sequence[Result]) -> list[tuple[str, ...]]:
    """The table of a grid: by game and combination, the mean score over the seeds with its interval; the best marked.

    The interval of 95 % is a bootstrap over the seeds.
    """
    scores: dict[tuple[str, ...], list[float]] = {}
    for run, result in zip(runs, results, strict=True):
        scores.setdefault((run.options.task.game, *run.values.values()), []).append(result.games[0].mean)
    best: dict[str, float] = {}
    for (game, *_), several in scores.items():
        best[game] = max(best.get(game, -math.inf), fmean(several))
    rows: list[tuple[str, ...]] = [("game", *runs[0].chosen, "seeds", "mean score", "")]
    for key, several in scores.items():
        mark = "best" if fmean(several) == best[key[0]] else ""
        rows.append((*key, f"{len(several)}", f"{mean_estimate(several):,.1f}", mark))
    return rows


def write_report(
    folder: Path,
    agent: str,
    runs: Sequence[TrainingRun],
    settings: Settings,
    results: Sequence[Result],
    comparison: Comparison | None,
) -> Path:
    """Write `report.html` about runs and their evaluations, which needs no server, and return its path.

    Raises:
        ImportError: Matplotlib is not installed.
    """
    games: dict[str, list[TrainingRun]] = {}
    for run in runs:
        games.setdefault(run.options.task.game, []).append(run)
    compared = "<p>No game has a score of a human, so there is no comparison.</p>"
    if comparison is not None:
        comparison.plot(folder / "comparison.svg")
        compared = comparison_part(comparison)
    seeds = ",".join(str(seed) for seed in sorted({run.options.seed for run in runs}))
    numbers = ["--games", settings.games, "--protocol", settings.protocol.name, "--episodes", settings.episodes]
    grid = [word for name, values in _grid_of(runs).items() for word in ("--grid", f"{name}={','.join(values)}")]
    words = [settings.agent, ",".join(games), *settings.words, *grid, "--seeds", seeds, *numbers, "-o", folder]
    return write_page(
        folder / "report.html",
        _PAGE,
        title=html.escape(f"{agent.upper()}, games: {len(games)}, runs: {len(runs)}"),
        command=html.escape(shlex.join(["atari", "train", *map(str, words)])),
        curves="\n".join(f"<h3>{html.escape(game)}</h3>\n{_curves(game, several)}" for game, several in games.items()),
        grid=_grid_table(runs, results) if grid else "",
        table=_table(runs, results),
        protocol=html.escape(str(settings.protocol)),
        comparison=compared,
    )


def _grid_of(runs: Sequence[TrainingRun]) -> dict[str, list[str]]:
    """The values of each option of a grid, in the order of the runs."""
    return {name: list(dict.fromkeys(in_text(run.chosen[name]) for run in runs)) for name in runs[0].chosen}


def _grid_table(runs: Sequence[TrainingRun], results: Sequence[Result]) -> str:
    head, *rows = (tuple(map(html.escape, row)) for row in grid_rows(runs, results))
    lines = [f"<tr{' class=best' if row[-1] else ''}><td>{'<td>'.join(row)}" for row in rows]
    table = f"<div class=wide><table><tr><th>{'<th>'.join(head)}{''.join(lines)}</table></div>"
    return f"<h2>By option</h2>\n<p>Mean over seeds, in brackets the interval of 95 %.</p>\n{table}"


def _curves(game: str, runs: Sequence[TrainingRun]) -> str:
    """The curves of a game; with a grid, the seeds of a combination have one color, and the legend names it once."""
    combinations = list(dict.fromkeys(run.combination for run in runs))
    logs, named = [], set()
    for number, run in enumerate(runs):
        label, color = f"seed {run.options.seed}", number
        if run.chosen:
            color = combinations.index(run.combination)
            label = "_" if run.combination in named else run.combination
            named.add(run.combination)
        logs.append((label, f"C{color + 3}", RunFolder.open(run.path).rows()))
    return learning_curves(game, logs)


def _table(runs: Sequence[TrainingRun], results: Sequence[Result]) -> str:
    rows = ["<tr><th>run<th>games<th>mean score<th>standard deviation<th>least<th>greatest"]
    for run, result in zip(runs, results, strict=True):
        played = result.games[0]
        name = html.escape(run.name)
        link = f'<a href="{name}/report.html">{name}</a>' if (run.path / "report.html").exists() else name
        numbers = (played.mean, played.std, min(played.scores), max(played.scores))
        rows.append(f"<tr><td>{link}<td>{len(played.scores)}" + "".join(f"<td>{number:,.1f}" for number in numbers))
    return f"<div class=wide><table>{''.join(rows)}</table></div>"


_PAGE = """\
<style>.best { font-weight: bold; }</style>
<p><code>$command</code></p>
$grid
<h2>Evaluation</h2>
<p>$protocol</p>
$table
$comparison
<h2>Learning curves</h2>
$curves
"""
