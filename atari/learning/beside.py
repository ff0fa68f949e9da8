"""A page about agents, or variants of a game, beside each other: scores with intervals, and a game of each agent."""

import base64
import html
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from atari.learning.evaluation.compare import Comparison
from atari.learning.evaluation.evaluate import record_games
from atari.learning.evaluation.played import EvaluatedGame
from atari.learning.evaluation.protocols import EvaluationProtocol
from atari.learning.evaluation.results import GameResult, estimates_of, score_rows
from atari.learning.pages import comparison_part, drawing, write_page
from atari.recording import Replay

_MOST_FRAMES = 7200
"""Frames of a video: two minutes of a game may be a megabyte, and the page contains the videos."""

Tables = Mapping[str, Mapping[str, GameResult]]
"""By game, the results of agents or variants by their names."""


def write_scores(
    path: Path,
    title: str,
    tables: Tables,
    *,
    about: Sequence[str],
    videos: Mapping[tuple[str, str], str],
    not_played: Mapping[str, str],
    comparison: Comparison | None = None,
) -> Path:
    """Write the page, one file that needs no server, and return its path.

    Args:
        path: the file.
        title: its title.
        tables: the results.
        about: sentences on how the games were played.
        videos: the HTML of `median_game` by game and name.
        not_played: agents that did not play, and the reason.
        comparison: the agents beside published ones.

    Raises:
        gymnasium.error.DependencyNotInstalled: Matplotlib is not installed.
        OSError: the file cannot be written.
    """
    parts = [_part(game, named, [videos.get((game, name), "") for name in named]) for game, named in tables.items()]
    reasons = _listed([f"{name}: {reason}" for name, reason in not_played.items()])
    left_out = f"<h2>Not played</h2>\n{reasons}" if not_played else ""
    compared = "" if comparison is None else comparison_part(comparison)
    values = {"parts": "\n".join(parts), "left_out": left_out, "compared": compared}
    return write_page(path, _PAGE, title=html.escape(title), about=_listed(about), **values)


def median_game(policy: Any, game: EvaluatedGame, protocol: EvaluationProtocol, result: GameResult, name: str) -> str:
    """The game of an agent whose score is the median, as a video in a figure, HTML.

    With an even number of games it is the lower one of the two in the middle. The video begins with the last frame of
    the first step: the frames of the reset may have other colours.

    Raises:
        gymnasium.error.DependencyNotInstalled: PyAV is not installed.
    """
    order = sorted(range(len(result.scores)), key=lambda number: result.scores[number])
    number = order[(len(order) - 1) // 2]
    with TemporaryDirectory() as folder:
        file = Path(folder) / "median"
        record_games(policy, game, protocol, [result.seeds[number]], file.with_suffix(".a26r"))
        replay = Replay.load(file.with_suffix(".a26r"), game=game.task.definition)
        start = next(frame.index for frame in replay.frames() if frame.ends_step)
        stop = min(replay.frames_total, start + _MOST_FRAMES)
        replay.render(file.with_suffix(".mp4"), scale=1, start=start, stop=stop)
        data = base64.b64encode(file.with_suffix(".mp4").read_bytes()).decode()
    part = "" if stop == replay.frames_total else ", its first two minutes"
    caption = f"{html.escape(name)}: {result.scores[number]:,.1f}, game {number}{part}"
    source = f'src="data:video/mp4;base64,{data}"'
    return (
        f"<figure><video controls loop muted playsinline {source}></video><figcaption>{caption}</figcaption></figure>"
    )


def _part(game: str, named: Mapping[str, GameResult], videos: list[str]) -> str:
    from atari.learning.evaluation.plot import score_figure  # here, because it imports Matplotlib

    head, *rows = (tuple(html.escape(str(cell)) for cell in row) for row in score_rows("", named))
    lines = [f"<tr>{''.join(f'<th>{cell}' for cell in head)}", *(f"<tr>{_cells(row)}" for row in rows)]
    plot = drawing(score_figure(estimates_of({game: named})), "mean scores with intervals")
    shown = "".join(videos)
    median = f"<h3>The game with the median score</h3>\n<div class=beside>{shown}</div>" if shown else ""
    table = f"<div class=wide><table>{''.join(lines)}</table></div>"
    return f"<h2>{html.escape(game)}</h2>\n{table}\n{plot}\n{median}"


def _listed(sentences: Sequence[str]) -> str:
    return f"<ul>{''.join(f'<li>{html.escape(sentence)}' for sentence in sentences)}</ul>"


def _cells(row: tuple[str, ...]) -> str:
    return "".join(f"<td>{cell}" for cell in row)


_PAGE = """\
<style>
  h1, li { overflow-wrap: anywhere; }
  .beside { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 17rem), 1fr)); gap: 1rem; }
  figure { margin: 0; }
  figcaption { font-size: 0.85rem; overflow-wrap: anywhere; }
</style>
<p>In brackets is the interval of 95 %. A difference is to the first row, of games with equal seeds.</p>
$parts
$compared
$left_out
<h2>How the games were played</h2>
$about
"""
