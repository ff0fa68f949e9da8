"""The browser of the tests, Chromium or Chrome of this system, without a window, and its pages."""

import os
import shutil
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from browser_tools import LIMIT

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api")
    playwright.expect.set_options(timeout=1000 * LIMIT)
    executable = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, BROWSERS)), None)
    if executable is None:
        pytest.skip(f"no browser was found ({', '.join(BROWSERS)})")
    with playwright.sync_playwright() as started:
        found = started.chromium.launch(executable_path=executable, args=["--no-sandbox", "--disable-quic"])
        yield found
        found.close()


@pytest.fixture
def new_page(browser: Any) -> Iterator[Callable[..., Any]]:
    """Opens pages of one browser profile. None may report an error, or request another host, until the test has ended."""
    faults: list[str] = []
    contexts: list[Any] = []

    def opened(address: str, init: str = "", **options: Any) -> Any:
        if options or not contexts:
            contexts.append(browser.new_context(**{"viewport": {"width": 1280, "height": 900}, **options}))
            contexts[-1].set_default_timeout(1000 * LIMIT)
        page = contexts[-1].new_page()
        page.on("console", lambda said: faults.append(said.text) if said.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: faults.append(str(error)))
        own = (address.split("#")[0].rpartition("/")[0], "data:", "blob:", "about:")
        page.on("request", lambda asked: None if asked.url.startswith(own) else faults.append(asked.url))
        if init:
            page.add_init_script(init)
        page.goto(address)
        return page

    yield opened
    for context in contexts:
        context.close()
    assert faults == []
