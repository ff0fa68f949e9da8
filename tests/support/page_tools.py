"""The page in a browser, for its tests: its forms on a server and as a file, and what a reader does."""

import io
import threading
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from browser_tools import wait_until

import atari
from atari.recording import Replay

CATCH = Path(__file__).parents[2] / "examples" / "catch" / "catch.toml"
REPLAYS = Path(__file__).parents[2] / "docs" / "games" / "replays"
FORMS = ["site", "file"]


class Handler(SimpleHTTPRequestHandler):
    """Serves the page without a log."""

    def log_message(self, *_: Any) -> None:
        """Print nothing."""


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """The address of a folder on a server."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, directory=str(folder))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


def shown(page: Any, expression: str) -> Any:
    """The value of an expression of the page's `app`."""
    return page.evaluate(f"((app) => {expression})(window.atariPage)")


def wait_for(page: Any, condition: str) -> None:
    wait_until(page, lambda: shown(page, f"!!(app?.play && ({condition}))"))


def started(page: Any) -> Any:
    wait_for(page, "app.play.session.facts().frame > 0")
    return page


def said(page: Any, text: str) -> None:
    """Wait for a sentence of the page."""
    from playwright.sync_api import expect

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
