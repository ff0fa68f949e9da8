"""The inspector in a browser: Chromium or Chrome of this system, without a window. Run by scripts/test --browser."""

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browser_tools import LIMIT, wait_until

pytest.importorskip("aiohttp")
playwright = pytest.importorskip("playwright.sync_api")

from atari.games.toml_file import tomllib  # noqa: E402
from atari.lab import widget  # noqa: E402
from atari.recording import Replay  # noqa: E402

LIVES, PADDLE = 57, 72
expect = playwright.expect


@pytest.fixture(scope="module")
def url() -> Iterator[str]:
    """The address of `atari lab breakout`."""
    command = [sys.executable, "-m", "atari", "lab", "breakout", "--no-browser", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        lines = iter(server.stdout.readline, "")
        text = ""
        for line in lines:
            text += line
            if line.startswith("}") or line.rstrip().endswith("}"):
                break
        yield json.loads(text)["url"]
        server.terminate()


@pytest.fixture
def page(browser: Any, url: str) -> Iterator[Any]:
    """The page, which may not report an error until the test has ended."""
    context = browser.new_context(viewport={"width": 1280, "height": 900}, accept_downloads=True)
    context.set_default_timeout(1000 * LIMIT)
    shown = context.new_page()
    faults: list[str] = []
    shown.on("console", lambda message: faults.append(message.text) if message.type in ("error", "warning") else None)
    shown.on("pageerror", lambda error: faults.append(str(error)))
    shown.goto(url)
    wait_for(shown, "shown")
    shown.evaluate(
        """() => { const { send, state } = document.querySelector('main').atariLab; send({ do: "close_fork", keep: false });
        for (const index of Object.keys(state.frozen)) send({ do: "release", index: Number(index) });
        for (const command of ["new_game", "take_over", "new_search"]) send({ do: command }); send({ do: "speed", speed: 1 }); }"""
    )
    wait_for(shown, "shown.lives === 5 && !shown.fork")
    yield shown
    context.close()
    assert faults == []


def frame(page: Any) -> int:
    return int(page.evaluate("document.querySelector('main').atariLab.shown.at"))


def wait_for(page: Any, condition: str) -> None:
    """Wait for a condition on `shown`, the newest frame. (The page's policy forbids wait_for_function, which uses eval.)"""
    text = f"(({{ shown }}) => !!({condition}))(document.querySelector('main').atariLab ?? {{}})"
    wait_until(page, lambda: page.evaluate(text))


def screen(page: Any) -> str:
    return str(page.evaluate("document.querySelector('.screen canvas').toDataURL()"))


def cell(page: Any, index: int) -> Any:
    return page.locator(".cell").nth(index)


def record_commands(page: Any) -> None:
    """Record the commands that keys and the touch stick send from here on."""
    page.evaluate(
        """() => { const { atariLab } = document.querySelector('main'), { send } = atariLab; window.sent = [];
        atariLab.send = (message) => { sent.push(message); send(message); }; }"""
    )


def holds(page: Any) -> list[dict[str, Any]]:
    """The recorded commands that move the stick."""
    return list(page.evaluate("sent.filter((message) => message.do === 'hold')"))


def download(page: Any, name: str, folder: Path) -> Path:
    with page.expect_download() as pending:
        page.click(f'[data-export="{name}"]')
    path = folder / pending.value.suggested_filename
    pending.value.save_as(path)
    return path


def test_play_poke_search_freeze_scrub_and_export(page: Any, tmp_path: Path) -> None:
    # It plays 300 frames.
    at = frame(page)
    page.keyboard.press("p")
    page.keyboard.down(" ")
    wait_for(page, f"shown.at >= {at + 300}")
    page.keyboard.up(" ")
    page.keyboard.press("p")
    wait_for(page, "!shown.playing")

    # A poke is seen on the screen, before a frame is played.
    cell(page, PADDLE).click()
    expect(page.locator(".byte h2")).to_have_text("player_x")
    before, at = screen(page), frame(page)
    page.fill("#poke-value", "70")
    page.keyboard.press("Enter")
    wait_for(page, f"shown.ram[{PADDLE}] === 70 && shown.preview")
    assert screen(page) != before
    assert frame(page) == at
    page.click("#tab-Changes")
    page.get_by_role("button", name="Undo the last change").click()
    wait_for(page, f"shown.ram[{PADDLE}] !== 70 && !shown.preview")
    assert screen(page) == before

    # The search finds the lives.
    page.click("#tab-Search")
    page.keyboard.press("r")
    wait_for(page, "shown.lives === 5")
    page.get_by_label("speed").select_option("4")
    page.get_by_label("number", exact=True).fill("5")
    page.click('[data-filter="equals"]')
    page.locator(".screen").first.focus()
    page.keyboard.press("p")
    page.keyboard.down("f")
    wait_for(page, "shown.lives === 4")
    page.keyboard.up("f")
    page.keyboard.press("p")
    wait_for(page, "!shown.playing")
    page.click('[data-filter="decreased"]')
    page.click('[data-filter="unchanged"]')
    page.get_by_label("number", exact=True).fill(
        str(page.evaluate("document.querySelector('main').atariLab.shown.lives"))
    )
    page.click('[data-filter="equals"]')
    expect(page.locator("#panel-Search .status")).to_have_text(re.compile("^1 candidate left"))
    page.click(f'[data-byte="{LIVES}"]')

    # Frozen, it stays.
    held = page.evaluate(f"document.querySelector('main').atariLab.shown.ram[{LIVES}]")
    page.locator(".screen").first.focus()
    page.keyboard.press("x")
    expect(cell(page, LIVES)).to_have_class(re.compile("frozen"))
    start = frame(page)
    page.keyboard.press("p")
    page.keyboard.down("f")
    wait_for(page, f"shown.at > {start + 600}")
    page.keyboard.up("f")
    page.keyboard.press("p")
    wait_for(page, "!shown.playing")
    assert page.evaluate(f"document.querySelector('main').atariLab.shown.ram[{LIVES}]") == held

    # Back in time, the same bytes come again.
    end, last = frame(page), screen(page)
    page.locator(".time").fill("200")
    wait_for(page, "shown.at === 200")
    assert screen(page) != last
    page.locator(".time").fill(str(end))
    wait_for(page, f"shown.at === {end}")
    assert screen(page) == last

    # Exports.
    page.click("#tab-Export")
    assert Replay.load(download(page, "replay.a26r", tmp_path)).verify()
    table = tomllib.loads(download(page, "interventions.toml", tmp_path).read_text())
    assert table["frozen_lives"]["writes"] == [
        {"to": LIVES, "value": held, "when": when} for when in ("reset", "frame")
    ]


def test_causes(page: Any) -> None:
    cell(page, PADDLE).click()
    page.keyboard.press("l")
    expect(page.locator(".note")).to_have_text(re.compile(r"^\d+ pixels of the next two frames"))
    x, y = page.evaluate(
        """() => { const { main } = document.querySelector('main').atariLab; const d = main.mask.getContext('2d')
        .getImageData(0, 0, 160, 210).data; const i = d.findIndex((v, i) => i % 4 === 3 && v === 255) >> 2;
        return [i % 160, Math.floor(i / 160)]; }"""
    )
    times = page.evaluate("document.querySelector('main').atariLab.times")
    page.locator(".screen").first.click(position={"x": (2 * x + 1) * times, "y": (y + 0.5) * times})
    expect(cell(page, PADDLE)).to_have_class(re.compile("lit"))


def test_what_if(page: Any) -> None:
    page.keyboard.press("v")
    wait_for(page, "shown.fork")
    assert page.locator(".screen:visible").count() == 2
    cell(page, LIVES).click()
    page.fill("#poke-value", "2")
    page.keyboard.press("Enter")
    wait_for(page, f"shown.fork.ram[{LIVES}] === 2 && shown.ram[{LIVES}] === 5")
    expect(page.get_by_text("1 byte and", exact=False)).to_be_visible()
    page.get_by_text("Keep the fork").click()
    wait_for(page, f"!shown.fork && shown.ram[{LIVES}] === 2")


def test_keyboard_alone(page: Any) -> None:
    page.keyboard.press("?")
    expect(page.locator("dialog.help")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.locator("dialog.help")).to_be_hidden()
    page.keyboard.press("g")
    for key in (*["ArrowUp"] * 7, "Home", *["ArrowDown"] * 3, *["ArrowRight"] * 9):
        page.keyboard.press(key)
    expect(page.locator(".byte h2")).to_have_text("lives")
    page.keyboard.press("k")
    expect(page.locator(".watch")).to_have_count(1)
    page.keyboard.press("k")
    expect(page.locator(".watch")).to_have_count(0)
    page.keyboard.press("e")
    page.keyboard.type("3")
    page.keyboard.press("Enter")
    wait_for(page, f"shown.ram[{LIVES}] === 3")
    page.keyboard.press("Escape")
    page.keyboard.press("z")
    wait_for(page, f"shown.ram[{LIVES}] === 5")
    unnamed = page.evaluate(
        """() => [...document.querySelectorAll('button, input, select, canvas:not(.overlay)')].filter(e => !e.hidden
        && !e.textContent.trim() && !e.getAttribute('aria-label') && !e.getAttribute('aria-hidden') && !e.closest('label'))
        .map(e => e.outerHTML)"""
    )
    assert unnamed == []


def test_after_a_click_space_is_fire(page: Any) -> None:
    record_commands(page)

    def expect_fire() -> None:
        before = len(holds(page))
        page.keyboard.press(" ")
        assert [message["fire"] for message in holds(page)[before:]] == [True, False]

    page.get_by_role("button", name="▶ Play").click()
    wait_for(page, "shown.playing")
    at = frame(page)
    expect_fire()
    wait_for(page, f"shown.at > {at + 30}")
    assert page.evaluate("sent.filter((message) => message.do === 'pause')") == []

    cell(page, PADDLE).click()
    before = len(holds(page))
    page.keyboard.press("ArrowLeft")
    assert [message["horizontal"] for message in holds(page)[before:]] == [-1, 0]
    expect(page.locator(".byte h2")).to_have_text("player_x")  # the arrow chose no other byte

    page.get_by_label("number", exact=True).fill("5")
    page.click('[data-filter="equals"]')
    expect_fire()
    expect(page.locator("#panel-Search .status")).to_have_text(re.compile(r"after equals\(5\)$"))
    page.locator(".time").click()
    expect_fire()
    page.get_by_role("button", name="keyboard shortcuts").click()
    page.get_by_role("button", name="Close").click()
    expect_fire()
    expect(page.locator("dialog.help")).to_be_hidden()


def test_tab_reaches_the_buttons(page: Any) -> None:
    record_commands(page)
    play = page.locator(".play")
    page.locator(".screen").first.focus()
    for _ in range(10):
        page.keyboard.press("Tab")
        if play.evaluate("(button) => button === document.activeElement"):
            break
    expect(play).to_be_focused()
    for key in ("Enter", " "):
        page.keyboard.press(key)
        wait_for(page, "shown.playing")
        page.keyboard.press(key)
        wait_for(page, "!shown.playing")
    assert holds(page) == []
    page.keyboard.press("Escape")
    page.keyboard.press(" ")
    assert [message["fire"] for message in holds(page)] == [True, False]
    page.keyboard.press("?")
    expect(page.locator("dialog.help")).to_contain_text("Enter or Space presses a button")


def test_addresses_stand_on_rows_and_columns(page: Any) -> None:
    assert page.get_by_role("rowheader").all_text_contents() == [f"{address:X}" for address in range(0x80, 0x100, 16)]
    columns = page.get_by_role("columnheader").all()[1:]
    assert [column.text_content() for column in columns] == list("0123456789ABCDEF")
    for index in (0, LIVES, PADDLE, 127):
        row, column = page.get_by_role("rowheader").nth(index // 16), columns[index % 16]
        box = cell(page, index).bounding_box()
        middle = column.bounding_box()["x"] + column.bounding_box()["width"] / 2
        assert box["x"] < middle < box["x"] + box["width"]
        middle = row.bounding_box()["y"] + row.bounding_box()["height"] / 2
        assert box["y"] < middle < box["y"] + box["height"]


@pytest.mark.parametrize("width", [390, 1280])
def test_whole_names_stand_beside_the_grid(page: Any, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 844})
    rows = page.locator(".names li")
    assert {text.rstrip("-0123456789") for text in rows.all_text_contents()} >= {"lives", "player_x", "ball_y"}
    cut = "(rows) => rows.filter((li) => li.scrollWidth > li.clientWidth || li.firstChild.scrollWidth > li.firstChild.clientWidth)"
    assert page.locator(".names li").evaluate_all(f"{cut}.length") == 0
    rows.filter(has_text=re.compile("^lives")).get_by_role("button").click()
    expect(page.locator(".byte h2")).to_have_text("lives")
    expect(rows.filter(has_text=re.compile("^lives")).locator("output")).to_have_text("5")
    page.fill("#poke-value", "3")
    page.keyboard.press("Enter")
    expect(rows.filter(has_text=re.compile("^lives")).locator("output")).to_have_text("3")


@pytest.mark.parametrize(("width", "least"), [(390, 320), (768, 640), (1280, 600), (1400, 640)])
def test_a_fork_does_not_shrink_the_screens(page: Any, width: int, least: int) -> None:
    page.set_viewport_size({"width": width, "height": 900})
    page.keyboard.press("v")
    wait_for(page, "shown.fork")
    for screen in page.locator(".screen").all():
        wait_until(page, lambda screen=screen: screen.bounding_box()["width"] >= least)
        box = screen.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= width


def test_an_intervention_is_a_click(page: Any) -> None:
    box = page.get_by_role("checkbox", name="one_row Only the lowest row of bricks stands.")
    box.check()
    page.keyboard.press(".")
    wait_for(page, "shown.ram[1] === 0")
    page.click("#tab-Changes")
    expect(page.locator(".changes li").first).to_contain_text("one_row on")
    page.keyboard.press("z")
    expect(box).not_to_be_checked()
    expect(page.locator(".changes li").first).not_to_contain_text("one_row")


def test_the_whole_name_stands_at_pointer_and_focus(page: Any) -> None:
    tip = page.locator(".tip")
    expect(tip).to_be_hidden()
    cell(page, PADDLE).hover()
    expect(tip).to_have_text("byte 72, address $C8: player_x")
    page.locator("h1").hover()
    expect(tip).to_be_hidden()
    page.keyboard.press("g")
    expect(tip).to_have_text(re.compile("^byte "))
    for key in (*["ArrowUp"] * 7, "Home", *["ArrowDown"] * 4, *["ArrowRight"] * 8):
        page.keyboard.press(key)
    expect(cell(page, PADDLE)).to_be_focused()
    expect(tip).to_have_text("byte 72, address $C8: player_x")
    box = tip.bounding_box()
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= 1280
    page.keyboard.press("Escape")
    expect(tip).to_be_hidden()


def test_the_search_is_above_the_fold(page: Any) -> None:
    page.set_viewport_size({"width": 1280, "height": 800})
    page.get_by_label("number", exact=True).fill("5")
    page.click('[data-filter="equals"]')
    expect(page.locator(f'[data-byte="{LIVES}"]')).to_be_visible()
    parts = page.locator(".tools [role=tab], .tools [data-filter], #panel-Search .status, #panel-Search .scroll").all()
    assert len(parts) == 15
    for part in parts:
        box = part.bounding_box()
        assert box["y"] + box["height"] <= 800
    assert page.evaluate("scrollY") == 0


def test_paused_stands_in_place_of_the_pace(page: Any) -> None:
    expect(page.locator("header")).to_contain_text("paused")
    page.wait_for_timeout(1500)  # the frames of a second were counted
    expect(page.locator("header")).to_contain_text("paused")
    page.keyboard.press("p")
    expect(page.locator("header")).to_contain_text(re.compile(r"\d+ fps"))
    expect(page.locator("header")).not_to_contain_text("paused")
    page.keyboard.press("p")
    wait_for(page, "!shown.playing")
    assert page.locator(".pace").text_content() == "paused"  # with the frame that says so


def test_fire_while_paused_says_so(page: Any) -> None:
    notice = page.get_by_text("the game is paused; Play (P) goes on")
    for key in (" ", "ArrowLeft"):
        page.keyboard.press(key)
        expect(notice).to_be_visible()
        page.evaluate("document.querySelector('.toast').replaceChildren()")
    page.set_viewport_size({"width": 390, "height": 844})
    page.locator(".touch .fire").click()
    expect(notice).to_be_visible()
    page.evaluate("document.querySelector('.toast').replaceChildren()")
    page.keyboard.press("p")
    wait_for(page, "shown.playing")
    page.keyboard.press(" ")
    at = frame(page)
    wait_for(page, f"shown.at > {at + 20}")
    expect(notice).to_have_count(0)


def test_screen_stick_and_ram_fit_on_a_phone(page: Any) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.scrollingElement.scrollWidth") <= 390
    for part in (
        *page.locator(".screen:visible, .touch .pad, .touch .fire, .play").all(),
        cell(page, 0),
        cell(page, 127),
    ):
        box = part.bounding_box()
        assert box["x"] >= 0
        assert box["y"] >= 0
        assert box["x"] + box["width"] <= 390
        assert box["y"] + box["height"] <= 844
    cut = page.evaluate("[...document.querySelectorAll('.cell b')].filter((b) => b.scrollWidth > b.clientWidth).length")
    assert cut == 0
    cell(page, PADDLE).click()
    expect(page.locator(".tip")).to_have_text("byte 72, address $C8: player_x")
    assert page.evaluate("document.scrollingElement.scrollWidth") <= 390


@pytest.mark.parametrize("width", [390, 1280])
def test_nothing_is_wider_than_the_page(page: Any, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 844})
    for fork in (False, True):
        if fork:
            page.keyboard.press("v")
            wait_for(page, "shown.fork")
        page.wait_for_timeout(100)
        assert page.evaluate("document.scrollingElement.scrollWidth") <= width


def test_a_second_tab_is_told(page: Any, url: str) -> None:
    second = page.context.new_page()
    second.goto(url)
    expect(second.get_by_role("alert")).to_contain_text("This session is open in another tab.")
    page.keyboard.press("p")
    wait_for(page, "shown.playing")
    second.get_by_text("Use it here").click()
    wait_for(second, "shown?.at > 0")
    expect(page.get_by_role("alert")).to_contain_text("This session went on in another tab.")
    second.close()
    page.wait_for_timeout(200)


def test_the_touch_stick_of_a_phone(page: Any) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    record_commands(page)
    pad, fire = page.locator(".touch .pad"), page.locator(".touch .fire")
    expect(pad).to_be_visible()
    pad.scroll_into_view_if_needed()
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    box = pad.bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(*middle)
    page.mouse.down()
    around = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]
    for right, up in around:
        page.mouse.move(middle[0] + 40 * right, middle[1] - 40 * up)
    page.mouse.move(middle[0] + 300, middle[1])  # the stick follows a finger that leaves it
    page.mouse.up()
    fire.hover()
    page.mouse.down()
    page.mouse.up()
    sent = holds(page)
    moves = [(message["horizontal"], message["vertical"]) for message in sent]
    assert moves == [*around, (1, 0), (0, 0), (0, 0), (0, 0)]
    assert [message["fire"] for message in sent] == [False] * 10 + [True, False]


def test_the_token_is_needed(page: Any, url: str) -> None:
    context = page.context.browser.new_context()
    response = context.new_page().goto(re.sub(r"(:\d+/).*", r"\1another/", url))
    assert response.status == 403
    assert "no valid token" in response.text()
    context.close()


def test_the_widget_in_a_page(browser: Any) -> None:
    """The module for notebooks, with a model that answers as the kernel does."""
    pytest.importorskip("anywidget")
    import atari

    shown = widget.show(atari.make("breakout"))
    context = browser.new_context()
    page = context.new_page()
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))

    def send(message: Any, buffers: Any = None) -> None:
        page.evaluate("([m, b]) => receive(m, b)", [message, [list(buffer) for buffer in buffers or ()]])

    shown.send = send
    received: list[Any] = []
    page.expose_function("toKernel", lambda message: received.append(message))
    page.set_content("<div id=out></div>")
    page.add_style_tag(content=shown._css)
    page.evaluate(
        """async (text) => {
            const module = await import(URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
            const listeners = [];
            window.receive = (m, b) => listeners.forEach((f) => f(m, b.map((x) => new DataView(new Uint8Array(x).buffer))));
            const model = { on: (_, f) => listeners.push(f), off() {}, send: (m) => window.toKernel(m) };
            module.default.render({ model, el: document.getElementById("out") });
        }""",
        str(shown._esm),
    )

    def answer(last: str) -> None:
        wait_until(page, lambda: received and received[-1]["do"] == last)
        while received:
            shown._receive(shown, received.pop(0), [])

    answer("open")
    wait_until(page, lambda: page.evaluate("!!document.querySelector('.atari-lab').atariLab?.shown"))
    page.locator(".cell").nth(LIVES).click()
    answer("select")
    page.fill("#poke-value", "2")
    page.keyboard.press("Enter")
    answer("poke")
    expect(page.locator(".cell").nth(LIVES).locator("b")).to_have_text("02")
    assert shown.inspection.ram()[LIVES] == 2
    page.get_by_role("button", name="New game").click()
    page.keyboard.press(" ")
    wait_until(page, lambda: len(received) >= 3)
    assert [message.get("fire", message["do"]) for message in received] == ["new_game", True, False]
    assert faults == []
    context.close()
