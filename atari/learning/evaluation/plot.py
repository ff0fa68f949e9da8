"""Plots of comparisons, and of mean scores of variants or agents."""

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from atari.base import durable
from atari.base.extras import import_extra, install_extra
from atari.learning.evaluation.statistics import Estimate, profile

Figure = import_extra("matplotlib.figure", f"plots need Matplotlib: {install_extra('learn')}").Figure

_SUMMARIES = {"median": "median", "iqm": "interquartile mean", "mean": "mean"}


def plot(comparison: Any, file: Path) -> None:
    """Draw the figure of `comparison_figure` into a file.

    Raises:
        ValueError: the file's ending names no format that Matplotlib knows.
        OSError: the file cannot be written.
    """
    _save(comparison_figure(comparison), file)


def comparison_figure(comparison: Any) -> Any:
    """The summaries of a `Comparison` with their intervals of 95 %, and the performance profile of each agent."""
    figure = Figure(figsize=(11, 3.2 + 0.3 * len(comparison.rows)), layout="constrained")
    axes = figure.subplots(1, 4, width_ratios=(1, 1, 1, 2.2))
    for axis, (name, title) in zip(axes, _SUMMARIES.items(), strict=False):
        _draw_summary(axis, comparison, name, title)
        if axis is not axes[0]:
            axis.set_yticklabels([])
    _draw_profiles(axes[-1], comparison)
    title = f"Human-normalised scores ({comparison.human}), games: {len(comparison.games)}"
    if comparison.mixed:
        title = f"MIXED PROTOCOLS OR BUDGETS, not a fair comparison. {title}"
    figure.suptitle(title, fontsize=11, color="firebrick" if comparison.mixed else "black")
    return figure


def plot_scores(games: Mapping[str, Mapping[str, Estimate]], file: Path) -> None:
    """Draw the figure of `score_figure` into a file.

    Raises:
        ValueError: the file's ending names no format that Matplotlib knows.
        OSError: the file cannot be written.
    """
    _save(score_figure(games), file)


def score_figure(games: Mapping[str, Mapping[str, Estimate]]) -> Any:
    """Mean scores with their intervals, one below the other: a part for each game, with its variants or agents."""
    heights = [0.9 + 0.26 * len(named) for named in games.values()]
    figure = Figure(figsize=(7.5, sum(heights)), layout="constrained")
    parts = figure.subplots(len(games), 1, height_ratios=heights, squeeze=False)[:, 0]
    for axis, (game, named) in zip(parts, games.items(), strict=True):
        estimates = list(named.values())
        for number, one in enumerate(estimates):
            low, high = (one.value if limit is None else limit for limit in (one.low, one.high))
            axis.plot([low, high], [number] * 2, color="C0", linewidth=2, alpha=0.5)
            axis.plot(one.value, number, "o", color="C1" if number == 0 else "C0", markersize=5)
        axis.axvline(estimates[0].value, color="C1", linewidth=0.8, linestyle="--")
        axis.set_yticks(range(len(named)), list(named), fontsize=8)
        axis.set_ylim(len(named) - 0.4, -0.6)
        axis.set_title(f"{game}: mean score, interval of 95 %", fontsize=10)
        axis.grid(axis="x", alpha=0.3)
    return figure


def _save(figure: Any, path: Path) -> None:
    image = io.BytesIO()
    figure.savefig(image, dpi=150, format=path.suffix[1:] or None)
    durable.write_file(path, image.getvalue())


def _draw_summary(axis: Any, comparison: Any, name: str, title: str) -> None:
    for number, row in enumerate(comparison.rows):
        estimate = getattr(row, name)
        colour = f"C{number}"
        if estimate.low is not None:
            axis.barh(number, estimate.high - estimate.low, left=estimate.low, height=0.6, color=colour, alpha=0.5)
        axis.plot([estimate.value] * 2, [number - 0.3, number + 0.3], color=colour, linewidth=2)
    axis.set_yticks(range(len(comparison.rows)), [row.name for row in comparison.rows])
    axis.set_ylim(len(comparison.rows) - 0.4, -0.6)
    axis.set_title(title, fontsize=10)
    axis.grid(axis="x", alpha=0.3)


def _draw_profiles(axis: Any, comparison: Any) -> None:
    scores = [comparison.normalised(row) for row in comparison.rows]
    highest = max(float(np.max(runs)) for one in scores for runs in one.values())
    thresholds = np.linspace(0.0, min(max(1.0, highest), 8.0) * 1.02, 400)
    for number, (row, one) in enumerate(zip(comparison.rows, scores, strict=True)):
        axis.plot(thresholds, profile(one, thresholds), color=f"C{number}", label=row.name)
    axis.set_title("performance profile", fontsize=10)
    axis.set_xlabel("human-normalised score")
    axis.set_ylabel("fraction of runs above it")
    axis.set_ylim(-0.02, 1.02)
    axis.grid(alpha=0.3)
    axis.legend(fontsize=8, framealpha=0)
