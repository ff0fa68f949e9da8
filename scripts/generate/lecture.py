#!/usr/bin/env python
"""Runs docs/notebooks/lecture-2.ipynb in full with several seeds, draws their curves, and checks that the agents learn.

    scripts/generate/lecture.py                    # seeds 0, 1, 2, each 90 s of one core; docs/lecture.svg
    scripts/generate/lecture.py --seeds 3 -o 3.svg

It prints the table of the notebook. It fails if the median over the seeds is not above 0, of the mean score of the last
games in training. A random agent has -20.3. It needs the extra `learn`, nbclient and ipykernel.
"""

import argparse
import json
import statistics
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOK = ROOT / "docs" / "notebooks" / "lecture-2.ipynb"
SECONDS = 7_200
"""The most that a cell may take, on a machine with other work."""
LAST = "print(json.dumps({'seconds': seconds, 'scores': scores, 'after': played['dqn'].scores}))"
"""A cell after the notebook's own, which prints what this script reads."""
GAMES = 20
"""The games of a mean in training."""


def train(seed: int) -> dict[str, Any]:
    """The training of a seed: `seconds`, `scores` with pairs (step, score of a game), and `after`, scores after it."""
    sys.path.insert(0, str(ROOT / "scripts" / "site"))
    from notebook_runs import run_with  # needs nbclient, and --help does not

    with TemporaryDirectory() as folder:
        notebook = run_with(NOTEBOOK, Path(folder), {"SEED": seed}, SECONDS, LAST)
    return dict(json.loads(notebook.cells[-1].outputs[0].text))


def table(runs: dict[int, dict[str, Any]]) -> str:
    """The runs by seed, as a table of Markdown."""
    lines = ["| seed | seconds of one core | last 20 games in training | 20 games by dqn2015 |", "|---|---|---|---|"]
    for seed, run in runs.items():
        lines.append(f"| {seed} | {run['seconds']:.0f} | {last(run):.1f} | {statistics.fmean(run['after']):.1f} |")
    return "\n".join(lines)


def last(run: dict[str, Any]) -> float:
    """The mean score of the last games in training, which are whole games."""
    return statistics.fmean(score for _, score in run["scores"][-GAMES:])


def draw(runs: dict[int, dict[str, Any]], path: Path) -> None:
    """Draw the mean score of the last games of each run, by steps."""
    import matplotlib
    from matplotlib.figure import Figure

    matplotlib.rcParams["svg.hashsalt"] = "lecture"  # the same numbers make the same file
    figure = Figure(figsize=(8, 3.2), layout="constrained", facecolor="white")
    axes = figure.subplots()
    for seed, run in runs.items():
        steps, scores = zip(*run["scores"], strict=True)
        means = [statistics.fmean(scores[max(0, end - GAMES) : end]) for end in range(1, len(scores) + 1)]
        axes.plot([step / 1000 for step in steps], means, label=f"seed {seed}")
    axes.axhline(0, color="gray", linewidth=0.8)
    axes.set(xlabel="thousand steps", ylabel=f"mean score of {GAMES} games", ylim=(-22, 22))
    axes.legend()
    figure.savefig(path, metadata={"Date": None})


def main() -> None:
    """Run the seeds, one after the other."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2], metavar="N", help="default: 0 1 2")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs" / "lecture.svg", metavar="FILE")
    args = parser.parse_args()
    runs = {seed: train(seed) for seed in args.seeds}
    print(table(runs))
    draw(runs, args.output)
    median = statistics.median(map(last, runs.values()))
    if median <= 0:
        sys.exit(f"the agents have not learned: the median score is {median:.1f}, and above 0 is expected")


if __name__ == "__main__":
    main()
