"""The page in frames of other pages: keys, storage that is forbidden, several frames, small frames."""

from collections.abc import Callable, Iterator
from html import escape
from pathlib import Path
from typing import Any

import pytest
from browser_tools import wait_until
from page_tools import served
from web_tools import BUILD

playwright = pytest.importorskip("playwright.sync_api")
if not (BUILD / "atari.html").exists():
    pytest.skip("the page is not built; run ./scripts/web --python PYTHON", allow_module_level=True)

SOURCES = {
    "site": 'src="page/#game=catch"',
    "file": 'src="page/atari.html"',
    "sandbox": 'src="page/atari.html" sandbox="allow-scripts"',
    "srcdoc": None,
    "srcdoc in a sandbox": 'sandbox="allow-scripts"',
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the page in the folder `page`."""
    made = tmp_path_factory.mktemp("frames")
    (made / "page").symlink_to(BUILD)
    return made


@pytest.fixture(scope="module")
def site(folder: Path) -> Iterator[str]:
    """The address of the folder on a server."""
    with served(folder) as address:
        yield address


def framed(folder: Path, *sources: str, size: tuple[int, int] = (480, 420)) -> None:
    """Write a page with frames."""
    frames = []
    for source in sources:
        attributes = SOURCES.get(source, source)
        if source.startswith("srcdoc"):
            attributes = f'{attributes or ""} srcdoc="{escape((BUILD / "atari.html").read_text())}"'
        frames.append(f'<iframe width="{size[0]}" height="{size[1]}" {attributes}></iframe>')
    text = f'<!doctype html><link rel="icon" href="data:,"><body style="height: 3000px">{"".join(frames)}'
    (folder / "index.html").write_text(text)


def value(frame: Any, expression: str) -> Any:
    """The value of an expression of the `app` of a frame."""
    return frame.evaluate(f"((app) => {expression})(window.atariPage)")


def playing(page: Any, number: int = 0) -> Any:
    """The frame of a number, after it has played."""
    frame = page.frames[number + 1]
    wait_until(page, lambda: value(frame, "!!app?.play && app.play.session.facts().frame > 5"))
    return frame


@pytest.mark.parametrize("source", SOURCES)
def test_a_frame_plays(new_page: Callable[..., Any], folder: Path, site: str, source: str) -> None:
    framed(folder, source)
    page = new_page(site)
    frame = playing(page)
    assert value(frame, "app.message.textContent") == ""
    page.evaluate("document.querySelector('iframe').focus()")
    page.keyboard.down("ArrowRight")  # scrolls, as anywhere in the page around it
    page.keyboard.press("p")
    page.keyboard.up("ArrowRight")
    assert value(frame, "[app.paused, app.play.isPlayed]") == [False, False]
    page.mouse.click(240, 120)
    page.keyboard.down("ArrowRight")
    wait_until(page, lambda: value(frame, "app.play.isPlayed"))
    page.keyboard.up("ArrowRight")
    page.keyboard.press("p")
    assert value(frame, "app.paused")
    wait_until(page, lambda: value(frame, "app.sound.state === 'running'"))
    frame.evaluate("atariPage.keeper.keep()")
    assert value(frame, "app.message.textContent") == ""


def test_the_stage_can_be_reached_by_keys(new_page: Callable[..., Any], folder: Path, site: str) -> None:
    framed(folder, "site")
    page = new_page(site)
    frame = playing(page)
    frame.focus(".stage")
    page.keyboard.press("p")
    assert value(frame, "app.paused")


def test_frames_do_not_interfere(new_page: Callable[..., Any], folder: Path, site: str) -> None:
    framed(folder, "site", "site", "srcdoc")
    page = new_page(site)
    frames = [playing(page, number) for number in range(3)]
    page.mouse.click(240, 120)
    page.keyboard.press("p")
    assert [value(frame, "app.paused") for frame in frames] == [True, False, False]
    assert [value(frame, "app.sound.state") for frame in frames] == ["running", "none", "none"]
    for frame in frames:
        frame.evaluate("atariPage.setPaused(true)")
    page.reload()  # each begins again, as its page says
    frames = [playing(page, number) for number in range(3)]
    assert not any(value(frame, "app.paused") for frame in frames)


def test_a_frame_without_an_address_gives_no_link(new_page: Callable[..., Any], folder: Path, site: str) -> None:
    framed(folder, "srcdoc")
    page = new_page(site)
    frame = playing(page)
    frame.get_by_role("button", name="Link to this moment").click()
    playwright.expect(frame.locator(".message")).to_have_text(
        "This frame has no address for a link; save the replay instead."
    )


@pytest.mark.parametrize("size", [(320, 300), (480, 420), (640, 360)])
def test_a_small_frame(new_page: Callable[..., Any], folder: Path, site: str, size: tuple[int, int]) -> None:
    framed(folder, "site", size=size)
    frame = playing(new_page(site))
    frame.evaluate("atariPage.watch(atariPage.play.session.replay())")
    wait_until(frame.page, lambda: value(frame, "app.play.isReplay"))
    frame.page.wait_for_timeout(100)
    assert frame.evaluate("document.documentElement.scrollWidth") <= size[0]
    for selector in (".screen", "[type=range]", "button.primary:not(.replay *)"):
        box = frame.evaluate(
            """(selector) => { const box = document.querySelector(selector).getBoundingClientRect();
            return [box.left, box.top, box.right, box.bottom]; }""",
            selector,
        )
        assert min(box) >= 0, (selector, box)
        assert box[2] <= size[0], (selector, box)
        assert box[3] <= size[1], (selector, box)
