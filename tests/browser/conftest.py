"""The browser of the tests: Chromium or Chrome of this system, without a window."""

import os
import shutil
from collections.abc import Iterator
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
