#!/usr/bin/env python
"""Keeps the learning curves of trainings as small files, and draws them beside published ones.

    scripts/generate/learning_curves.py collect runs/breakout-ppo runs/breakout-dqn    # into docs/curves
    scripts/generate/learning_curves.py draw                                           # docs/ppo.svg and others
    scripts/generate/learning_curves.py table                                          # Markdown on standard output

A run folder becomes `docs/curves/GAME-AGENT.csv`, with sticky actions `GAME-AGENT-sticky-SEED.csv`, with restarts
`GAME-AGENT-restarts-sticky-SEED.csv`, at most 100 rows of its log, and an entry of `docs/curves/runs.json`: the options
that differ from the agent's defaults, versions, and the scores of the evaluation after the training. It needs the extra
`learn`.
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
COLORS["pqn, restarts, sticky actions"] = "#0e7490"
NEWER = {"dopamine_nets/dqn_cnn": ":", "dopamine_nets/rainbow_cnn": "--"}
"""Curves of Dopamine's newer trainings, which the report of a training does not draw, and their line styles."""
PUBLISHED = {
    "DQN": ("dopamine/dqn", "dopamine_nets/dqn_cnn"),
    "Rainbow": ("dopamine/rainbow", "dopamine_nets/rainbow_cnn"),
    "`cleanrl/ppo`": ("cleanrl/ppo",),
}
"""Columns of the tables: agents with curves at equal frames, the others at the end of their training."""


def collect(path: Path) -> None:
    """Keep the curve and the facts of a run folder."""
    from atari.learning.agent import read_options
    from atari.learning.run_folder import RunFolder  # needs PyTorch, and --help does not

    folder = RunFolder.open(path)
    agent, options = folder.config["agent"], read_options(folder)
    sticky = bool(options.task.repeat_action_probability)
    restarts = "-restarts" if getattr(options, "restart_share", 0) else ""
    name = f"{options.task.game}-{agent}{restarts}{f'-sticky-{options.seed}' if sticky else ''}"
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
    """The words after the agent of a run with restarts or sticky actions; "" without them."""
    return f"{', restarts' if '-restarts' in name else ''}{', sticky actions' if '-sticky-' in name else ''}"


def runs_of_agents() -> dict[str, dict[str, Any]]:
    """The facts of the trainings of each agent, by name."""
    agents: dict[str, dict[str, Any]] = {}
    for name, run in read_runs().items():
        agents.setdefault(run["agent"], {})[name] = run
    return agents


def draw() -> None:
    """Draw a picture for each agent."""
    import matplotlib

    matplotlib.rcParams["svg.hashsalt"] = "curves"  # the same numbers make the same file
    for agent, runs in runs_of_agents().items():
        draw_agent(runs).savefig(DOCS / f"{agent}.svg", metadata={"Date": None})


def draw_agent(runs: dict[str, Any]) -> Any:
    """Draw a panel for each game of an agent's trainings, and return the figure."""
    from matplotlib.figure import Figure

    from atari.learning.pages import draw_levels, draw_published, draw_scores

    by_game: dict[str, list[str]] = {}
    for name, run in runs.items():
        by_game.setdefault(run["game"], []).append(name)
    lines = math.ceil(len(by_game) / 2)
    figure = Figure(figsize=(9, 2.6 * lines + 0.4), layout="constrained")
    panels = figure.subplots(lines, 2, squeeze=False).flatten()
    for axes in panels[len(by_game) :]:
        axes.set_axis_off()
    for axes, (game, names) in zip(panels, by_game.items(), strict=False):
        curves = {name: read_rows(name) for name in names}
        most = max(rows[-1]["frames"] for rows in curves.values())
        draw_published(axes, game, most)
        draw_newer(axes, game, most)
        for name, rows in curves.items():
            kind = runs[name]["agent"] + suffix(name)
            draw_scores(axes, rows, f"this package: {kind}", COLORS[kind])
        draw_levels(axes, game)
        axes.set_title(game, fontsize="medium")
        axes.set_xlabel("million frames", fontsize="small")
    entries: dict[str, Any] = {}
    for axes in panels[: len(by_game)]:
        entries.update(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=4, fontsize="small")
    return figure


def draw_newer(axes: Any, game: str, most: float) -> None:
    """Draw Dopamine's newer curves of a game until `most` frames, in Matplotlib's axes."""
    for name, style in NEWER.items():
        curve = Published(name).curve(game)
        known = curve.frames <= most
        if known.sum() > 1:
            axes.plot(curve.frames[known] / 1e6, curve.mean[known], label=name, linewidth=1, linestyle=style, color="k")


def table() -> None:
    """Print a table for each agent, with a row for each training, beside published scores."""
    for agent, runs in runs_of_agents().items():
        heads = ["game", "M frames", "last 100 games", "100 games after it", *PUBLISHED]
        print(f"`{agent}`\n\n| {' | '.join(heads)} |\n{'|---' * len(heads)}|")
        for name, run in runs.items():
            game, last, scores = run["game"], read_rows(name)[-1], run["scores"]
            error = statistics.stdev(scores) / math.sqrt(len(scores))
            after = f"{statistics.fmean(scores):,.1f} ± {error:,.1f}"
            frames = int(last["frames"])
            beside = [", ".join(_beside(source, game, frames) for source in sources) for sources in PUBLISHED.values()]
            cells = [game + suffix(name), f"{frames / 1e6:.1f}", f"{last['score']:,.1f}", after, *beside]
            print(f"| {' | '.join(cells)} |")
        print()


def _beside(name: str, game: str, frames: int) -> str:
    source = Published(name)
    if game not in source.games:
        return "–"
    if not source.has_curves:
        return f"{source.final(game).mean():,.1f}"
    if frames < source.curve(game).frames[0]:
        return "–"
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
