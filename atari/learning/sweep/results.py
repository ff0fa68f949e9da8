"""The results of a sweep beside published agents."""

from collections.abc import Sequence
from dataclasses import replace

from atari.learning.evaluation.compare import Comparison, budget_faults, compare
from atari.learning.evaluation.protocols import EvaluationProtocol
from atari.learning.evaluation.published import Published
from atari.learning.evaluation.results import Result
from atari.learning.options import TrainingOptions
from atari.learning.sweep.plan import Run


def planned_frames(options: TrainingOptions) -> int | None:
    """The emulator frames of a training of all steps; None if it may stop earlier, at a score.

    A training ends with the update that reaches its steps, at most one update after them. It is compared at these
    frames, as publications name theirs.
    """
    low, high = options.task.frames
    return None if options.stop_score is not None else round(options.total_steps * sum(range(low, high)) / (high - low))


def comparable_agents(runs: Sequence[Run], protocol: EvaluationProtocol) -> list[str]:
    """The published agents of a protocol that have scores of all games of the runs, at the frames of the trainings."""
    frames, games = planned_frames(runs[0].options), {run.options.task.game for run in runs}
    if frames is None:
        return []
    agents = [Published(name) for name in protocol.comparable]
    fitting = [agent for agent in agents if games <= {*agent.games} and not budget_faults(agent, frames)]
    return [agent.name for agent in fitting if all(len(agent.at(game, frames)) for game in games)]


def compare_runs(
    name: str, runs: Sequence[Run], results: Sequence[Result], to: Sequence[str], mixed: bool
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
