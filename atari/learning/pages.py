"""Pages about trainings and policies, HTML that needs no server, and their learning curves."""

import html
import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from string import Template
from typing import Any

from atari.base import durable
from atari.learning.evaluation.compare import Comparison
from atari.learning.evaluation.published import Published
from atari.learning.options import WINDOW

CURVES = ("dopamine/dqn", "dopamine/rainbow", "dreamerv3/atari57/ppo")
"""Published learning curves that are drawn beside the training's."""


def write_page(path: Path, body: str, **values: object) -> Path:
    """Write a page whose body has the values in place of their names, with the title among them; return its path."""
    page = Template(_HEAD + body + "</html>\n").substitute(style=_STYLE, **values)
    durable.write_file(path, page.encode())
    return path


def learning_curves(game: str, logs: Sequence[tuple[str, str, Sequence[Mapping[str, float]]]]) -> str:
    """A picture, HTML: the scores of trainings over frames, with published curves, random play and a human.

    Without a score there is only a sentence, because no game has ended.

    Args:
        game: the game's name.
        logs: the label, the color and the rows of the log of each training.

    Raises:
        ImportError: Matplotlib is not installed.
    """
    from matplotlib.figure import Figure

    if not any(map(_with_scores, (rows for _, _, rows in logs))):
        return "<p>No game has ended in the training, so there is no curve yet.</p>"
    figure = Figure(figsize=(8, 4.5), layout="constrained")
    axes: Any = figure.add_subplot()
    published = draw_published(axes, game, max((rows[-1]["frames"] for _, _, rows in logs if rows), default=0))
    for label, color, rows in logs:
        draw_scores(axes, rows, label, color)
    draw_levels(axes, game)
    axes.set_xlabel("million frames")
    axes.set_ylabel("score of whole games")
    axes.legend(fontsize="small", framealpha=0)
    about = f"Mean score of the last whole games, {WINDOW} if all environments are scored, all lives, not clipped."
    others = " Published curves are of other protocols, with the same number of frames." if published else ""
    return f"<p>{about}{others}</p>\n{drawing(figure, 'learning curves')}"


def drawing(figure: Any, label: str) -> str:
    """A figure of Matplotlib as an element of a page, SVG: black becomes the page's color of text, on its ground.

    Args:
        figure: the figure; its legends have no ground of their own.
        label: what it shows, for screen readers.
    """
    text = io.StringIO()
    figure.savefig(text, format="svg", transparent=True)
    content = text.getvalue().partition("<svg")[2].replace("#000000", "currentColor")
    return f'<svg role="img" aria-label="{html.escape(label)}"{content}'


def comparison_part(comparison: Comparison) -> str:
    """A comparison as a part of a page, HTML: its drawing and its tables.

    Raises:
        gymnasium.error.DependencyNotInstalled: Matplotlib is not installed.
    """
    from atari.learning.evaluation.plot import comparison_figure  # here, because it imports Matplotlib

    plot = drawing(comparison_figure(comparison), "normalised scores with intervals")
    return f"<h2>Comparison</h2>\n{plot}\n<div class=wide>{comparison._repr_html_()}</div>"


def draw_published(axes: Any, game: str, most: float) -> int:
    """Draw published curves of a game until `most` frames, in Matplotlib's axes, and return their number."""
    drawn = 0
    for name in CURVES:
        if name in Published.names() and game in Published(name).games:
            curve = Published(name).curve(game)
            known = curve.frames <= most
            if known.sum() > 1:
                axes.plot(curve.frames[known] / 1e6, curve.mean[known], label=name, linewidth=1)
                drawn += 1
    return drawn


def draw_levels(axes: Any, game: str) -> None:
    """Draw the scores of random play and of a human, unless they are so far above the curves that these look flat."""
    low, high = axes.get_ylim()
    for name, score in zip(("random", "human"), Published.human_scores().get(game, ()), strict=False):
        if score <= high + (high - low):
            axes.axhline(score, color="gray", linewidth=0.8, linestyle=":" if name == "random" else "--", label=name)
    axes.grid(alpha=0.3)


def draw_scores(axes: Any, rows: Sequence[Mapping[str, float]], label: str, color: str) -> None:
    """Draw the scores in a training's log over frames, in Matplotlib's axes."""
    if shown := _with_scores(rows):
        frames, scores = [row["frames"] / 1e6 for row in shown], [row["score"] for row in shown]
        axes.plot(frames, scores, label=label, color=color, marker="o" if len(shown) == 1 else None)


def _with_scores(rows: Sequence[Mapping[str, float]]) -> list[Mapping[str, float]]:
    return [row for row in rows if not math.isnan(row["score"])]


_STYLE = """
  :root { color-scheme: light dark; --line: #8884; }
  body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 0 auto; padding: 1rem; }
  h1 { font-size: 1.6rem; margin: 0.5rem 0; }
  dl { display: flex; flex-wrap: wrap; gap: 0.5rem 2rem; margin: 1rem 0; }
  dt { font-size: 0.8rem; opacity: 0.7; }
  dd { margin: 0; font-size: 1.4rem; font-variant-numeric: tabular-nums; }
  svg { width: 100%; height: auto; fill: currentColor; }
  video { width: 100%; max-width: 480px; display: block; image-rendering: pixelated; background: black; }
  pre { overflow-x: auto; padding: 0.75rem; border: 1px solid var(--line); font-size: 0.85rem; }
  details { margin: 0.5rem 0; }
  table { border-collapse: collapse; font-size: 0.85rem; }
  th, td { text-align: left; padding: 0.15rem 1rem 0.15rem 0; border-bottom: 1px solid var(--line);
    vertical-align: top; overflow-wrap: anywhere; }
  .wide { overflow-x: auto; }
  .wide th, .wide td { white-space: nowrap; overflow-wrap: normal; font-variant-numeric: tabular-nums; }
  img { max-width: 100%; }
"""

_HEAD = """\
<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>$title</title>
<style>$style</style>
<h1>$title</h1>
"""
