"""What cells of a notebook show in the HTML that nbconvert writes: screens with their aspect, the inspector, a video."""

import base64
import json
from pathlib import Path
from typing import Any

import pytest
from browser_tools import wait_until

import atari
from atari.lab import widget
from atari.lab.inspector import protocol
from atari.lab.inspector.inspection import Inspection

for needed in ("playwright.sync_api", "anywidget", "av", "ipykernel", "nbclient", "nbconvert"):
    pytest.importorskip(needed)

PREPARED = """
import gymnasium
import numpy as np
import atari
from atari.lab import show
from atari.recording import RecordReplay, Replay

def played(env):
    env.reset(seed=0)
    return env
"""
CELLS = {
    "make": ("played(atari.make('breakout', preset='dqn2015'))", [(1, 1, 210)]),
    "gymnasium.make": ("played(gymnasium.make('ALE/AirRaid-v5'))", [(1, 1, 250)]),
    "vector": ("played(atari.AtariVectorEnv('pong', 3))", [(2, 2, 210)]),
    "wrapped vector": ("played(gymnasium.make_vec('ALE/Pong-v5', num_envs=2))", [(2, 1, 210)]),
    "single environments": (
        "played(gymnasium.make_vec('ALE/Pong-v5', num_envs=2, vectorization_mode='sync'))",
        [(1, 1, 210)] * 2,
    ),
    "show": ("show(played(atari.make('pong')))", [(1, 1, 210)]),
    "video": (
        "with RecordReplay(atari.make('pong'), 'game.a26r') as env:\n    played(env)\n    for _ in range(30):\n"
        "        env.step(2)\nReplay.load('game.a26r').video()",
        [(1, 1, 210)],
    ),
}
"""Each cell, and the screens that it shows: a grid of columns and rows, and the lines of a screen."""


@pytest.fixture(scope="module")
def notebook(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The notebook with its outputs, as HTML without scripts of other hosts."""
    import nbclient
    import nbconvert
    import nbformat

    folder = tmp_path_factory.mktemp("notebook")
    cells = [nbformat.v4.new_code_cell(source) for source in (PREPARED, *(source for source, _ in CELLS.values()))]
    made = nbformat.v4.new_notebook(cells=cells)
    nbclient.NotebookClient(made, timeout=300, resources={"metadata": {"path": str(folder)}}).execute()
    exporter = nbconvert.HTMLExporter()
    exporter.require_js_url = exporter.mathjax_url = exporter.mermaid_js_url = exporter.jupyter_widgets_base_url = ""
    page, _ = exporter.from_notebook_node(made)
    path = folder / "notebook.html"
    path.write_text(page, encoding="utf-8")
    return path


@pytest.fixture
def page(browser: Any, notebook: Path) -> Any:
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    context.route("http*://**", lambda route: route.abort())
    page = context.new_page()
    page.goto(notebook.as_uri())
    yield page
    context.close()


SIZES = """(cell) => [...cell.querySelectorAll("img, video")].map((shown) => {
const { width, height } = shown.getBoundingClientRect(); return [width, height]; })"""


@pytest.mark.parametrize("width", [1280, 390])
def test_pixels_are_twice_as_wide_as_high(page: Any, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 900})
    wait_until(page, lambda: page.evaluate("[...document.querySelectorAll('video')].every((one) => one.readyState)"))
    shown = page.locator(".jp-CodeCell").evaluate_all(f"(cells) => cells.map({SIZES})")[1:]
    assert len(shown) == len(CELLS)
    for (name, (_, screens)), sizes in zip(CELLS.items(), shown, strict=True):
        assert len(sizes) == len(screens), name
        for (columns, rows, lines), (across, down) in zip(screens, sizes, strict=True):
            assert across / down == pytest.approx(columns * 320 / (rows * lines), rel=0.01), name
            assert 100 < across <= width, name


def test_the_video_has_sound(page: Any) -> None:
    video = page.locator("video")
    video.scroll_into_view_if_needed()
    video.evaluate("(video) => void video.play()")
    wait_until(page, lambda: video.evaluate("(video) => video.currentTime > 0.2 && video.webkitAudioDecodedByteCount"))


def test_the_inspector_hides_its_picture_when_a_kernel_answers(page: Any) -> None:
    number = list(CELLS).index("show") + 1
    cell = page.locator(".jp-CodeCell").nth(number)
    picture = cell.locator("[id^=atari-lab-]")
    assert picture.is_visible()
    assert "Pong, frame 0, score 0" in picture.inner_text()
    assert picture.locator("td").count() == 128
    view = cell.locator(".jp-OutputArea").evaluate_handle(
        "(area) => area.appendChild(document.createElement('section'))"
    )
    module = "data:text/javascript;base64," + base64.b64encode(widget.bundle().encode()).decode()
    page.evaluate(
        """async ([el, module]) => {
        window.sent = [];
        const model = { send: (message) => sent.push(message), on: (_, call) => (window.answer = call), off: () => {} };
        const { default: widget } = await import(module);
        widget.render({ model, el });
        }""",
        [view, module],
    )
    assert page.evaluate("sent") == [{"do": "open"}]
    assert picture.is_visible()  # a view without a kernel
    answer = {**protocol.hello(Inspection(atari.make("pong"))), "picture": picture.get_attribute("id")}
    page.evaluate("(answer) => window.answer(answer, [])", json.loads(json.dumps(answer)))
    assert not picture.is_visible()
    assert cell.locator("section.ram").is_visible()
