"""Replays that come with the page: the shelf, and films for readers without the ROM."""

import base64
import gzip
import json
import re
import shutil
import struct
import zlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser_tools import wait_until
from page_tools import FORMS, REPLAYS, drop, give, rom, said, served, shown, started, wait_for
from web_tools import BUILD

import atari
from atari.recording import Replay

playwright = pytest.importorskip("playwright.sync_api")
if not (BUILD / "atari.html").exists():
    pytest.skip("the page is not built; run ./scripts/web --python PYTHON", allow_module_level=True)

expect = playwright.expect
FILMED = 700  # frames
WIDTH, KEY = 160, 300
HINT = (
    "With the ROM of Pong the page verifies it and you can play on: drop the file, or a wheel of ale-py, on the page."
)
FRAMES = {name: Replay.load(REPLAYS / f"{name}.a26r").frames_total for name in ("pong", "breakout")}


def film_of(name: str) -> bytes:
    """The film of the first frames of a replay, before its compression."""
    frames = list(Replay.load(REPLAYS / f"{name}.a26r").frames(0, FILMED, sound=True))
    screens = np.stack([frame.screen for frame in frames]).astype(np.uint32)
    pixels = screens[..., 0] << 16 | screens[..., 1] << 8 | screens[..., 2]
    colours = np.flatnonzero(np.bincount(pixels.ravel(), minlength=1 << 24))
    numbers = np.zeros(1 << 24, np.uint8)
    numbers[colours] = np.arange(len(colours))
    pictures = numbers[pixels]
    palette = np.stack([colours >> 16, colours >> 8 & 255, colours & 255], axis=1).astype(np.uint8)
    height = pictures.shape[1]
    out = [struct.pack("<4sBBHIIHBB", b"A26F", 1, len(colours) - 1, height, FILMED, FRAMES[name], 6000, 1, 0)]
    out.append(palette.tobytes())
    for number, picture in enumerate(pictures):
        rows = np.ones(height, bool) if number % KEY == 0 else (picture != pictures[number - 1]).any(axis=1)
        out += [np.packbits(rows).tobytes(), picture[rows].tobytes()]
    facts = [[frame.score for frame in frames], [0] * FILMED, [frame.lives for frame in frames]]
    out.append(np.array(facts, "<i4").tobytes())
    out += [frame.audio.tobytes() for frame in frames]
    return b"".join(out)


@pytest.fixture(scope="module")
def film() -> bytes:
    """The film of Pong's replay, before its compression."""
    return film_of("pong")


def write_shelf(folder: Path, films: dict[str, bytes], *, replays: Sequence[str], roms: Sequence[str]) -> None:
    """Put replays, with films, into both forms of a page in a folder."""
    rows = [
        {
            "name": name,
            "title": f"{atari.games[name].title}: a <b>game</b>",
            "game": name,
            "replay": f"replays/{name}.a26r",
            "film": f"replays/{name}.film" if name in films else None,
        }
        for name in replays
    ]
    shelf = {"format": 1, "replays": rows, "roms": list(roms)}
    files = {f"replays/{name}.a26r": (REPLAYS / f"{name}.a26r").read_bytes() for name in replays}
    files |= {f"replays/{name}.film": data for name, data in films.items()}
    files["shelf.json"] = json.dumps(shelf).encode()
    (folder / "replays").mkdir(exist_ok=True)
    tags = []
    for name, data in files.items():
        (folder / name).write_bytes(data)
        packed = base64.b64encode(gzip.compress(data)).decode()
        tags.append(f'<script type="application/octet-stream" id="file:{name}">{packed}</script>\n')
    page = (BUILD / "atari.html").read_text()
    page = re.sub(r'<script type="application/octet-stream" id="file:shelf.json">.*</script>\n', "", page)
    (folder / "atari.html").write_text(page.replace("<script>", f"{''.join(tags)}<script>", 1))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, film: bytes) -> Path:
    """A page with two replays, of which the first has a film."""
    made = tmp_path_factory.mktemp("shelf") / "page"
    shutil.copytree(BUILD, made)
    write_shelf(made, {"pong": zlib.compress(film)}, replays=["pong", "breakout"], roms=["catch.bin"])
    return made


@pytest.fixture(scope="module")
def site(folder: Path) -> Iterator[str]:
    """The address of the page on a server."""
    with served(folder) as address:
        yield address


@pytest.fixture(params=FORMS)
def address(request: Any, folder: Path, site: str) -> str:
    """The address of the page, in both forms."""
    return site if request.param == "site" else (folder / "atari.html").as_uri()


def film_shown(page: Any) -> Any:
    wait_for(page, "app.play.isFilm && app.play.frame > 0")
    return page


def array_of(page: Any, expression: str) -> "np.ndarray[Any, np.dtype[np.uint8]]":
    """The bytes of an expression of the page's `app`."""
    text = page.evaluate(
        f"""() => {{ let text = ""; const bytes = ((app) => {expression})(atariPage);
        for (let at = 0; at < bytes.length; at += 4096) text += String.fromCharCode(...bytes.subarray(at, at + 4096));
        return btoa(text); }}"""
    )
    return np.frombuffer(base64.b64decode(text), np.uint8)


def picture(page: Any) -> "np.ndarray[Any, np.dtype[np.uint8]]":
    """The pixels of the screen, (height, 160, 4) RGBA."""
    return array_of(page, "app.play.session.screen()").reshape(-1, WIDTH, 4)


def choose_replay(page: Any, name: str) -> None:
    page.get_by_role("combobox", name="Replays").select_option(name)


def test_a_film_plays_without_the_rom(new_page: Any, address: str) -> None:
    page = film_shown(new_page(address))
    choice = page.get_by_role("combobox", name="Replays")
    expect(choice).to_have_value("pong")
    expect(choice.locator("option").nth(1)).to_have_text("Pong: a <b>game</b>")
    verdict = page.locator(".verdict")
    expect(verdict).to_contain_text(HINT)
    expect(verdict).to_contain_text(f"the first 12 s of {round(FRAMES['pong'] / 60)} s.")
    expect(page.get_by_role("button", name="Go on by hand")).to_be_disabled()
    page.keyboard.press("p")
    slider = page.get_by_label("Frame of the replay")
    frames = list(Replay.load(REPLAYS / "pong.a26r").frames(0, FILMED, sound=True))
    for number in (650, 299, 300, 301, 302, 5, FILMED, 1):
        slider.fill(str(number))
        frame = frames[number - 1]
        assert shown(page, "app.play.frame") == number
        rgba = picture(page)
        assert np.array_equal(rgba[..., :3], frame.screen)
        assert (rgba[..., 3] == 255).all()
        assert shown(page, "app.play.session.facts()") == {
            "score": frame.score,
            "secondScore": 0,
            "lives": frame.lives,
        }
        assert np.array_equal(array_of(page, "app.play.session.audio()"), frame.audio)
    page.keyboard.press(".")
    assert shown(page, "app.play.frame") == 2
    slider.fill("600")
    page.locator(".stage").focus()
    page.keyboard.down("Backspace")
    wait_for(page, "app.play.frame < 590")
    page.keyboard.up("Backspace")
    slider.fill(str(FILMED - 2))
    page.get_by_label("Speed").select_option("8")
    page.get_by_role("button", name="Play", exact=True).click()
    wait_for(page, f"app.paused && app.play.frame === {FILMED}")


def test_a_film_has_sound_after_a_click(new_page: Any, address: str) -> None:
    page = film_shown(new_page(address))
    assert shown(page, "app.sound.state") == "none"
    page.mouse.click(640, 200)
    wait_for(page, "app.sound.state === 'running'")
    page.evaluate(
        """() => { atariPage.sound.push = (samples) => { window.heard = [atariPage.play.frame, ...samples]; }; }"""
    )
    wait_until(page, lambda: page.evaluate("window.heard !== undefined"))
    number, *samples = page.evaluate("window.heard")
    (frame,) = Replay.load(REPLAYS / "pong.a26r").frames(number - 1, number, sound=True)
    assert samples == frame.audio.tolist()


def test_what_needs_the_rom_says_so(new_page: Any, address: str) -> None:
    page = film_shown(new_page(address))
    page.get_by_text("RAM", exact=True).click()
    expect(page.locator("#ram")).to_contain_text("the page needs the ROM of Pong to show it.")
    expect(page.locator("#ram .cell").first).to_be_hidden()
    for key in ("k", "l", "Enter", "z", "v", "o"):
        page.keyboard.press(key)
        expect(page.locator(".message")).to_have_text("")
    page.get_by_text("Game", exact=True).click()
    page.get_by_role("button", name="Begin with these").click()
    said(page, "This needs the ROM of Pong: drop its file on the page.")
    assert shown(page, "app.play.isFilm")
    choose_replay(page, "breakout")  # which has no film
    said(page, "This needs the ROM of Breakout: drop its file on the page.")
    expect(page.get_by_role("combobox", name="Replays")).to_have_value("pong")
    page.get_by_role("button", name="Link to replay").click()
    assert page.locator(".address").input_value().endswith("#show=pong")
    page.get_by_role("button", name="Close the replay").click()
    wait_for(page, "app.play.entry.id === 'catch' && !app.play.isReplay")
    expect(page.get_by_role("combobox", name="Replays")).to_have_value("")


def test_the_replay_takes_over(new_page: Any, address: str) -> None:
    page = film_shown(new_page(address))
    page.keyboard.press("p")
    page.get_by_label("Frame of the replay").fill("400")
    before = picture(page)
    drop(page, "pong.bin", rom("pong"))
    wait_for(page, "!app.play.isFilm && app.seeking === null && app.play.frame === 400")
    assert shown(page, "app.paused")
    assert np.array_equal(picture(page), before)
    expect(page.locator(".verdict")).to_contain_text("400 frames verified.")
    expect(page.get_by_label("Frame of the replay")).to_have_attribute("max", str(FRAMES["pong"]))
    page.reload()
    wait_for(page, "!app.play.isFilm && app.seeking === null && app.play.frame === 400 && app.shelf.shown === 'pong'")
    page.get_by_role("button", name="Go on by hand").click()
    wait_for(page, "!app.play.isReplay && app.shelf.shown === null")


def test_a_film_goes_on_after_a_reload(new_page: Any, address: str) -> None:
    page = film_shown(new_page(address))
    page.keyboard.press("p")
    page.get_by_label("Frame of the replay").fill("500")
    page.reload()
    wait_for(page, "app.play.isFilm && app.play.frame === 500 && app.paused")


def test_a_link_to_a_replay_of_the_shelf(new_page: Any, address: str) -> None:
    page = film_shown(new_page(f"{address}#show=pong"))
    assert "#" not in page.url
    give(page, "breakout.bin", rom("breakout"))
    wait_for(page, "app.play.entry.id === 'breakout' && !app.play.isReplay")
    page.evaluate("location.hash = 'show=breakout'")
    wait_for(page, "app.play.isReplay && app.shelf.shown === 'breakout' && app.play.frame > 0")
    expect(page.get_by_role("combobox", name="Replays")).to_have_value("breakout")
    page.evaluate("location.hash = 'show=nothing'")
    said(page, "The page has no replay nothing.")
    assert shown(page, "app.shelf.shown") == "breakout"


def test_a_film_plays_offline_after_the_first_visit(new_page: Any, folder: Path) -> None:
    files = ["replays/pong.film", "shelf.json", "catch.bin", "table/games/pong.json"]
    with served(folder) as address:
        page = film_shown(new_page(address))
        wait_until(page, lambda: page.evaluate("navigator.serviceWorker.controller !== null"))
        kept = "(names) => Promise.all(names.map((name) => caches.match(name))).then((found) => found.every(Boolean))"
        wait_until(page, lambda: page.evaluate(kept, files))
    page.reload()
    film_shown(page)


def changed(data: bytes, start: int, *numbers: int) -> bytes:
    return data[:start] + bytes(numbers) + data[start + len(numbers) :]


@pytest.mark.parametrize(
    "damage",
    [
        lambda film: b"no stream",
        lambda film: zlib.compress(film)[:-200],
        lambda film: zlib.compress(film[:30]),
        lambda film: zlib.compress(b""),
        lambda film: zlib.compress(film + b"x"),
        lambda film: zlib.compress(changed(film, 0, 66)),  # magic
        lambda film: zlib.compress(changed(film, 4, 2)),  # version
        lambda film: zlib.compress(changed(film, 5, 1)),  # colours
        lambda film: zlib.compress(changed(film, 6, 0, 0)),  # height
        lambda film: zlib.compress(changed(film, 8, 255, 255, 255, 255)),  # frames
        lambda film: zlib.compress(changed(film, 12, 1, 0, 0, 0)),  # frames of the whole replay
        lambda film: zlib.compress(changed(film, 16, 0, 0)),  # rate
        lambda film: zlib.compress(changed(film, 18, 3)),  # players
        lambda film: zlib.compress(changed(film, 20 + 3 * (film[5] + 1), 0x7F)),  # rows of the first picture
        lambda film: zlib.compress(changed(film, 20 + 3 * (film[5] + 1) + 27, film[5] + 1)),  # colour of a pixel
        lambda film: zlib.compress(bytes(1 << 28)),
    ],
)
def test_a_damaged_film(new_page: Any, site: str, film: bytes, damage: Callable[[bytes], bytes]) -> None:
    page = new_page(f"{site}#game=catch")
    wait_for(page, "app.play.entry.id === 'catch'")
    page.evaluate(
        "(text) => { const bytes = Uint8Array.from(atob(text), (one) => one.charCodeAt(0));"
        "const { fetch } = window; window.fetch = async (name) =>"
        "name.endsWith('.film') ? new Response(bytes) : fetch(name); }",
        base64.b64encode(damage(film)).decode(),
    )
    choose_replay(page, "pong")
    said(page, "The film pong is damaged.")
    assert shown(page, "app.play.entry.id") == "catch"
    expect(page.get_by_role("combobox", name="Replays")).to_have_value("")


def test_a_page_with_a_film_alone(new_page: Any, film: bytes, tmp_path: Path) -> None:
    write_shelf(tmp_path, {"pong": zlib.compress(film)}, replays=["pong"], roms=[])
    page = film_shown(new_page((tmp_path / "atari.html").as_uri()))
    page.get_by_role("button", name="Close the replay").click()
    said(page, "This page has no game of its own: drop a ROM file on it.")
    page.get_by_role("button", name="Empty the library").click()
    said(page, "The library is empty.")
    assert shown(page, "app.play.isFilm")
    give(page, "breakout.bin", rom("breakout"))  # not the ROM of the film
    wait_for(page, "app.play.entry.id === 'breakout' && !app.play.isReplay")
    choose_replay(page, "pong")
    film_shown(page)


def test_a_page_without_a_shelf(new_page: Any, folder: Path, tmp_path: Path) -> None:
    page = (folder / "atari.html").read_text()
    bare = re.sub(r'<script type="application/octet-stream" id="file:shelf.json">.*</script>\n', "", page)
    (tmp_path / "atari.html").write_text(bare)
    opened = started(new_page((tmp_path / "atari.html").as_uri()))
    assert shown(opened, "app.play.entry.id") == "catch"
    expect(opened.get_by_role("combobox", name="Replays")).to_be_hidden()
