"""`write_diagnosis`: the folder of a diagnosis: a page with its text, videos of its moments, and the frontier."""

import html
import re
from contextlib import suppress
from pathlib import Path

from gymnasium.error import DependencyNotInstalled

from atari.base import durable
from atari.learning.diagnosis.diagnosis import Diagnosis, Search
from atari.learning.diagnosis.groups import words
from atari.learning.diagnosis.moments import Moment
from atari.learning.diagnosis.search import Part, record_parts
from atari.learning.pages import learning_curves, write_page
from atari.recording import Replay

FRONTIER = "frontier.states"
_OURS = re.compile(r"(lost|saved)-\d+\.(a26r|mp4)|frontier\.states")
_BEFORE = 60
"""The steps of the video of a moment without a continuation."""


def write_diagnosis(diagnosis: Diagnosis, folder: Path) -> Path:
    """Write a diagnosis, and return the path of its page, `index.html`, which needs no server.

    The folder has `diagnosis.txt`; for each moment from which a continuation was searched `lost-N.a26r`, the recorded
    game until then, and `saved-N.a26r`, the continuation, with videos (.mp4) if PyAV is installed; and
    `frontier.states` for `atari train --restart-from`.

    Args:
        diagnosis: the diagnosis.
        folder: the folder; it is made. The files of an earlier diagnosis are removed.

    Raises:
        OSError: a file cannot be written; the message names it.

    Example:
        >>> from pathlib import Path
        >>> from atari.learning import diagnose
        >>> from atari.learning.diagnosis.page import write_diagnosis
        >>> write_diagnosis(diagnose("random", "breakout", games=2, frontiers=0), Path("diagnosis")).name
        'index.html'
    """
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.iterdir():
        if _OURS.fullmatch(old.name):
            old.unlink()
    durable.write_file(folder / "diagnosis.txt", f"{diagnosis}\n".encode())
    if diagnosis.frontier():
        diagnosis.write_frontier(folder / FRONTIER)
    moments = [_moment(diagnosis, number, one, folder) for number, one in enumerate(diagnosis.searches)]
    game = diagnosis.plays.task.definition
    return write_page(
        folder / "index.html",
        _PAGE,
        title=html.escape(f"{diagnosis.policy} in {game.title}: where it stops"),
        score=html.escape(str(diagnosis).splitlines()[0].partition(": ")[2]),
        ends=_listed([words(group, game) for group in diagnosis.groups]),
        moments="".join(moments) or "<p>No continuation was searched.</p>",
        findings=_listed([str(finding) for finding in diagnosis.findings] or ["Nothing stands out."]),
        training=_training(diagnosis),
        options=_options(diagnosis),
        task=html.escape(str(diagnosis.plays.task)),
    )


def _moment(diagnosis: Diagnosis, number: int, one: Search, folder: Path) -> str:
    """The part of the page about a moment: its video beside that of the continuation."""
    plays = diagnosis.plays
    ahead = _BEFORE if one.saved is None else one.saved.ahead
    start = max(-1, one.moment.step - ahead)
    (state,) = plays.states([Moment(one.moment.play, start, one.moment.kind)])
    actions = plays[one.moment.play].actions[start + 1 : one.moment.step + 1]
    record_parts(folder / f"lost-{number}.a26r", plays.player, [Part(state, actions)])
    videos = [_video(folder / f"lost-{number}", "The game that was played.")]
    if one.saved is None:
        text = "No continuation was found. That is no proof that there is none."
    else:
        one.saved.write(folder / f"saved-{number}.a26r", plays.player)
        videos.append(_video(folder / f"saved-{number}", f"A continuation, found by {one.saved.way}."))
        text = str(one.saved)
    figures, points = "".join(videos), plays[one.moment.play].totals[one.moment.step]
    return (
        f"<h3>Game {one.moment.play}, at {points:,} points</h3>\n<p>{html.escape(text)}</p>\n"
        f'<div class="pair">{figures}</div>\n'
    )


def _video(path: Path, caption: str) -> str:
    """The video of a replay with its caption; a link to the replay without PyAV."""
    video = path.with_suffix(".mp4")
    with suppress(DependencyNotInstalled):
        Replay.load(path.with_suffix(".a26r")).render(video)
        return (
            f'<figure><video autoplay muted loop controls playsinline src="{video.name}"></video>'
            f"<figcaption>{html.escape(caption)}</figcaption></figure>"
        )
    video.unlink(missing_ok=True)
    return f'<p><a href="{path.name}.a26r">{path.name}.a26r</a>: {html.escape(caption)}</p>'


def _training(diagnosis: Diagnosis) -> str:
    """The learning curve of a run folder, and when its score stood still."""
    if diagnosis.run is None:
        return "<p>There is no log: the policy is not a run folder.</p>"
    from atari.learning.run_folder import RunFolder

    rows = RunFolder.open(diagnosis.run).rows()
    text = "" if diagnosis.standstill is None else f"<p>{html.escape(str(diagnosis.standstill))}</p>"
    try:
        curve = learning_curves(diagnosis.plays.task.game, [("this run", "#c2410c", rows)])
    except ImportError:
        curve = "<p>There is no curve: Matplotlib is not installed.</p>"
    return f"{text}\n{curve}"


def _options(diagnosis: Diagnosis) -> str:
    if not diagnosis.options:
        return "<p>Nothing follows from this.</p>"
    return "<ul>" + "".join(f"<li><code>{html.escape(option)}</code>" for option in diagnosis.options) + "</ul>"


def _listed(texts: list[str]) -> str:
    return "<ul>" + "".join(f"<li>{html.escape(text)}" for text in texts) + "</ul>"


_PAGE = """\
<style>
  .pair { display: flex; flex-wrap: wrap; gap: 1rem; }
  .pair figure { margin: 0; flex: 1 1 18rem; max-width: 480px; }
  figcaption { font-size: 0.85rem; opacity: 0.8; }
  li { margin: 0.4rem 0; }
</style>
<p>$score</p>
<h2>Where games end</h2>
$ends
<h2>Moments and continuations</h2>
$moments
<h2>What the agent does</h2>
$findings
<h2>The training</h2>
$training
<h2>Options of <code>atari train</code> to try</h2>
$options
<details><summary>What was played</summary><pre>$task</pre></details>
"""
