"""The inspector's page with a hostile game file, and after errors. Run by scripts/test --browser."""

import asyncio
import logging
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browser_tools import LIMIT, wait_until

import atari

pytest.importorskip("aiohttp")
playwright = pytest.importorskip("playwright.sync_api")

from atari.lab.inspector.inspection import Inspection  # noqa: E402
from atari.lab.inspector.server import Inspector  # noqa: E402
from atari.lab.widget import static_html  # noqa: E402

expect = playwright.expect
SCRIPT = "<script>window.hacked = 1</script>"
IMAGE = "<img src=x onerror=window.hacked=1>"


@pytest.fixture
def inspector(tmp_path: Path) -> Iterator[Inspector]:
    """The server of a game whose title, labels and notes are HTML with scripts."""
    text = (Path(atari.games.__path__[0]) / "data" / "breakout.toml").read_text(encoding="utf-8")
    text = text.replace('title = "Breakout"', f"title = '{SCRIPT}{IMAGE}'", 1).replace(
        "notes = []", f"notes = ['{SCRIPT}']", 1
    )
    text = text.replace("lives = {index", f"'{IMAGE}' = {{index", 1).replace(
        "ball_x = {index", "'__proto__' = {index", 1
    )
    file = tmp_path / f"a'{chr(34)};b=c.toml"
    file.write_text(text, encoding="utf-8")
    found = Inspector(Inspection(atari.AtariEnv(file, frameskip=1), seed=0))
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    asyncio.run_coroutine_threadsafe(found.start(), loop).result(20)
    yield found
    asyncio.run_coroutine_threadsafe(found.stop(), loop).result(20)
    loop.call_soon_threadsafe(loop.stop)
    thread.join()
    loop.close()


@pytest.fixture
def page(browser: Any, inspector: Inspector) -> Iterator[Any]:
    """The page, in which no script of the file may run and no request may fail."""
    context = browser.new_context(accept_downloads=True)
    context.set_default_timeout(1000 * LIMIT)
    shown = context.new_page()
    faults: list[str] = []
    shown.on("pageerror", lambda error: faults.append(str(error)))
    shown.on("console", lambda message: faults.append(message.text) if message.type == "error" else None)
    shown.on("dialog", lambda dialog: faults.append(dialog.message))
    shown.goto(inspector.url)
    expect(shown.locator("h1")).to_have_text(f"{SCRIPT}{IMAGE}")
    yield shown
    assert shown.evaluate("window.hacked") is None
    assert shown.locator("script:not([src]), img").count() == 0
    context.close()
    assert faults == []


def test_texts_of_the_file_are_texts_of_the_page(page: Any, tmp_path: Path) -> None:
    assert page.title() == f"{SCRIPT}{IMAGE} · atari lab"
    page.locator(".cell").nth(57).click()
    expect(page.locator(".byte h2")).to_have_text(IMAGE)
    for key in ("k", "x", "o", "p"):
        page.keyboard.press(key)
    page.wait_for_timeout(300)
    page.keyboard.press("p")
    page.fill("#poke-value", "3")
    page.keyboard.press("Enter")
    for tab in ("Changes", "Search", "Export"):
        page.click(f"#tab-{tab}")
    with page.expect_download() as pending:
        page.click('[data-export="interventions.toml"]')
    pending.value.save_as(tmp_path / "interventions.toml")
    assert pending.value.suggested_filename.endswith("interventions.toml")
    assert IMAGE in (tmp_path / "interventions.toml").read_text(encoding="utf-8")


def test_an_error_is_shown_as_text_and_it_plays_on(
    page: Any, inspector: Inspector, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(single: bool = False) -> None:
        raise IndexError(IMAGE)

    with caplog.at_level(logging.CRITICAL), monkeypatch.context() as broken:
        broken.setattr(inspector.inspection, "_play_frame", fail)
        page.keyboard.press("p")
        expect(page.locator(".toast")).to_have_text(f"frame 0: IndexError('{IMAGE}')")
        expect(page.locator(".toast")).to_have_class("toast wrong shown")
        expect(page.locator(".play")).to_have_text("▶ Play")
    page.keyboard.press("p")
    wait_until(page, lambda: inspector.inspection.at > 20)


def test_a_page_that_sends_too_much_says_so(page: Any, inspector: Inspector) -> None:
    page.evaluate(
        "() => { for (let i = 0; i < 5000; i++) document.querySelector('main').atariLab.send({ do: 'step', frames: 3600 }); }"
    )
    expect(page.get_by_role("alert")).to_contain_text("the page sent too many commands: 1000 were waiting")
    page.get_by_role("button", name="Connect again").click()
    expect(page.locator("h1")).to_have_text(f"{SCRIPT}{IMAGE}")
    page.keyboard.press("p")
    wait_until(page, lambda: inspector.inspection.playing)


def test_the_static_picture(browser: Any, inspector: Inspector) -> None:
    page = browser.new_page()
    page.set_content(static_html(inspector.inspection))
    page.wait_for_timeout(100)
    assert page.evaluate("window.hacked") is None
    assert page.locator("img").count() == 1  # the screen
    page.close()
