"""A replay on a page: its title, its film, and its frame in a notebook. `tests/browser/test_notebook.py` opens it."""

import base64
import gzip
import html
import io
import json
import re
from pathlib import Path

import av
import pytest
from page_parts import CATCH, parts
from replay_tools import record

import atari
from atari.recording import Replay
from atari.recording.replay import shown as shown_module
from atari.recording.replay.results import EpisodeSummary
from atari.recording.replay.shown import on_page, title
from atari.web import shelf
from atari.web.film import film, frames_of


@pytest.fixture(autouse=True)
def built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shelf, "PARTS", parts(tmp_path / "parts"))


def page_of(shown: str) -> str:
    """The page in the frame of a notebook."""
    (page,) = re.findall("srcdoc='([^']*)'", shown)
    return html.unescape(page)


def inside(page: str, name: str) -> bytes:
    (text,) = re.findall(f'id="file:{re.escape(name)}">([^<]*)<', page)
    return gzip.decompress(base64.b64decode(text))


@pytest.mark.parametrize(
    ("episodes", "text"),
    [
        ([], "Pong"),
        ([EpisodeSummary(9, -21, "open")], "Pong: -21 points"),
        ([EpisodeSummary(9, 1, "open")], "Pong: 1 point"),
        ([EpisodeSummary(9, 5, "open"), EpisodeSummary(9, 1234, "open")], "Pong: 2 games, best 1,234 points"),
        ([EpisodeSummary(9, 3, "open", [3, 5])], "Pong: 3 : 5"),
    ],
)
def test_titles(episodes: list[EpisodeSummary], text: str) -> None:
    assert title(atari.games["pong"], episodes) == text


def test_on_a_page(tmp_path: Path) -> None:
    replay = Replay.load(record(tmp_path / "game.a26r", "pong", steps=100))
    seen: list[int] = []
    shown = on_page(replay, 2, progress=seen.append)
    assert (shown.name, shown.game, shown.replay) == ("game", replay.game, replay.path.read_bytes())
    assert shown.film == film(replay.frames(0, 120, sound=True), 400, 60)
    assert frames_of(shown.film) == sum(seen) == 120
    assert on_page(replay, 0).film is None
    assert on_page(replay, 0).title == shown.title


def test_in_a_notebook(tmp_path: Path) -> None:
    replay = Replay.load(record(tmp_path / "game.a26r", "pong", steps=400))
    shown = replay._repr_html_()
    assert shown is not None
    page = page_of(shown)
    assert "sandbox='allow-scripts allow-downloads'" in shown
    assert json.loads(inside(page, "shelf.json"))["roms"] == []
    assert list(json.loads(inside(page, "table/index.json"))["games"]) == ["pong"]
    assert inside(page, "replays/game.a26r") == replay.path.read_bytes()
    assert frames_of(inside(page, "replays/game.film")) == 20 * 60
    without = re.sub("<iframe.*</iframe>", "", shown, flags=re.DOTALL)  # as on GitHub
    assert "data:image/png" in without
    assert re.search(r"<p>Pong: -?\d+ points?, 1,600 frames</p>", without)
    assert "script" not in without


def test_markdown_leaves_the_frame_of_a_notebook(tmp_path: Path) -> None:
    replay = Replay.load(record(tmp_path / "game.a26r", "pong", 4))
    assert "\n" not in str(replay._repr_html_())


def test_the_own_game_of_a_notebook(tmp_path: Path) -> None:
    catch = CATCH / "catch.toml"
    replay = Replay.load(record(tmp_path / "game.a26r", str(catch), steps=30), game=catch)
    page = page_of(str(replay._repr_html_()))
    assert inside(page, "roms/catch.bin") == (CATCH / "catch.bin").read_bytes()


def test_without_the_page_it_is_an_animation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    replay = Replay.load(record(tmp_path / "game.a26r", "pong", steps=30))
    monkeypatch.setattr(shelf, "PARTS", tmp_path / "missing")
    shown = str(replay._repr_html_())
    assert shown.startswith("<figure")
    assert "iframe" not in shown


def test_a_video_in_a_cell(tmp_path: Path) -> None:
    replay = Replay.load(record(tmp_path / "game.a26r", "air_raid", steps=30))
    video = replay.video(stop=60, scale=1)
    assert repr(video) == "ShownVideo(caption='Air Raid: 60 frames, 0.0 MB')"
    (source,) = re.findall('<video controls [^>]*src="data:video/mp4;base64,([^"]*)"', video._repr_html_())
    assert base64.b64decode(source) == video.data
    with av.open(io.BytesIO(video.data)) as file:
        frames = list(file.decode(video=0))
        assert (len(frames), frames[0].width, frames[0].height) == (60, 320, 250)
        assert file.streams.audio
    with av.open(io.BytesIO(replay.video(stop=60, sound=False).data)) as file:
        assert not file.streams.audio


def test_a_video_that_is_too_large_for_a_notebook(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    replay = Replay.load(record(tmp_path / "game.a26r", "pong", steps=200))
    monkeypatch.setattr(shown_module, "MAX_VIDEO_SIZE", 20_000)
    with pytest.raises(
        ValueError, match=r"the first [\d,]+ frames of the video have 0.0 MB, .* choose a part with start"
    ):
        replay.video()
