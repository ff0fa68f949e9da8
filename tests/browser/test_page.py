"""The page in a browser, as a site and as one file: play, RAM, links, replays, files, and what is refused.

Run by scripts/test --browser, after scripts/web has built it into build/web.
"""

import json
import statistics
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browser_tools import wait_until
from page_tools import FORMS, REPLAYS, drop, give, ram, rom, said, served, shown, started, verified, wait_for, zipped
from web_tools import BUILD

from atari.recording import Replay
from atari.recording.replay import file_format

playwright = pytest.importorskip("playwright.sync_api")
if not (BUILD / "atari.html").exists():
    pytest.skip("the page is not built; run ./scripts/web --python PYTHON", allow_module_level=True)

expect = playwright.expect
LIVES, PLAYER_X = 1, 2  # bytes of catch


@pytest.fixture(scope="module")
def site() -> Iterator[str]:
    """The address of the page on a server."""
    with served(BUILD) as address:
        yield address


@pytest.fixture(params=FORMS)
def address(request: Any, site: str) -> str:
    """The address of the page, in both forms."""
    return site if request.param == "site" else (BUILD / "atari.html").as_uri()


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
    older = ram(page)
    page.evaluate("atariPage.poke(40, 77)")
    before, frames = ram(page), shown(page, "app.play.changes.frame")
    page.reload()
    wait_for(page, "app.seeking === null && app.paused")
    assert ram(page) == before
    assert shown(page, "[app.speed, app.ram.element.open, app.paused, app.play.isReplay]") == [2, True, True, False]
    page.get_by_role("button", name="lives", exact=True).click()
    expect(page.get_by_role("button", name="Release")).to_be_visible()
    assert verified(page, "Save replay", tmp_path).frames_total == frames
    page.get_by_role("button", name="Undo").click()  # of the poke
    assert ram(page) == older
    page.evaluate("atariPage.play.goBack()")  # before the byte was frozen
    assert shown(page, "[app.play.changes.inForce, app.play.changes.frame]") == [["1"], frames - 1]
    page.get_by_role("button", name="Undo").click()
    for _ in range(50):
        assert page.evaluate("atariPage.play.goBack()")
    assert shown(page, "app.play.changes.frame") == frames - 51
    assert verified(page, "Save replay", tmp_path).frames_total == frames - 51


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


def test_a_link_of_an_earlier_release(new_page: Any, address: str) -> None:
    """To frame 107 of catch at half the speed, with the panel of the RAM open (docs/stability.md)."""
    moment = (Path(__file__).parent / "data/moment.txt").read_text("utf-8").strip()
    page = new_page(f"{address}#{moment}", permissions=[])
    wait_for(page, "app.paused")
    assert shown(page, "[app.play.session.facts().frame, app.speed, app.ram.element.open]") == [107, 0.5, True]
    assert ram(page)[:4] == [0, 2, 80, 106]


def test_a_link_says_what_it_leaves_out(new_page: Any, site: str) -> None:
    page = started(new_page(site))
    page.evaluate("atariPage.toggleFreeze(1, 5)")
    page.get_by_role("button", name="Link to this moment").click()
    said(page, "Frozen bytes and interventions are not in it.")
    page.evaluate("atariPage.toggleFreeze(1, 5)")
    page.get_by_role("button", name="Link to this moment").click()
    expect(page.locator(".message")).not_to_contain_text("Frozen")


def played_by_hand(page: Any) -> list[int]:
    """Play for some frames, pause, and return the RAM."""
    page.keyboard.down("ArrowRight")
    wait_for(page, "app.play.isPlayed && app.play.changes.frame > 20")
    page.keyboard.up("ArrowRight")
    page.keyboard.press("p")
    return ram(page)


def test_a_link_puts_the_game_aside(new_page: Any, address: str, tmp_path: Path) -> None:
    page = started(new_page(address))
    back = page.get_by_role("button", name="Back to your game")
    page.get_by_role("button", name="Link to this moment").click()
    link = page.locator(".address").input_value()
    expect(back).to_be_hidden()
    page.keyboard.press("p")
    first = played_by_hand(page)
    page.evaluate("(link) => { location.hash = link.split('#')[1]; }", link)
    said(page, "This is the moment of the link")
    page.keyboard.press("p")
    second = played_by_hand(page)
    assert second != first
    back.click()
    said(page, "This is your game")
    assert ram(page) == first
    back.click()  # to the game that was played after the link
    wait_for(page, "app.seeking === null && !app.play.isReplay")
    assert ram(page) == second
    page.reload()
    wait_for(page, "app.seeking === null && !app.play.isReplay")
    assert ram(page) == second
    back.click()
    said(page, "This is your game")
    assert ram(page) == first
    verified(page, "Save replay", tmp_path)


def test_a_link_at_the_start_puts_the_kept_game_aside(new_page: Any, address: str) -> None:
    page = started(new_page(address))
    before = played_by_hand(page)
    page.evaluate("atariPage.keeper.keep()")
    other = started(new_page(f"{address}#game=catch"))
    other.get_by_role("button", name="Back to your game").click()
    said(other, "This is your game")
    assert ram(other) == before
    expect(other.get_by_role("button", name="Back to your game")).to_be_hidden()


def test_a_dropped_replay_puts_the_game_aside(new_page: Any, site: str) -> None:
    page = started(new_page(site))
    give(page, "pong.bin", rom("pong"))
    wait_for(page, "app.play.entry.id === 'pong'")
    before = played_by_hand(page)
    drop(page, "pong.a26r", (REPLAYS / "pong.a26r").read_bytes())
    wait_for(page, "app.play.isReplay && app.play.frame > 0")
    page.get_by_role("button", name="Back to your game").click()
    said(page, "This is your game")
    assert ram(page) == before


def forged(**header: Any) -> bytes:
    """The replay of Pong with another header."""
    data = (REPLAYS / "pong.a26r").read_bytes()
    size = int.from_bytes(data[9:13], "little")
    facts = json.loads(data[19 : 19 + size])
    return data[:8] + file_format._chunk(b"H", json.dumps({**facts, **header}).encode()) + data[19 + size :]


@pytest.mark.parametrize(
    ("header", "sentence"),
    [
        ({"rom": "0" * 32}, "The replay was recorded with a ROM of MD5 000000"),
        ({"format": 3}, "The replay has format 3, and this page reads 1; use"),
        ({"game": "nothing"}, "The page has no such game."),
    ],
)
def test_a_replay_that_the_page_cannot_play(new_page: Any, site: str, header: dict[str, Any], sentence: str) -> None:
    page = started(new_page(site))
    give(page, "pong.bin", rom("pong"))
    wait_for(page, "app.play.entry.id === 'pong'")
    before = played_by_hand(page)
    drop(page, "pong.a26r", forged(**header))
    said(page, sentence)
    assert ram(page) == before
    assert not shown(page, "app.play.isReplay")
    page.keyboard.press("p")
    wait_for(page, f"app.play.session.facts().frame > {shown(page, 'app.play.session.facts().frame')}")


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
    with served(BUILD) as address:
        page = started(new_page(address))
        give(page, "games.whl", zipped({"pong.bin": rom("pong"), "breakout.bin": rom("breakout")}))
        wait_for(page, "app.play.entry.id === 'pong'")
        page.evaluate("navigator.serviceWorker.ready.then(() => true)")
        wait_until(page, lambda: page.evaluate("navigator.serviceWorker.controller !== null"))
        kept = "caches.match('table/table.json.gz').then((found) => found !== undefined)"
        wait_until(page, lambda: page.evaluate(kept))
    page.reload()
    wait_for(page, "app.play.entry.id === 'pong' && app.seeking === null")
    page.get_by_role("combobox", name="Game").select_option("breakout")  # which was never played
    wait_for(page, "app.play.entry.id === 'breakout' && app.play.session.facts().frame > 0")


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
