"""`atari replay`: show, verify and render."""

import json
from pathlib import Path

import av
import numpy as np
import pytest
from cli_tools import Capture, read, read_json, refused
from replay_tools import record
from video_reader import video_frames

import atari
from atari.cli import main
from atari.play import Session
from atari.recording import Replay
from atari.recording.replay import file_format
from atari.recording.video.images import line_height
from atari.recording.video.overlay import CURVE_ROWS


@pytest.fixture(autouse=True)
def replay(folder: Path) -> Replay:
    """A replay of two episodes, in the file a.a26r."""
    return Replay.load(record(folder / "a.a26r", "pong", 90, seed=1, max_num_frames_per_episode=200))


def render(capsys: Capture, *words: str) -> str:
    return read(capsys, "replay", "render", "a.a26r", *words)


def tampered() -> str:
    """A replay with the hashes of another game."""
    content = file_format.read("a.a26r")
    writer = file_format.ReplayFileWriter("b.a26r", content.header)
    for play in content.plays:
        short_hashes = bytes(mark ^ (play.first + i >= 250) for i, mark in enumerate(play.short_hashes))
        writer.play(play._replace(short_hashes=short_hashes))
    writer.end(content.end or {})
    return "b.a26r"


def test_show(replay: Replay, capsys: Capture) -> None:
    lines = read(capsys, "replay", "show", "a.a26r").splitlines()
    assert lines[0] == "a.a26r: Pong"
    assert lines[1].startswith("  length    360 frames, 0:06.0, ")
    assert lines[2].startswith("  recorded  AtariEnv on core 'native', atari-envs ")
    assert "max_num_frames_per_episode=200" in lines[3]
    seeds = ", ".join(map(str, replay.seeds))
    assert lines[4] == f"  seeds     {seeds} (of the core, which a reset draws from its own seed)"
    assert lines[-3].split() == ["episode", "frames", "time", "score", "end"]
    assert [line.split()[:3] + line.split()[4:] for line in lines[-2:]] == [
        ["0", "200", "0:03.3", "truncated"],
        ["1", "160", "0:02.7", "open"],
    ]


def test_show_as_json(replay: Replay, capsys: Capture) -> None:
    shown = read_json(capsys, "replay", "show", "a.a26r")
    assert (shown["game"], shown["complete"], shown["frames"], shown["format"]) == ("pong", True, 360, 1)
    assert [episode["frames"] for episode in shown["episodes"]] == [200, 160]
    assert (shown["steps"], shown["core_seeds"]) == (replay.steps, list(replay.seeds))
    assert shown["task"]["max_num_frames_per_episode"] == 200


@pytest.mark.parametrize("core", ["native", "plain", "ale"])
def test_verify(core: str, capsys: Capture) -> None:
    atari.AtariEnv("pong", core=core).close()  # with an ale-py too old for `core="ale"`, the test ends here
    assert read(capsys, "replay", "verify", "a.a26r", "--core", core) == f"a.a26r: equal, 360 frames on core '{core}'\n"


def test_a_difference_is_1_and_names_the_frame(capsys: Capture) -> None:
    assert main(["replay", "verify", "a.a26r", tampered()]) == 1
    assert capsys.readouterr().out.splitlines() == [
        "a.a26r: equal, 360 frames on core 'native'",
        "b.a26r: frame 250 differs in RAM; it may have begun at frame 240, 251 frames on core 'native'",
    ]
    assert main(["replay", "verify", "b.a26r", "--json"]) == 1
    (result,) = json.loads(capsys.readouterr().out)
    assert result["equal"] is False
    assert result["divergence"] == {"frame": 250, "since": 240, "what": "RAM"}


def test_render(capsys: Capture) -> None:
    assert render(capsys, "--stop", "40") == f"40 frames in {Path('a.mp4').resolve()}\n"
    assert main(["replay", "render", "a.a26r", "-o", "b.mkv", "--scale", "1", "--start", "300", "--stop", "999"]) == 0
    for name, size, frames in (("a.mp4", (640, 420), 40), ("b.mkv", (320, 210), 60)):
        with av.open(name) as container:
            video = container.streams.video[0]
            assert (video.width, video.height) == size
            assert sum(1 for _ in container.decode(video)) == frames


def test_a_cut_replay_is_a_warning_of_one_line(capsys: Capture) -> None:
    data = Path("a.a26r").read_bytes()
    Path("a.a26r").write_bytes(data[:-20])
    assert main(["replay", "show", "a.a26r"]) == 0
    captured = capsys.readouterr()
    assert captured.err == "atari: warning: a.a26r was cut while it was recorded; its first 360 frames are whole\n"
    assert "cut while it was recorded" in captured.out


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["show", "none.a26r"], "there is no file none.a26r; check the path"),
        (["verify", "text.txt"], "text.txt is no replay of atari-envs"),
        (["render", "a.a26r", "-o", "a.avi"], "must end in one of"),
        (["render", "a.a26r", "--start", "360"], "there are no frames to render: the replay has 360 frames"),
        (["show", "damaged.a26r"], "the replay is damaged at offset 8"),
    ],
)
def test_what_cannot_be_done_is_one_line(words: list[str], text: str, capsys: Capture) -> None:
    Path("text.txt").write_text("hello")
    data = bytearray(Path("a.a26r").read_bytes())
    data[40] ^= 1
    Path("damaged.a26r").write_bytes(data)
    refused(capsys, ["replay", *words], text)


def test_rewound_frames_are_counted(capsys: Capture) -> None:
    session = Session("pong", replay=Path("rewound.a26r"), seed=1)
    for _ in range(100):
        session.play(session.legal_actions[0])
    assert session.rewind()
    session.close()
    facts = read_json(capsys, "replay", "show", "rewound.a26r")
    (episode,) = facts["episodes"]
    assert facts["frames"] == 100
    assert episode["frames"] + facts["frames_rewound"] == 100
    assert facts["frames_rewound"] > 0
    assert f"{facts['frames_rewound']} frames of it played and then rewound" in read(
        capsys, "replay", "show", "rewound.a26r"
    )


def test_an_episode_alone(replay: Replay, capsys: Capture) -> None:
    best = replay.best_episode
    assert [episode.frames for episode in replay.episodes] == [200, 160]
    assert render(capsys, "-o", "1.mkv", "--episode", "1", "--scale", "1").startswith("160 frames in ")
    expected = [frame.screen for frame in replay.frames(200)]
    assert all(
        np.array_equal(shown[:, ::2], screen)
        for shown, screen in zip(video_frames(Path("1.mkv")), expected, strict=True)
    )
    words = ["--episode", "best", "--overlay", "score,curve", "--scale", "1"]
    assert main(["replay", "render", "a.a26r", "-o", "best.mkv", *words]) == 0
    frames = video_frames(Path("best.mkv"))
    assert len(frames) == replay.episodes[best].frames
    assert frames[0].shape == (210 + CURVE_ROWS + line_height(1), 320, 3)


@pytest.mark.parametrize("words", ["--start best", "--start 30", "--episode 1 --start best"])
def test_seconds_from_a_start(replay: Replay, capsys: Capture, words: str) -> None:
    first = 30 if "30" in words else replay.best_start(60, episode=1 if "1" in words else None)
    assert first >= (replay.episodes[0].frames if "1" in words else 0)
    where = f", from frame {first} on," if "best" in words else ""
    printed = render(capsys, "-o", "part.mkv", *words.split(), "--seconds", "1", "--scale", "1")
    assert printed.startswith(f"60 frames{where} in ")
    assert np.array_equal(video_frames(Path("part.mkv"))[0][:, ::2], next(replay.frames(first)).screen)


@pytest.mark.parametrize(
    ("words", "text", "code"),
    [
        (["-o", "a.gif", "--episode", "2"], "a.a26r has no episode 2; it has 2, numbered from 0", 1),
        (["--episode", "best", "--stop", "3"], "whole episode, or with --start best --seconds S the best part", 1),
        (["--episode", "best", "--seconds", "3"], "--episode shows a whole episode, or with --start best", 1),
        (["--start", "best"], "--start best needs --seconds, the length of the part", 1),
        (["-o", "a.gif", "-o", "b.mp4"], "argument -o/--output: it is given twice; leave one of them out", 2),
        (["--scale", "1", "--scale=2"], "argument --scale: it is given twice", 2),
        (["--episode", "bets"], "'bets' is not a whole number within 0..1000000000, nor best", 2),
    ],
)
def test_a_wrong_part(capsys: Capture, words: list[str], text: str, code: int) -> None:
    refused(capsys, ["replay", "render", "a.a26r", *words], text, code)
    assert [path.name for path in Path().iterdir()] == ["a.a26r"]


def test_the_best_part_is_no_longer_than_its_episode(replay: Replay) -> None:
    with pytest.raises(ValueError, match="frames must be within"):
        replay.best_start(replay.episodes[1].frames + 1, episode=1)


def test_replays_and_policies_side_by_side(replay: Replay, capsys: Capture) -> None:
    words = ["a.a26r", "random", "-o", "b.mkv", "--scale", "1", "--stop", "90", "--seed", "3"]
    assert main(["replay", "render", *words, "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out) == {"files": ["a.a26r", "random"], "frames": 90, "video": str(Path("b.mkv").resolve())}
    assert main(["record", "pong", "--policy", "random", "--preset", "baselines", "--seed", "3", "-o", "r.a26r"]) == 0
    other = Replay.load("r.a26r")
    assert err == f"random: seed 3, score {other.episodes[0].score}\n"
    frames = video_frames(Path("b.mkv"))
    assert len(frames) == 90
    for left, one in ((0, replay), (328, other)):
        assert np.array_equal(frames[80][:210, left : left + 320 : 2], next(one.frames(80, 81)).screen)


def test_a_picture_of_several(replay: Replay, capsys: Capture) -> None:
    assert render(capsys, "a.a26r", "-o", "a.png", "--frame", "best") == f"a picture in {Path('a.png').resolve()}\n"
    assert render(capsys, "a.a26r", "-o", "b.png", "--frame", "3") == f"frame 3 in {Path('b.png').resolve()}\n"


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["a.a26r", "a.a26r"], "the video of a.a26r and a.a26r needs a name: add -o FILE"),
        (["random"], "the video of random needs a name: add -o FILE"),
        (["random", "a.a26r", "-o", "b.mp4"], "random does not say which game it plays; let it play one to a replay"),
        (["a.a26r", "a.a26r", "-o", "b.mp4", "--seed", "1"], "--seed is for policies"),
        (["a.a26r", "a.a26r", "-o", "b.mp4", "--start", "best", "--seconds", "1"], "--start best is a part of one"),
        (["a.a26r", "random", "-o", "b.avi"], "must end in one of"),
        (["a.a26r", "none.a26r", "-o", "b.mp4"], "there is no file none.a26r"),
    ],
)
def test_a_wrong_film(capsys: Capture, words: list[str], text: str) -> None:
    assert refused(capsys, ["replay", "render", *words], text) == ""
    assert [path.name for path in Path().iterdir()] == ["a.a26r"]
