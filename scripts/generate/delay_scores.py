#!/usr/bin/env python
"""Scores the shipped policies over delays of their actions, and draws the result.

    scripts/generate/delay_scores.py play --games breakout    # adds rows to docs/delays.csv
    scripts/generate/delay_scores.py draw                     # docs/delays.svg

A policy, which was trained without a delay, plays whole games by the protocol `dopamine` with an `action_delay`. It
needs the extra `learn`.
"""

import argparse
import csv
import math
import statistics
from pathlib import Path

from atari import Task
from atari.learning import evaluate

ROOT = Path(__file__).resolve().parents[2]
TABLE = ROOT / "docs" / "delays.csv"
COLUMNS = ("game", "delay", "episodes", "mean", "stderr")
GAMES = ("breakout", "space_invaders", "qbert")
"""The games of the policies `examples/GAME-pqn`."""


def play(games: list[str], delays: list[int], episodes: int) -> None:
    """Play the games, and add a row for each game and delay."""
    for game in games:
        for delay in delays:
            policy, task = str(ROOT / "examples" / f"{game}-pqn"), Task.of(game, action_delay=delay)
            result = evaluate(policy, task, "dopamine", episodes=episodes, num_threads=1)[game]
            error = statistics.stdev(result.scores) / math.sqrt(episodes)
            values = (game, delay, episodes, round(result.mean, 1), round(error, 1))
            row = dict(zip(COLUMNS, values, strict=True))
            new = not TABLE.exists()
            with TABLE.open("a", newline="") as file:
                writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
                if new:
                    writer.writeheader()
                writer.writerow(row)
            print(row, flush=True)


def draw() -> None:
    """Draw the mean of each game, as a part of the mean without a delay, with its standard error."""
    import matplotlib

    matplotlib.rcParams["svg.hashsalt"] = "delays"  # the same numbers make the same file
    from matplotlib.figure import Figure

    with TABLE.open(newline="") as file:
        rows = [
            {name: row[name] if name == "game" else float(row[name]) for name in COLUMNS}
            for row in csv.DictReader(file)
        ]
    figure = Figure(figsize=(7, 3.6), layout="constrained")
    axes = figure.subplots()
    for game in dict.fromkeys(row["game"] for row in rows):
        own = sorted((row for row in rows if row["game"] == game), key=lambda row: row["delay"])
        whole = own[0]["mean"]
        delays, means, errors = ([row[name] for row in own] for name in ("delay", "mean", "stderr"))
        axes.errorbar(
            delays,
            [mean / whole for mean in means],
            [error / whole for error in errors],
            label=f"{game}, {whole:,.0f} without a delay",
            capsize=2,
            marker=".",
        )
    axes.set_xlabel("action_delay, frames of 1/60 s")
    axes.set_ylabel("score / score without a delay")
    axes.set_ylim(0)
    axes.legend(fontsize="small")
    figure.savefig(TABLE.with_suffix(".svg"), metadata={"Date": None})


def main() -> None:
    """Run a command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=["play", "draw"])
    parser.add_argument(
        "--games", default=",".join(GAMES), help="play: names with commas between (default: %(default)s)"
    )
    parser.add_argument("--delays", default="0-12", help="play: the range of delays (default: %(default)s)")
    parser.add_argument("--episodes", type=int, default=30, help="play: games of each delay (default: %(default)s)")
    args = parser.parse_args()
    if args.command == "draw":
        draw()
    else:
        low, high = map(int, args.delays.split("-"))
        play(args.games.split(","), list(range(low, high + 1)), args.episodes)


if __name__ == "__main__":
    main()
