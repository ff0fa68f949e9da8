"""Replays beside each other in one video."""

from collections.abc import Callable
from pathlib import Path

import av
import numpy as np
import pytest
from replay_tools import record
from video_reader import video_frames

import atari
from atari.cli import main
from atari.multiplayer import MultiplayerCore
from atari.recording import RecordReplay, Replay, video_facts
from atari.recording.replay.side_by_side import labels
from atari.recording.video.images import add_caption, enlarge
from atari.recording.video.overlay import CURVE_ROWS

WIDTH, HEIGHT, GAP, LINE = 320, 210, 8, 10  # at scale 1; LINE is the height of a line of text


@pytest.fixture
def pong(tmp_path: Path) -> Replay:
    return Replay.load(record(tmp_path / "pong.a26r", "pong", 10, seed=1))


@pytest.fixture
def breakout(tmp_path: Path) -> Replay:
    return Replay.load(record(tmp_path / "breakout.a26r", "breakout", 4, seed=1))


def cell(screen: np.ndarray, *lines: str) -> np.ndarray:
    return add_caption(enlarge(screen, 2, 1), "\n".join(lines), 2, 1)


def test_an_ended_replay_keeps_its_last_frame(
    pong: Replay, breakout: Replay, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shown: list[int] = []
    pong.render(tmp_path / "a.mkv", scale=1, beside=[breakout], progress=shown.append)
    frames = video_frames(tmp_path / "a.mkv")
    first, second = list(pong.frames()), list(breakout.frames())
    assert len(frames) == len(first) == sum(shown) == 40
    assert len(second) == 16
    assert frames[0].shape == (HEIGHT + 2 * LINE, 2 * WIDTH + GAP, 3)
    for number, image in enumerate(frames):
        left, right = first[number], second[min(number, 15)]
        assert np.array_equal(image[:, :WIDTH], cell(left.screen, "pong", f"score {left.score}"))
        assert np.array_equal(image[:, WIDTH + GAP :], cell(right.screen, "breakout", "score 0   lives 5"))
        assert not image[:, WIDTH : WIDTH + GAP].any()
    facts = video_facts(tmp_path / "a.mkv")
    assert [(one["name"], one["task"]["game"]) for one in (facts, *facts["beside"])] == [
        ("pong", "pong"),
        ("breakout", "breakout"),
    ]
    assert main(["info", str(tmp_path / "a.mkv")]) == 0
    names = [line.split()[1] for line in capsys.readouterr().out.splitlines() if line.startswith("  name ")]
    assert names == ["pong", "breakout"]


def test_the_sound_is_that_of_the_first(pong: Replay, breakout: Replay, tmp_path: Path) -> None:
    breakout.render(tmp_path / "a.mkv", scale=1, beside=[pong])
    with av.open(tmp_path / "a.mkv") as container:
        samples = np.concatenate([frame.to_ndarray().ravel() for frame in container.decode(audio=0)])
    heard = np.concatenate([frame.audio for frame in breakout.frames(sound=True)])
    assert np.array_equal(samples[: len(heard)], (heard.astype(int) - 128) * 128)
    assert len(samples) == 40 * 512
    assert not samples[len(heard) :].any()


@pytest.mark.parametrize(
    ("count", "rows", "columns"), [(2, 1, 2), (3, 1, 3), (4, 2, 2), (5, 2, 3), (9, 3, 3), (10, 3, 4)]
)
def test_more_than_three_make_a_square(pong: Replay, tmp_path: Path, count: int, rows: int, columns: int) -> None:
    path = pong.render(tmp_path / "a.png", scale=1, beside=[pong] * (count - 1))
    with av.open(path) as container:
        (image,) = (frame.to_ndarray(format="rgb24") for frame in container.decode(video=0))
    height = HEIGHT + 2 * LINE + GAP
    assert image.shape == (rows * height - GAP, columns * (WIDTH + GAP) - GAP, 3)
    assert image[-2 * LINE - HEIGHT : -2 * LINE, :WIDTH].any()  # the last row has a replay
    assert image[-2 * LINE - HEIGHT : -2 * LINE, -WIDTH:].any() == (count == rows * columns)


def test_screens_of_other_sizes_and_games_of_two_players(pong: Replay, tmp_path: Path) -> None:
    core = MultiplayerCore("combat", players=2, seed=0, frameskip=1)
    with RecordReplay(core, tmp_path / "combat.a26r") as match:
        match.reset()
        for _ in range(30):
            match.act_players([1, 0])
    combat = Replay.load(tmp_path / "combat.a26r")
    pal = Replay.load(record(tmp_path / "pal.a26r", next(name for name in atari.games if tall(name)), 4, seed=0))
    assert pal.game.screen.shape[0] > HEIGHT
    pong.render(tmp_path / "a.mkv", scale=1, beside=[combat, pal])
    last = video_frames(tmp_path / "a.mkv")[-1]
    heights = [replay.game.screen.shape[0] for replay in (pong, combat, pal)]
    assert len(set(heights)) == 3
    rows = max(heights)
    assert last.shape == (rows + 2 * LINE, 3 * WIDTH + 2 * GAP, 3)
    top = (rows - HEIGHT) // 2
    assert not last[:top, :WIDTH].any()
    assert np.array_equal(last[top : top + HEIGHT, :WIDTH:2], list(pong.frames())[-1].screen)
    below = (rows - heights[2]) // 2
    assert np.array_equal(last[below : below + heights[2], -WIDTH::2], list(pal.frames())[-1].screen)
    scores = add_caption(np.zeros((rows, WIDTH, 3), np.uint8), "combat\nscore 0, 0", 2, 1)
    frame = list(combat.frames())[-1]
    assert frame.scores == (0, 0)
    assert frame.all_lives == (0, 0)
    assert np.array_equal(last[rows:, WIDTH + GAP : 2 * WIDTH + GAP], scores[rows:])


def tall(name: str) -> bool:
    return atari.games[name].screen.shape[0] > HEIGHT and atari.games[name].players == 1


def test_parts_and_overlays_apply_to_each(pong: Replay, breakout: Replay, tmp_path: Path) -> None:
    pong.render(tmp_path / "a.mkv", scale=1, start=8, stop=12, overlay=("curve",), beside=[breakout])
    frames = video_frames(tmp_path / "a.mkv")
    assert len(frames) == 4
    assert frames[0].shape == (HEIGHT + CURVE_ROWS + LINE, 2 * WIDTH + GAP, 3)
    for replay, left in ((pong, 0), (breakout, WIDTH + GAP)):
        expected = next(replay.frames(8)).screen
        assert np.array_equal(frames[0][:HEIGHT, left : left + WIDTH : 2], expected)


def test_the_best_episode_of_each(tmp_path: Path) -> None:
    options = {"max_num_frames_per_episode": 200}
    first = Replay.load(record(tmp_path / "a.a26r", "pong", 90, seed=1, **options))
    second = Replay.load(record(tmp_path / "b.a26r", "pong", 90, seed=4, **options))
    first.render(tmp_path / "a.mkv", scale=1, episode="best", beside=[second])
    frames = video_frames(tmp_path / "a.mkv")
    best = [list(replay.frames(episode="best")) for replay in (first, second)]
    assert [len(played) for played in best] == [each.episodes[each.best_episode].frames for each in (first, second)]
    assert len(frames) == max(map(len, best))
    assert np.array_equal(frames[0][:HEIGHT, WIDTH + GAP :: 2], best[1][0].screen)


def test_names_are_told_apart_and_cut() -> None:
    assert labels(["runs/a/pong", "runs/b/pong", "random"], 160) == ["a/pong", "b/pong", "random"]
    assert labels(["runs/a/pong", "runs/b/qbert"], 160) == ["pong", "qbert"]
    assert labels(["pong", "pong", "qbert"], 160) == ["pong (1)", "pong (2)", "qbert"]
    long = [f"{'x' * 80}-{seed}-{'y' * 80}" for seed in (0, 1)]
    cut = labels(long, 160)
    assert cut[0].startswith("xxx")
    assert cut[0].endswith("yyy (1)")
    assert max(map(len, cut)) == 53
    assert cut[0] != cut[1]


@pytest.mark.parametrize(
    ("make", "error", "text"),
    [
        (lambda pong: {"beside": pong.path}, TypeError, "beside is a list of replays"),
        (lambda pong: {"beside": ["b.a26r"]}, TypeError, r"got 'b.a26r' in it"),
        (lambda pong: {"beside": [pong] * 80}, ValueError, "sides up to 8192; choose a scale below 16, or fewer"),
        (lambda pong: {"beside": [pong], "start": 99}, ValueError, "start must be within 0..40, got 99"),
        (lambda pong: {"beside": [pong], "scale": 0}, ValueError, "scale must be within 1..16, got 0"),
    ],
)
def test_wrong_arguments(
    pong: Replay, tmp_path: Path, make: Callable[[Replay], dict[str, object]], error: type[Exception], text: str
) -> None:
    with pytest.raises(error, match=text):
        pong.render(tmp_path / "a.mp4", **{"scale": 16, **make(pong)})  # type: ignore[arg-type]
    assert [path.name for path in tmp_path.iterdir()] == ["pong.a26r"]
