"""The results of a sweep beside published agents, and the page about all its runs."""

import html
import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from atari.learning.evaluation.compare import Comparison, budget_faults, compare
from atari.learning.evaluation.protocols import EvaluationProtocol
from atari.learning.evaluation.published import Published
from atari.learning.evaluation.results import Result
from atari.learning.options import TrainingOptions
from atari.learning.pages import learning_curves, write_page
from atari.learning.run_folder import RunFolder
from atari.learning.sweep.plan import TrainingRun
from atari.learning.sweep.processes import Settings


def planned_frames(options: TrainingOptions) -> int | None:
    """The emulator frames of a training of all steps; None if it may stop earlier, at a score.

    A training ends with the update that reaches its steps, at most one update after them. It is compared at these
    frames, as publications name theirs.
    """
    low, high = options.task.frames
    return None if options.stop_score is not None else round(options.total_steps * sum(range(low, high)) / (high - low))


def comparable_agents(runs: Sequence[TrainingRun], protocol: EvaluationProtocol) -> list[str]:
    """The published agents of a protocol that have scores of all games of the runs, at the frames of the trainings."""
    frames, games = planned_frames(runs[0].options), {run.options.task.game for run in runs}
    if frames is None:
        return []
    agents = [Published(name) for name in protocol.comparable]
    fitting = [agent for agent in agents if games <= {*agent.games} and not budget_faults(agent, frames)]
    return [agent.name for agent in fitting if all(len(agent.at(game, frames)) for game in games)]


def compare_runs(
    name: str, runs: Sequence[TrainingRun], results: Sequence[Result], to: Sequence[str], mixed: bool
) -> Comparison | None:
    """The runs, as an agent `name`, beside published ones: median, mean and IQM with intervals over games and seeds.

    None if no game has scores of random play and of a human.

    Raises:
        ValueError: see `compare`.
    """
    frames = planned_frames(runs[0].options)
    own = [
        replace(result, policy=name, training_frames=frames if frames else result.training_frames) for result in results
    ]
    if not {run.options.task.game for run in runs} & {*Published.human_scores()}:
        return None
    unequal = len({result.training_frames for result in own}) > 1  # they stopped at a score
    comparison = compare(own, to, mixed=mixed or unequal)
    if to:
        return comparison
    budget = "other numbers of" if frames is None else f"{frames:,}"
    text = f"no published agent of protocol {results[0].protocol.name} has scores of these games at {budget} frames"
    return replace(comparison, notes=(*comparison.notes, text))


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
    drawing = ""
    if comparison is not None:
        comparison.plot(folder / "comparison.svg")
        drawing = '<img src="comparison.svg" alt="normalised scores with intervals">'
    seeds = ",".join(str(seed) for seed in sorted({run.options.seed for run in runs}))
    numbers = ["--games", settings.games, "--protocol", settings.protocol.name, "--episodes", settings.episodes]
    words = [settings.agent, ",".join(games), *settings.words, "--seeds", seeds, *numbers, "-o", folder]
    return write_page(
        folder / "report.html",
        _PAGE,
        title=html.escape(f"{agent.upper()}: {len(games)} games, {len(runs)} runs"),
        command=html.escape(shlex.join(["atari", "train", *map(str, words)])),
        curves="\n".join(f"<h3>{html.escape(game)}</h3>\n{_curves(game, several)}" for game, several in games.items()),
        table=_table(runs, results),
        protocol=html.escape(str(settings.protocol)),
        comparison=html.escape("no game has a score of a human" if comparison is None else str(comparison)),
        drawing=drawing,
    )


def _curves(game: str, runs: Sequence[TrainingRun]) -> str:
    logs = [
        (f"seed {run.options.seed}", f"C{number}", RunFolder.open(run.path).rows())
        for number, run in enumerate(runs, 3)
    ]
    return learning_curves(game, logs)


def _table(runs: Sequence[TrainingRun], results: Sequence[Result]) -> str:
    rows = ["<tr><th>run<th>games<th>mean score<th>standard deviation<th>least<th>greatest"]
    for run, result in zip(runs, results, strict=True):
        played = result.games[0]
        name = html.escape(run.name)
        link = f'<a href="{name}/report.html">{name}</a>' if (run.path / "report.html").exists() else name
        numbers = (played.mean, played.std, min(played.scores), max(played.scores))
        rows.append(f"<tr><td>{link}<td>{len(played.scores)}" + "".join(f"<td>{number:,.1f}" for number in numbers))
    return f"<table>{''.join(rows)}</table>"


_PAGE = """\
<p><code>$command</code></p>
<h2>Evaluation</h2>
<p>$protocol</p>
$table
<h2>Comparison</h2>
$drawing
<pre>$comparison</pre>
<h2>Learning curves</h2>
$curves
"""
