"""The end of a training: an evaluation, the best game, and a page about both, in the run folder."""

import html
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from gymnasium.error import DependencyNotInstalled

from atari.learning.evaluation.evaluate import evaluate, record_games
from atari.learning.evaluation.results import Result
from atari.learning.pages import learning_curves, write_page
from atari.learning.policies import load_policy
from atari.learning.run_folder import RunFolder
from atari.learning.run_policy import training_protocol
from atari.recording import Replay


def finish(folder: RunFolder, episodes: int = 30, progress: Callable[[int, int], Any] | None = None) -> Result:
    """Evaluate the policy of a run folder, record its best game, and write `report.html`.

    Writes `evaluation.json`, `best.a26r` and, if PyAV is installed, `best.mp4` with sound.

    Raises:
        FileNotFoundError, ValueError: the folder is damaged, or the training has written no policy yet.
    """
    policy, task = load_policy(folder.path), folder.task
    result = evaluate(policy, task, training_protocol(folder), episodes=episodes, progress=progress)
    result.save(folder.path / "evaluation.json")
    played = result.games[0]
    best = played.seeds[max(range(episodes), key=lambda index: played.scores[index])]
    record_games(policy, task, result.protocol, [best], folder.path / "best.a26r")
    replay = Replay.load(folder.path / "best.a26r")
    try:
        replay.render(folder.path / "best.mp4")
    except DependencyNotInstalled:  # PyAV is not installed: the replay is enough
        (folder.path / "best.mp4").unlink(missing_ok=True)
    write_report(folder, result)
    return result


def write_report(folder: RunFolder, result: Result) -> Path:
    """Write `report.html`, which needs no server, and return its path."""
    rows, config, task = folder.rows(), folder.config, folder.task
    game, kind = task.definition, "pixels" if task.kind.image else "RAM"
    played = result.games[0]
    if not rows:
        raise ValueError(f"{folder.path / 'log.csv'} has no rows: the training was stopped before its first update")
    last = rows[-1]
    video = '<video controls loop src="best.mp4#t=3"></video>' if (folder.path / "best.mp4").exists() else ""
    return write_page(
        folder.path / "report.html",
        _PAGE,
        title=html.escape(f"{config['agent'].upper()} on {game.title}, from {kind}"),
        score=f"{played.mean:,.1f}",
        episodes=len(played.scores),
        steps=f"{last['step']:,.0f}",
        frames=f"{last['frames']:,.0f}",
        time=_duration(last["seconds"]),
        curve=learning_curves(game.id, [("this run", "#c2410c", rows)]),
        video=video,
        best=f"{max(played.scores):,.0f}",
        protocol=html.escape(str(result.protocol)),
        scores=html.escape(str(result).partition("\n\n")[2]),
        task=html.escape(str(task)),
        options=_table(config["options"]),
        versions=_table(config["versions"]),
    )


def _table(facts: Mapping[str, Any]) -> str:
    rows = (f"<tr><th>{html.escape(str(key))}<td>{html.escape(str(value))}" for key, value in facts.items())
    return f"<table>{''.join(rows)}</table>"


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {rest} s" if minutes else f"{rest} s"


_PAGE = """\
<dl>
  <div><dt>mean score of $episodes whole games after training<dd>$score</div>
  <div><dt>agent steps<dd>$steps</div>
  <div><dt>frames<dd>$frames</div>
  <div><dt>time of training<dd>$time</div>
</dl>
<h2>Learning curve</h2>
$curve
<h2>The best game</h2>
<p>The best of the $episodes games had a score of $best. <code>best.a26r</code> is its replay.</p>
$video
<h2>Evaluation</h2>
<p>$protocol</p>
<pre>$scores</pre>
<details><summary>What was played in the training</summary><pre>$task</pre></details>
<details><summary>Options of the training</summary>$options</details>
<details><summary>Versions</summary>$versions</details>
"""
