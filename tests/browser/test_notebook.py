"""Replays in a notebook that nbconvert has written: the page plays in its frame, with sound after a click."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browser_tools import LIMIT, wait_until
from replay_tools import record

from atari.recording import Replay
from atari.web.shelf import PARTS

pytest.importorskip("playwright.sync_api")
nbformat = pytest.importorskip("nbformat")
nbconvert = pytest.importorskip("nbconvert")
if not (PARTS / "core.wasm").exists():
    pytest.skip("the package has no page; run ./scripts/web and install it", allow_module_level=True)


@pytest.fixture
def notebook(tmp_path: Path) -> Path:
    """A notebook with two replays, as HTML."""
    cells = []
    for game in ("breakout", "pong"):
        shown = Replay.load(record(tmp_path / f"{game}.a26r", game, 300))._repr_html_()
        output = nbformat.v4.new_output("display_data", {"text/plain": "a replay", "text/html": shown})
        cells.append(nbformat.v4.new_code_cell("replay", outputs=[output]))
    exporter = nbconvert.HTMLExporter()
    exporter.require_js_url = exporter.mathjax_url = exporter.mermaid_js_url = ""  # no request to another host
    page, _ = exporter.from_notebook_node(nbformat.v4.new_notebook(cells=cells))
    path = tmp_path / "notebook.html"
    path.write_text(page, encoding="utf-8")
    return path


@pytest.fixture
def page(browser: Any, notebook: Path) -> Iterator[Any]:
    """The notebook in a browser. None of its frames may report an error."""
    faults: list[str] = []
    context = browser.new_context(viewport={"width": 1000, "height": 1600})
    context.set_default_timeout(1000 * LIMIT)
    page = context.new_page()
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.goto(notebook.as_uri())
    yield page
    context.close()
    assert faults == []


def value(frame: Any, expression: str) -> Any:
    return frame.evaluate(f"((app) => {expression})(window.atariPage)")


PICTURE = """() => { const canvas = document.querySelector("canvas");
return canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.join(); }"""


def test_two_replays_play_with_sound(page: Any) -> None:
    frames = [frame for frame in page.frames if frame.parent_frame]
    assert len(frames) == 2
    for frame, game in zip(frames, ["breakout", "pong"], strict=True):
        wait_until(page, lambda frame=frame: value(frame, "app?.play?.frame > 3"))  # type: ignore[misc]
        assert value(frame, "[app.play.entry.id, app.play.isFilm, app.sound.state]") == [game, True, "none"]
        before = frame.evaluate(PICTURE)
        wait_until(page, lambda frame=frame, before=before: frame.evaluate(PICTURE) != before)  # type: ignore[misc]
        frame.evaluate("""() => { const push = atariPage.sound.push.bind(atariPage.sound); window.pushed = 0;
        atariPage.sound.push = (samples) => { window.pushed += samples.length; push(samples); }; }""")
        frame.locator("canvas").first.click()
        wait_until(page, lambda frame=frame: value(frame, "app.sound.state === 'running'"))  # type: ignore[misc]
        wait_until(page, lambda frame=frame: frame.evaluate("window.pushed") >= 10 * 512)  # type: ignore[misc]
    assert value(frames[0], "app.play.entry.id") == "breakout"


def test_the_frames_reach_neither_each_other_nor_the_notebook(page: Any) -> None:
    for frame in (frame for frame in page.frames if frame.parent_frame):
        wait_until(page, lambda frame=frame: value(frame, "app?.play?.frame > 3"))  # type: ignore[misc]
        assert (
            frame.evaluate("""() => { try { return parent.document.title; } catch { return "refused"; } }""")
            == "refused"
        )
        assert (
            frame.evaluate("""() => { try { return localStorage.length; } catch { return "refused"; } }""") == "refused"
        )
