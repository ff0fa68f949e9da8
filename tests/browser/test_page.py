"""The page in a browser, as a site and as one file: play, RAM, links, replays, files, and what is refused.

Run by scripts/test --browser, after scripts/web has built it into build/web.
"""

import io
import statistics
import threading
import zipfile
from collections.abc import Callable, Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
from browser_tools import LIMIT, wait_until
from web_tools import BUILD

import atari
from atari.recording import Replay

playwright = pytest.importorskip("playwright.sync_api")
if not (BUILD / "atari.html").exists():
    pytest.skip("the page is not built; run ./scripts/web", allow_module_level=True)

expect = playwright.expect
REPLAYS = Path(__file__).parents[2] / "docs" / "games" / "replays"
CATCH = Path(__file__).parents[2] / "examples" / "catch" / "catch.toml"
FORMS = ["site", "file"]
LIVES, PLAYER_X = 1, 2  # bytes of catch


class Handler(SimpleHTTPRequestHandler):
    """Serves the page without a log."""

    def log_message(self, *_: Any) -> None:
        """Print nothing."""


@pytest.fixture(scope="module")
def site() -> Iterator[str]:
    """The address of the page on a server."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, directory=str(BUILD))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


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
        own = (address.split("#")[0], "data:", "blob:")
        page.on("request", lambda asked: None if asked.url.startswith(own) else faults.append(asked.url))
        if init:
            page.add_init_script(init)
        page.goto(address)
        return page

    yield opened
    for context in contexts:
        context.close()
    assert faults == []


@pytest.fixture(params=FORMS)
def address(request: Any, site: str) -> str:
    """The address of the page, in both forms."""
    return site if request.param == "site" else (BUILD / "atari.html").as_uri()


def shown(page: Any, expression: str) -> Any:
    """The value of an expression of the page's `app`."""
    return page.evaluate(f"((app) => {expression})(window.atariPage)")


def wait_for(page: Any, condition: str) -> None:
    wait_until(page, lambda: shown(page, f"!!(app?.play && ({condition}))"))


def started(page: Any) -> Any:
    wait_for(page, "app.play.session.facts().frame > 0")
    return page


def said(page: Any, text: str) -> None:
    expect(page.locator(".message")).to_contain_text(text)


def ram(page: Any) -> list[int]:
    return list(shown(page, "[...app.play.session.ram()]"))


def give(page: Any, name: str, data: bytes) -> None:
    """Give the page a file by its button."""
    page.set_input_files("input[type=file]", {"name": name, "mimeType": "application/octet-stream", "buffer": data})


def drop(page: Any, name: str, data: bytes) -> None:
    """Drop a file on the page."""
    transfer = page.evaluate_handle(
        """([name, bytes]) => { const data = new DataTransfer();
        data.items.add(new File([new Uint8Array(bytes)], name)); return data; }""",
        [name, list(data)],
    )
    page.dispatch_event("main", "drop", {"dataTransfer": transfer})


def zipped(files: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method) as file:
        for name, data in files.items():
            file.writestr(name, data)
    return out.getvalue()


def rom(game: str) -> bytes:
    return atari.roms.find(game).read_bytes()


def verified(page: Any, button: str, tmp_path: Path) -> Replay:
    """The replay that a button saves, which the package has verified."""
    with page.expect_download() as pending:
        page.get_by_role("button", name=button).click()
    path = tmp_path / pending.value.suggested_filename
    pending.value.save_as(path)
    replay = Replay.load(path, game=CATCH if path.stem == "catch" else None)
    assert replay.complete
    assert replay.verify(), replay.verify()
    return replay


def test_catch_plays_at_once(new_page: Any, address: str) -> None:
    page = started(new_page(address))
    assert shown(page, "app.sound.state") == "none"
    at = ram(page)[PLAYER_X]
    page.keyboard.down("ArrowRight")
    wait_for(page, f"app.play.session.ram()[{PLAYER_X}] > {at + 4}")
    page.keyboard.up("ArrowRight")
    wait_for(page, "app.sound.state === 'running'")
    page.keyboard.press("p")
    assert shown(page, "app.paused")
    frame = shown(page, "app.play.session.facts().frame")
    page.keyboard.press(".")
    assert shown(page, "app.play.session.facts().frame") == frame + 1
    page.keyboard.down("Backspace")
    wait_for(page, f"app.play.session.facts().frame < {frame - 3}")
    page.keyboard.up("Backspace")


def test_keys_of_the_browser_stay_its_own(new_page: Any, site: str) -> None:
    page = started(new_page(site))
    taken = """([code, ctrlKey]) => { const event = new KeyboardEvent("keydown", { code, ctrlKey, bubbles: true, cancelable: true });
    document.body.dispatchEvent(event); return event.defaultPrevented; }"""
    for code in (*(f"F{number}" for number in range(1, 13)), "Tab", "Escape"):
        assert not page.evaluate(taken, [code, False]), code
    for code in ("KeyP", "KeyW", "KeyS", "KeyD", "KeyL", "ArrowLeft"):
        assert not page.evaluate(taken, [code, True]), code
    assert page.evaluate(taken, ["ArrowLeft", False])
    box = page.get_by_role("button", name="Save state")
    box.focus()
    page.keyboard.press("Space")  # presses the button
    said(page, "The state is saved.")


def test_ram(new_page: Any, address: str, tmp_path: Path) -> None:
    page = started(new_page(address))
    page.get_by_role("button", name="Pause").click()
    page.get_by_text("RAM", exact=True).click()
    page.get_by_role("button", name="lives", exact=True).click()
    value = page.get_by_label("New value")
    value.fill("9")
    page.get_by_role("button", name="Poke").click()
    assert ram(page)[LIVES] == 9
    expect(page.locator(".cell").nth(LIVES)).to_have_text("09")
    expect(page.locator("h3", has_text="Byte 1 (lives)")).to_have_text("Byte 1 (lives): 9")
    page.get_by_role("button", name="Undo").click()
    assert ram(page)[LIVES] == 3
    expect(page.get_by_role("button", name="Undo")).to_be_disabled()
    page.get_by_role("button", name="Fork").click()
    expect(page.locator(".screen")).to_have_count(2)
    value.fill("7")
    page.get_by_role("button", name="Freeze").click()
    page.get_by_role("button", name="Objects").click()
    page.get_by_label("Speed").select_option("8")
    page.get_by_role("button", name="Play", exact=True).click()
    wait_for(page, "app.play.fork.facts().gameOver")  # without the lives that the game has
    assert ram(page)[LIVES] == 7
    page.get_by_role("button", name="Release").click()
    wait_for(page, f"app.play.session.ram()[{LIVES}] < 7")
    page.get_by_role("button", name="Close the fork").click()
    page.get_by_role("button", name="Pause").click()
    assert verified(page, "Save replay", tmp_path).frames_total == shown(page, "app.play.changes.frame")


def test_rewinding_takes_changes_back(new_page: Any, site: str) -> None:
    page = started(new_page(site))
    page.keyboard.press("p")
    page.evaluate(
        "atariPage.toggleFreeze(1, 9); atariPage.stepFrame(); atariPage.toggleFreeze(1); atariPage.stepFrame()"
    )
    page.evaluate("atariPage.play.goBack()")
    assert shown(page, "app.play.changes.inForce") == []
    page.evaluate("atariPage.play.goBack()")
    assert shown(page, "[app.play.changes.inForce.length, app.play.changes.canUndo]") == [1, True]
    page.evaluate("atariPage.stepFrame()")
    assert ram(page)[LIVES] == 9
    page.evaluate("atariPage.play.goBack(); atariPage.play.goBack()")
    assert shown(page, "[app.play.changes.inForce.length, app.play.changes.canUndo]") == [0, False]


def test_a_reload_loses_nothing(new_page: Any, address: str, tmp_path: Path) -> None:
    page = started(new_page(address))
    page.get_by_text("RAM", exact=True).click()
    page.get_by_label("Speed").select_option("2")
    wait_for(page, "app.play.changes.frame > 60")
    page.get_by_role("button", name="Pause").click()
    page.evaluate("atariPage.toggleFreeze(1, 5)")
    page.keyboard.press(".")
    page.evaluate("atariPage.poke(40, 77)")
    before, frames = ram(page), shown(page, "app.play.changes.frame")
    page.reload()
    wait_for(page, "app.seeking === null && app.paused")
    assert ram(page) == before
    assert shown(page, "[app.speed, app.ram.element.open, app.paused, app.play.isReplay]") == [2, True, True, False]
    page.get_by_role("button", name="lives", exact=True).click()
    expect(page.get_by_role("button", name="Release")).to_be_visible()
    assert verified(page, "Save replay", tmp_path).frames_total == frames


def test_saved_states(new_page: Any, address: str) -> None:
    page = started(new_page(address))
    page.keyboard.press("p")
    page.keyboard.press("k")
    before = ram(page)
    page.keyboard.down("ArrowRight")
    for _ in range(30):
        page.keyboard.press(".")
    page.keyboard.up("ArrowRight")
    assert ram(page) != before
    page.keyboard.press("l")
    assert ram(page) == before


def test_a_link_to_a_moment(new_page: Any, address: str) -> None:
    page = started(new_page(address))
    page.get_by_text("RAM", exact=True).click()
    page.get_by_label("Speed").select_option("0.5")
    wait_for(page, "app.play.session.facts().frame > 100")
    page.get_by_role("button", name="Link to this moment").click()
    said(page, "The link has")
    link, before = page.locator(".address").input_value(), ram(page)
    print(f"a link to a moment of catch: {len(link)} letters")
    other = new_page(link, permissions=[])
    wait_for(other, "app.paused")
    assert ram(other) == before
    assert shown(other, "[app.speed, app.ram.element.open, app.sound.state]") == [0.5, True, "none"]
    said(other, "This is the moment of the link")
    assert "#" not in other.url


def test_a_zip_with_a_rom(new_page: Any, address: str) -> None:
    page = started(new_page(address))
    give(page, "games.whl", zipped({"ale_py/roms/pong.bin": rom("pong"), "ale_py/roms/breakout.bin": rom("breakout")}))
    wait_for(page, "app.play.entry.id === 'pong'")
    said(page, "2 games are in the library.")
    page.get_by_role("combobox", name="Game").select_option("breakout")
    wait_for(page, "app.play.entry.id === 'breakout' && app.play.session.facts().frame > 20")
    page.get_by_text("RAM", exact=True).click()
    page.get_by_label("bricks return").check()
    assert shown(page, "app.play.changes.has('bricks_return')")
    page.reload()
    wait_for(page, "app.play.entry.id === 'breakout' && app.seeking === null")
    expect(page.get_by_label("bricks return")).to_be_checked()
    page.get_by_role("button", name="Empty the library").click()
    wait_for(page, "app.play.entry.id === 'catch'")
    page.reload()
    wait_for(page, "app.play.entry.id === 'catch'")
    assert shown(page, "app.library.ids") == ["catch"]


def test_two_players_at_one_keyboard(new_page: Any, site: str) -> None:
    page = started(new_page(site))
    give(page, "stored.zip", zipped({"pong.bin": rom("pong")}, zipfile.ZIP_STORED))
    wait_for(page, "app.play.entry.id === 'pong'")
    page.keyboard.down("d")
    assert shown(page, "app.input.actions()") == [3, 0]  # alone
    page.keyboard.up("d")
    page.get_by_text("Game", exact=True).click()
    page.get_by_label("Players").select_option("2")
    page.get_by_role("button", name="Begin with these").click()
    wait_for(page, "app.play.players === 2 && app.play.session.facts().frame > 0")
    for key in ("d", "f", "ArrowUp"):
        page.keyboard.down(key)
    assert shown(page, "app.input.actions()") == [2, 11]


def test_a_replay_goes_round(new_page: Any, address: str, tmp_path: Path) -> None:
    data = (REPLAYS / "pong.a26r").read_bytes()
    replay = Replay.load(REPLAYS / "pong.a26r")
    page = started(new_page(address))
    drop(page, "pong.a26r", data)
    said(page, "This needs the ROM of Pong: drop its file on the page.")
    drop(page, "pong.bin", rom("pong"))
    wait_for(page, "app.play.isReplay && app.play.frame > 3")
    expect(page.locator(".verdict")).to_contain_text("frames verified.")
    slider = page.get_by_label("Frame of the replay")
    slider.fill(str(replay.frames_total))
    wait_for(page, "app.seeking === null && app.play.checked >= app.play.frames")
    expect(page.locator(".verdict")).to_contain_text(f"Verified: all {replay.frames_total} frames")
    page.evaluate("atariPage.setPaused(true)")
    slider.fill("400")
    wait_for(page, "app.seeking === null && app.play.frame === 400")
    page.evaluate("atariPage.play.goBack()")
    assert ram(page) == list(replay.seek(399).ram())
    page.keyboard.press(".")
    assert ram(page) == list(replay.seek(400).ram())
    page.get_by_role("button", name="Go on by hand").click()
    wait_for(page, "!app.play.isReplay && app.play.changes.frame > 20")
    page.evaluate("atariPage.setPaused(true)")
    gone_on = verified(page, "Save replay", tmp_path)
    assert gone_on.frames_total == 400 + shown(page, "app.play.changes.frame")
    drop(page, "again.a26r", (tmp_path / "pong.a26r").read_bytes())
    wait_for(page, "app.play.isReplay")
    page.get_by_label("Frame of the replay").fill(str(gone_on.frames_total))
    expect(page.locator(".verdict")).to_contain_text(f"Verified: all {gone_on.frames_total} frames")


def test_a_link_to_a_replay(new_page: Any, address: str) -> None:
    page = started(new_page(address))
    wait_for(page, "app.play.changes.frame > 60")
    page.keyboard.press("p")
    page.get_by_role("button", name="Link to replay").click()
    said(page, "The link has")
    link, frames = page.locator(".address").input_value(), shown(page, "app.play.changes.frame")
    other = new_page(link, permissions=[])
    wait_for(other, "app.play.isReplay")
    assert shown(other, "app.play.frames") == frames
    expect(other.locator(".verdict")).to_contain_text(f"Verified: all {frames} frames")


@pytest.mark.parametrize(
    ("name", "data", "sentence"),
    [
        ("song.mp3", b"no ROM", "song.mp3: This is no replay, no zip, and no ROM of a game that the page has."),
        ("<b>.bin", bytes(4096), "<b>.bin: This is no replay, no zip, and no ROM"),
        ("a.zip", zipped({"a.bin": b"x" * 4096})[:-40], "a.zip: The zip is damaged: it cannot be read."),
        ("a.whl", zipped({"a.bin": bytes(4096), "b.txt": b"b"}), "a.whl: The zip has no ROM of a game that the page has."),
        ("a.a26r", b"ATARIRPL" + bytes(40), "The replay"),
    ],
)  # fmt: skip
def test_a_file_that_is_refused(new_page: Any, site: str, name: str, data: bytes, sentence: str) -> None:
    page = started(new_page(site))
    drop(page, name, data)
    said(page, sentence)
    at = shown(page, "app.play.session.facts().frame")
    wait_for(page, f"app.play.entry.id === 'catch' && app.play.session.facts().frame > {at}")


@pytest.mark.parametrize(
    ("link", "sentence"),
    [
        ("#replay=QVRB", "no replay"),
        ("#replay=%%%", "The link is damaged: its end may be missing."),
        ("#game=nothing", "The page has no such game."),
        ("#game=pong", "This needs the ROM of Pong: drop its file on the page."),
        ("#game=catch&options={}&state=QVRB", "These bytes are not a snapshot of atari-envs."),
        ("#game=catch&options={&state=QVRB", "The link is damaged: its end may be missing."),
        ("#game=catch&players=2&options={}&state=QVRB", "Catch has no game of two players."),
        ('#game=catch&options={"mode":"<i>"}&state=QVRB', "The option mode is out of range."),
    ],
)
def test_a_link_that_is_refused(new_page: Any, address: str, link: str, sentence: str) -> None:
    page = started(new_page(address + link))
    said(page, sentence)
    assert shown(page, "app.play.entry.id") == "catch"


@pytest.mark.parametrize(
    ("without", "sentence"),
    [
        ("delete window.AudioContext;", "This browser plays no sound; the game goes on without."),
        ("Storage.prototype.setItem = () => { throw new Error('full'); };", "The browser's storage is full or closed"),
    ],
)
def test_a_browser_without_something(new_page: Any, address: str, without: str, sentence: str) -> None:
    page = started(new_page(address, init=without))
    page.mouse.click(640, 200)
    page.evaluate("atariPage.keeper.keep()")
    said(page, sentence)
    at = shown(page, "app.play.session.facts().frame")
    wait_for(page, f"app.play.session.facts().frame > {at}")


@pytest.mark.parametrize(
    "without",
    [
        "delete window.WebAssembly;",
        "WebAssembly.instantiate = async () => { throw new WebAssembly.CompileError('no SIMD'); };",
    ],
)
def test_a_browser_without_webassembly(new_page: Any, address: str, without: str) -> None:
    page = new_page(address, init=without)
    expect(page.get_by_role("alert")).to_contain_text("WebAssembly")


def test_full_storage_for_roms(new_page: Any, site: str) -> None:
    page = started(new_page(site, init="IDBObjectStore.prototype.put = () => { throw new Error('full'); };"))
    give(page, "pong.bin", rom("pong"))
    said(page, "The browser's storage is full; the games are here until you close the page.")
    wait_for(page, "app.play.entry.id === 'pong'")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_part_is_wider_than_a_phone(new_page: Any, address: str, scheme: str) -> None:
    page = started(new_page(address, viewport={"width": 390, "height": 844}, color_scheme=scheme, has_touch=True))
    at = ram(page)[PLAYER_X]
    box = page.locator(".pad").bounding_box()
    page.mouse.move(box["x"] + box["width"] - 8, box["y"] + box["height"] / 2)
    page.mouse.down()
    wait_for(page, f"app.play.session.ram()[{PLAYER_X}] > {at + 4}")
    page.mouse.up()
    page.evaluate("for (const panel of atariPage.panels) panel.open = true; atariPage.toggleFork()")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_offline_after_the_first_visit(new_page: Any) -> None:
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, directory=str(BUILD))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        page = started(new_page(f"http://127.0.0.1:{server.server_port}/"))
        page.evaluate("navigator.serviceWorker.ready.then(() => true)")
        wait_until(page, lambda: page.evaluate("navigator.serviceWorker.controller !== null"))
        server.shutdown()
    page.reload()
    started(page)


@pytest.mark.parametrize("form", FORMS)
def test_the_first_frame(new_page: Any, site: str, form: str) -> None:
    """Prints the time, which no test asserts."""
    address = site if form == "site" else (BUILD / "atari.html").as_uri()
    times = []
    for _ in range(5):
        page = started(new_page(address, locale="en"))
        times.append(page.evaluate("performance.getEntriesByName('first-frame')[0].startTime"))
    print(f"the first frame of the {form}: {statistics.median(times):.0f} ms (median of five)")
    assert all(time > 0 for time in times)
