"""What environments, games and replays show in a notebook."""

import base64
import io
import re
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from replay_tools import record

import atari
from atari.base import notebook
from atari.base.text_table import aligned
from atari.lab import Ram
from atari.lab.inspector.inspection import Inspection
from atari.lab.widget import static_html
from atari.recording import Replay
from atari.recording.replay.file_format import SUFFIX
from atari.web import shelf


def pictures(page: str) -> list[bytes]:
    return [base64.b64decode(data) for data in re.findall(r"data:image/png;base64,([^\"]+)", page)]


def shown(data: bytes) -> np.ndarray:
    return cv2.cvtColor(cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)


def played(data: bytes) -> list[np.ndarray]:
    """The images that a browser shows of an animated PNG; wrong checksums fail."""
    with av.open(io.BytesIO(data), format="apng") as file:
        file.streams.video[0].codec_context.options = {"err_detect": "crccheck+explode"}
        return [frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)]


@pytest.fixture
def no_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package without the page, where replays are animations; tests/recording/replay/test_shown.py tests the page."""
    monkeypatch.setattr(shelf, "PARTS", tmp_path / "missing")


def test_an_environment_shows_its_screen() -> None:
    env = atari.AtariEnv("breakout")
    assert "not reset yet" in env._repr_html_()
    env.reset(seed=0)
    for _ in range(10):
        observation, *_ = env.step(1)
    page = env._repr_html_()
    assert "Breakout: frame 40, score 0, lives 5" in page
    pong = atari.AtariEnv("pong")
    pong.reset(seed=0)
    assert "Pong: frame 0, score 0<" in str(pong._repr_html_())
    assert (shown(pictures(page)[0]) == observation).all()
    env.close()
    assert env._repr_html_() is None
    env.reset()
    assert env._repr_html_()


def test_a_vector_shows_its_first_screens() -> None:
    envs = atari.AtariVectorEnv(["pong", "breakout"], stack_num=1)
    envs.reset(seed=0)
    page = envs._repr_html_()
    assert "2 environments: Pong, Breakout" in page
    assert (shown(pictures(page)[0]) == envs.mosaic()).all()
    envs.send(np.zeros(2, np.int64))
    assert envs._repr_html_() is None or "2 environments" in envs._repr_html_()
    envs.recv()
    envs.close()
    assert envs._repr_html_() is None

    many = atari.AtariVectorEnv("pong", 40)
    many.reset(seed=0)
    page = many._repr_html_()
    assert "40 environments: Pong, the first 36" in page
    assert shown(pictures(page)[0]).shape == (6 * 210, 6 * 160, 3)


def test_a_browser_shows_each_image_with_the_aspect_of_its_attributes(tmp_path: Path) -> None:
    """`height:auto` alone takes the aspect of the file, whose pixels are the console's and narrower."""
    env = atari.AtariEnv("air_raid")
    env.reset(seed=0)
    envs = atari.AtariVectorEnv("pong", 3)
    envs.reset(seed=0)
    replay = Replay.load(record(tmp_path / f"game{SUFFIX}", "pong", steps=4))
    pages = [shown._repr_html_() for shown in (env, envs, replay)]
    pages.append(static_html(Inspection(env)))
    for page in pages:
        (tag,) = re.findall(r"<img[^>]*>", page)
        width, height = (int(re.search(rf'{name}="(\d+)"', tag)[1]) for name in ("width", "height"))
        assert f"height:auto;aspect-ratio:{width}/{height}" in tag
    assert 'width="320" height="250"' in pages[0], "two columns for each pixel, as on a television"
    assert 'width="640" height="420"' in pages[1]


@pytest.mark.parametrize("game", atari.games)
def test_a_game_shows_its_facts(game: str) -> None:
    page = atari.games[game]._repr_html_()
    assert f'<td style="text-align:left">{game}</td>' in page
    manual = atari.games[game].manual
    if manual is not None and manual.year is not None:
        assert str(manual.year) in page


def test_markup_in_facts_is_text() -> None:
    page = notebook.facts("<b>", [("<i>", "<script>"), ("nothing", None), ("empty", "")], "a & b")
    assert "<b>" not in page
    assert "<script>" not in page
    assert "a &amp; b" in page
    assert "nothing" not in page
    assert "empty" not in page


@pytest.mark.usefixtures("no_page")
def test_a_replay_plays(tmp_path: Path) -> None:
    replay = Replay.load(record(tmp_path / "game.a26r", "breakout", steps=100))
    page = replay._repr_html_()
    [file] = pictures(page)
    frames = [frame.screen for frame in replay.frames()]
    expected = [np.maximum.reduce(frames[at : at + 2]) for at in range(0, len(frames), 2)]
    assert f"Breakout: {len(frames)} frames, score" in page
    images = played(file)
    assert len(images) == len(expected)
    assert all((image == right).all() for image, right in zip(images, expected, strict=True))
    assert (shown(file) == expected[0]).all()  # what a viewer without animation shows


def test_a_replay_without_frames_shows_nothing(tmp_path: Path) -> None:
    assert Replay.load(record(tmp_path / "game.a26r", steps=0))._repr_html_() is None


@pytest.mark.usefixtures("no_page")
def test_a_replay_of_players_shows_itself(tmp_path: Path) -> None:
    from atari.multiplayer import MultiplayerCore
    from atari.recording import RecordReplay

    with RecordReplay(MultiplayerCore("pong"), tmp_path / "game.a26r") as match:
        match.reset()
        for _ in range(10):
            match.act_players([0, 0])
    assert "score" in Replay.load(tmp_path / "game.a26r")._repr_html_()


def test_a_report_has_the_tables_that_print_shows() -> None:
    rows = [("game", "mean", "difference"), ("as given", "1,000.5 [1, 2]", ""), ("<b> & c", "-3.0", "+4.0")]
    table = "\n".join(aligned(rows, bool))
    page = notebook.report(f"policy <x>, seed 0\nprotocol y\n\n{table}\n\n- a  note\n- another")
    assert page.startswith("<p><strong>policy &lt;x&gt;, seed 0</strong></p><p>protocol y</p><div")
    assert re.findall(r"<th(?: [^>]*)?>(.*?)</th>", page) == ["game", "mean", "difference"]
    cells = re.findall(r"<td[^>]*>(.*?)</td>", page)
    assert cells == ["as given", "1,000.5 [1, 2]", "", "&lt;b&gt; &amp; c", "-3.0", "+4.0"]
    assert page.endswith("<p>- a  note</p><p>- another</p>")
    assert [("text-align:left" in tag) for tag in re.findall("<td[^>]*>", page)] == [True, False, False] * 2


def test_a_task_shows_what_it_decides() -> None:
    task = atari.Task.of("pong", preset="dqn2015", frameskip=3)
    page = task._repr_html_()
    assert "pong: Pong, as &#x27;pong&#x27; with preset=&#x27;dqn2015&#x27;, but frameskip=3" in page
    assert '<th style="text-align:left">frame skip</th><td style="text-align:left">3 frames a step</td>' in page
    names = [line.strip().split("  ")[0] for line in str(task).splitlines()[1:]]
    assert re.findall(r"<th[^>]*>(.*?)</th>", page) == names


def test_ram_shows_its_labels() -> None:
    env = atari.make("breakout")
    env.reset(seed=0)
    ram = Ram(env)
    page = ram._repr_html_()
    assert "<strong>Ram(breakout, " in page
    assert '<td style="text-align:left">lives</td><td>57</td><td style="text-align:left">0xB9</td><td>5</td>' in page
    env.close()
    assert ram._repr_html_() is None
