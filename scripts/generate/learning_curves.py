#!/usr/bin/env python
"""Keeps the learning curves of trainings as small files, and draws them beside published ones.

    scripts/generate/learning_curves.py collect runs/breakout-ppo runs/breakout-dqn    # into docs/curves
    scripts/generate/learning_curves.py draw                                           # docs/learning-curves.svg
    scripts/generate/learning_curves.py table                                          # Markdown on standard output

A run folder becomes `docs/curves/GAME-AGENT.csv`, with sticky actions `GAME-AGENT-sticky-SEED.csv`, at most 100 rows of
its log, and an entry of `docs/curves/runs.json`: the options that differ from the agent's defaults, versions, and the
scores of the evaluation after the training. It needs the extra `learn`.
"""

import argparse
import csv
import json
import math
import statistics
from dataclasses import fields
from pathlib import Path
from typing import Any

from atari.learning import Published
from atari.task.description import summary

DOCS = Path(__file__).resolve().parents[2] / "docs"
FOLDER = DOCS / "curves"
RUNS = FOLDER / "runs.json"
COLUMNS = ("step", "frames", "seconds", "games", "score")
COLORS = {"ppo": "#c2410c", "dqn": "#1d4ed8", "pqn": "#15803d", "pqn, sticky actions": "#a21caf"}
PUBLISHED = ("dopamine/dqn", "dopamine/rainbow", "cleanrl/ppo")
"""Columns of the table: those with curves at equal frames, the others at the end of their training."""


def collect(path: Path) -> None:
    """Keep the curve and the facts of a run folder."""
    from atari.learning.agent import read_options
    from atari.learning.run_folder import RunFolder  # needs PyTorch, and --help does not

    folder = RunFolder.open(path)
    agent, options = folder.config["agent"], read_options(folder)
    sticky = bool(options.task.repeat_action_probability)
    name = f"{options.task.game}-{agent}{f'-sticky-{options.seed}' if sticky else ''}"
    rows = folder.rows()
    thinned = rows[:: math.ceil(len(rows) / 99)]
    FOLDER.mkdir(exist_ok=True)
    with (FOLDER / f"{name}.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        for row in [*thinned, *([] if thinned[-1] is rows[-1] else rows[-1:])]:
            writer.writerow({key: round(row[key], 2) if key == "score" else f"{row[key]:.0f}" for key in COLUMNS})
    evaluation = json.loads((path / "evaluation.json").read_text(encoding="utf-8"))
    defaults = {field.name: field.default for field in fields(options) if field.name != "task"}
    changed = {key: getattr(options, key) for key in defaults if getattr(options, key) != defaults[key]}
    runs = read_runs()
    runs[name] = {
        "game": options.task.game,
        "agent": agent,
        "task": summary(options.task),
        "options": changed,
        "versions": folder.config["versions"],
        "scores": evaluation["games"][0]["scores"],
    }
    RUNS.write_text(json.dumps(dict(sorted(runs.items())), indent=1) + "\n", encoding="utf-8")


def read_runs() -> dict[str, Any]:
    """The facts of the trainings that are kept, by name."""
    return dict(json.loads(RUNS.read_text(encoding="utf-8"))) if RUNS.exists() else {}


def read_rows(name: str) -> list[dict[str, float]]:
    """The curve of a training."""
    with (FOLDER / f"{name}.csv").open(newline="") as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def suffix(name: str) -> str:
    """The words after the agent of a run with sticky actions; "" without them."""
    return ", sticky actions" if "-sticky-" in name else ""


def draw() -> None:
    """Draw a panel for each game."""
    import matplotlib

    matplotlib.rcParams["svg.hashsalt"] = "curves"  # the same numbers make the same file
    from matplotlib.figure import Figure

    from atari.learning.pages import draw_levels, draw_published, draw_scores

    runs = read_runs()
    by_game: dict[str, list[str]] = {}
    for name, run in runs.items():
        by_game.setdefault(run["game"], []).append(name)
    lines = math.ceil(len(by_game) / 2)
    figure = Figure(figsize=(9, 2.6 * lines), layout="constrained")
    panels = figure.subplots(lines, 2, squeeze=False).flatten()
    for axes in panels[len(by_game) :]:
        axes.set_axis_off()
    for axes, (game, names) in zip(panels, by_game.items(), strict=False):
        curves = {name: read_rows(name) for name in names}
        draw_published(axes, game, max(rows[-1]["frames"] for rows in curves.values()))
        for name, rows in curves.items():
            kind = runs[name]["agent"] + suffix(name)
            draw_scores(axes, rows, f"this package: {kind}", COLORS[kind])
        draw_levels(axes, game)
        axes.set_title(game, fontsize="medium")
        axes.set_xlabel("million frames", fontsize="small")
    entries = dict(zip(*reversed(panels[0].get_legend_handles_labels()), strict=True))
    for axes in panels[1 : len(by_game)]:
        entries.update(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=4, fontsize="small")
    figure.savefig(DOCS / "learning-curves.svg", metadata={"Date": None})


def table() -> None:
    """Print a row for each training, beside published scores."""
    print(
        "| game | agent | frames | last 100 games | 100 games after it |", *(f" {name} |" for name in PUBLISHED), sep=""
    )
    print("|---|---|---|---|---|", *("---|" for _ in PUBLISHED), sep="")
    for name, run in read_runs().items():
        game, last = run["game"], read_rows(name)[-1]
        after = f"{statistics.fmean(run['scores']):,.1f} ± {statistics.stdev(run['scores']):,.1f}"
        beside = " | ".join(_beside(source, game, int(last["frames"])) for source in PUBLISHED)
        frames = f"{last['frames'] / 1e6:.1f} M"
        print(f"| {game} | `{run['agent']}`{suffix(name)} | {frames} | {last['score']:,.1f} | {after} | {beside} |")


def _beside(name: str, game: str, frames: int) -> str:
    source = Published(name)
    if game not in source.games:
        return "–"
    if not source.has_curves:
        return f"{source.final(game).mean():,.1f}"
    if frames < 1.01 * source.final_frames:  # 200 million frames are shown beside 199
        frames = min(frames, source.final_frames)
    scores = source.at(game, frames)
    return f"{scores.mean():,.1f}"


def main() -> None:
    """Run a command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=["collect", "draw", "table"])
    parser.add_argument("runs", nargs="*", type=Path, metavar="RUN", help="collect: run folders")
    args = parser.parse_args()
    if args.command == "collect":
        for run in args.runs:
            collect(run)
    elif args.command == "draw":
        draw()
    else:
        table()


if __name__ == "__main__":
    main()
