"""The documentation site in a browser, which scripts/docs has built into build/site. Run by scripts/test --browser."""

import threading
from collections.abc import Callable, Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
from browser_tools import LIMIT, wait_until

import atari

SITE = Path(__file__).parents[2] / "build" / "site"
if not (SITE / "index.html").exists():
    pytest.skip("the site is not built; run ./scripts/docs --games pong,breakout", allow_module_level=True)

PAGES = sorted(str(path.relative_to(SITE)) for path in SITE.rglob("*.html") if path.name != "404.html")
GAME_PAGES = [page for page in PAGES if page.startswith("games/") and page != "games/index.html"]
REFERENCE = [page for page in PAGES if page.startswith("reference/")]
LOOKED_AT = [page for page in PAGES if page not in (*GAME_PAGES, *REFERENCE)] + GAME_PAGES[::25] + REFERENCE[::8]
LOOKED_AT += ["games/pong.html", "games/breakout.html"]


class Handler(SimpleHTTPRequestHandler):
    """Serves the site without a log."""

    def log_message(self, *_: Any) -> None:
        """Print nothing."""


@pytest.fixture(scope="module")
def site() -> Iterator[str]:
    """The address of the site."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, directory=str(SITE))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.fixture
def page(browser: Any, site: str) -> Iterator[Any]:
    """A page of a phone's width. It may not report an error or ask another host until the test has ended."""
    context = browser.new_context(viewport={"width": 390, "height": 844}, base_url=site)
    context.set_default_timeout(1000 * LIMIT)
    shown = context.new_page()
    faults: list[str] = []
    shown.on("console", lambda message: faults.append(message.text) if message.type in ("error", "warning") else None)
    shown.on("pageerror", lambda error: faults.append(str(error)))
    shown.on("requestfailed", lambda request: faults.append(f"{request.url}: {request.failure}"))
    shown.on(
        "request", lambda asked: None if asked.url.startswith((site, "data:", "blob:")) else faults.append(asked.url)
    )
    yield shown
    context.close()
    assert [fault for fault in faults if "net::ERR_ABORTED" not in fault] == []  # a video that was still loading


def test_no_page_is_wider_than_a_phone(page: Any) -> None:
    wide = {}
    for name in LOOKED_AT:
        page.goto(f"/{name}", wait_until="load")
        if width := page.evaluate(
            "document.documentElement.scrollWidth > innerWidth && document.documentElement.scrollWidth"
        ):
            wide[name] = width
        broken = (
            "[...document.images].filter((image) => image.complete && !image.naturalWidth).map((image) => image.src)"
        )
        assert page.evaluate(broken) == []
    assert wide == {}


SCREENS = {
    "index.html": (".hero video", 4 * 320 / (3 * 210)),
    "games/index.html": (".games img", 320 / 210),
    "games/pong.html": ("figure.play video, .sheet:not(.views-of-presets) span", 320 / 210),
    "notebooks/pixels.html": (".output figure img", 320 / 210),
}
"""Pictures of screens by page, and their width by their height."""


@pytest.mark.parametrize("name", SCREENS)
def test_pixels_are_twice_as_wide_as_high(page: Any, name: str) -> None:
    page.goto(f"/{name}", wait_until="load")
    which, aspect = SCREENS[name]
    sizes = page.locator(which).evaluate_all("(shown) => shown.map((one) => [one.clientWidth, one.clientHeight])")
    assert sizes
    for width, height in (size for size in sizes if size[0]):
        assert width / height == pytest.approx(aspect, rel=0.02)


BROKEN_WORDS = """() => {
  const page = document.querySelector(".md-content") || document.body;
  const found = [], texts = document.createTreeWalker(page, NodeFilter.SHOW_TEXT);
  for (let text = texts.nextNode(); text; text = texts.nextNode()) {
    if (text.parentElement.closest("pre, script, style, details:not([open])")) continue;
    const around = text.parentElement;
    const width = around.closest("td, th") ? Infinity : (around.closest("p, li, h1, h2, h3, div") || page).clientWidth;
    for (const word of text.data.matchAll(/[\\p{L}\\p{N}_]+/gu)) {
      const range = document.createRange();
      range.setStart(text, word.index);
      range.setEnd(text, word.index + word[0].length);
      const lines = [...range.getClientRects()].filter((rect) => rect.width);
      const whole = text.data.slice(0, word.index).match(/\\S*$/)[0] + text.data.slice(word.index).match(/^\\S*/)[0];
      if (new Set(lines.map((rect) => Math.round(rect.top))).size > 1 && whole.length * 8.5 < width) found.push(whole);
    }
  }
  return found;
}"""
"""The words on two lines, in tables or in a text without a space that would fit on one: code has 8.2 pixels a character."""


def test_no_word_is_broken_on_a_phone(page: Any) -> None:
    broken = {}
    for name in LOOKED_AT:
        page.goto(f"/{name}", wait_until="load")
        if words := page.evaluate(BROKEN_WORDS):
            broken[name] = words
    assert broken == {}


def test_the_check_finds_a_broken_word(page: Any) -> None:
    page.goto("/start.html")
    page.add_style_tag(content="td code { word-break: break-all !important; }")
    assert page.evaluate(BROKEN_WORDS)


FIRST = ("index", "start", "command-line", "ale-py", "envpool", "stable-baselines3", "cleanrl", "classic", "modern")


def test_code_of_the_first_pages_is_seen_whole(page: Any) -> None:
    page.set_viewport_size({"width": 1280, "height": 900})
    hidden = "[...document.querySelectorAll('pre > code')].filter((code) => code.scrollWidth > code.clientWidth).length"
    found = {}
    for name in FIRST:
        page.goto(f"/{name}.html", wait_until="load")
        found[name] = page.evaluate(hidden)
    assert found == dict.fromkeys(FIRST, 0)


def test_no_page_is_as_high_as_thirty_screens(page: Any) -> None:
    page.set_viewport_size({"width": 1280, "height": 900})
    high = {}
    for name in {*LOOKED_AT, *REFERENCE}:
        page.goto(f"/{name}", wait_until="load")
        high[name] = page.evaluate("document.documentElement.scrollHeight")
    assert {name: height for name, height in high.items() if height >= 30_000} == {}


def test_the_search_finds_pages_that_are_opened_from_a_disk(new_page: Callable[..., Any]) -> None:
    page = new_page((SITE / "start.html").as_uri())
    page.locator("input.md-search__input").click()
    page.keyboard.type("stickiness")
    found = page.locator(".md-search-result__link")
    found.first.wait_for()
    addresses = found.evaluate_all("links => links.map((link) => link.href.split('#')[0].split('?')[0])")
    assert addresses[0].startswith(SITE.as_uri())
    found.first.click()
    page.wait_for_url(f"{addresses[0]}*")
    assert "stickiness" in page.locator(".md-content").inner_text()


def test_a_click_turns_the_sound_on(page: Any) -> None:
    page.goto("/games/pong.html")
    video, button = page.locator("figure.play video").first, page.locator("figure.play button.sound").first
    assert video.evaluate("video => video.muted")
    button.click()
    assert not video.evaluate("video => video.muted")
    heard = "video => !video.paused && video.currentTime > 0 && video.webkitAudioDecodedByteCount > 0"
    wait_until(page, lambda: video.evaluate(heard))
    assert button.text_content() == "Sound off"
    button.click()
    assert video.evaluate("video => video.muted")


@pytest.mark.skipif(not (SITE / "play" / "index.html").exists(), reason="the site has no page in which the games play")
def test_a_click_opens_the_page_that_plays_the_game(page: Any) -> None:
    page.goto("/games/pong.html")
    page.locator(".play-here summary").click()
    frame = page.frame_locator(".play-here iframe")
    frame.get_by_text("Pictures and sound of the recording").wait_for()
    screen = frame.locator(".stage canvas").first
    before = screen.evaluate("canvas => canvas.toDataURL()")
    wait_until(page, lambda: screen.evaluate("canvas => canvas.toDataURL()") != before)


def test_the_filters_of_the_index(page: Any) -> None:
    page.goto("/games/index.html")
    count = page.locator("ul.games > li").count()
    assert count == len(atari.games)
    visible = (
        "[...document.querySelectorAll('ul.games > li:not([hidden])')].map((game) => game.querySelector('a').href)"
    )
    expected = {
        ("name", "pong"): {game.id for game in atari.games.values() if "pong" in game.title.lower()},
        ("players", "4-9"): {game.id for game in atari.games.values() if _players(game) >= 4},
        ("labels", "20-128"): {game.id for game in atari.games.values() if len(game.ram_labels) >= 20},
        ("actions", "18-18"): {game.id for game in atari.games.values() if len(_actions(game)) == 18},
    }
    for (name, value), games in expected.items():
        page.evaluate("document.querySelector('form.game-filters').reset()")
        field = page.locator(f"form.game-filters [name={name}]")
        field.fill(value) if name == "name" else field.select_option(value)
        shown = {address.rsplit("/", 1)[1].removesuffix(".html") for address in page.evaluate(visible)}
        assert shown == games, name
        assert page.locator("form.game-filters output").text_content() == f"{len(games)} games"
        assert f"{name}={value}" in page.url
    of_one_player = sum(game.single_player for game in atari.games.values())  # the others have no IDs
    for name, fitting in (("lives", count), ("sticky", of_one_player)):  # each fits one choice
        page.evaluate("document.querySelector('form.game-filters').reset()")
        field = page.locator(f"form.game-filters [name={name}]")
        values = field.evaluate("field => [...field.options].map((option) => option.value).filter(Boolean)")
        found = []
        for value in values:
            field.select_option(value)
            found += page.evaluate(visible)
        assert len(found) == len(set(found)) == fitting
    page.reload()
    assert page.locator(f"form.game-filters [name={name}]").input_value() == values[-1]


def _actions(game: Any) -> Any:
    return game.minimal_actions or (game.multiplayer.minimal_actions if game.multiplayer else ())


def _players(game: Any) -> int:
    return game.multiplayer.most_players if game.multiplayer else 1
