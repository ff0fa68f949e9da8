"""Replays of several players: the same game again, also after snapshots; a damaged file is a `ValueError`."""

import json
import random
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atari
from atari.lab import Freeze
from atari.multiplayer import MultiplayerCore
from atari.recording import RecordReplay, Replay, VideoWriter
from atari.recording.replay import file_format
from atari.recording.replay.events import ACTS_PER_CHUNK, Event, Kind, pack, unpack

GAMES = {"pong": {"mode": 6}, "warlords": {}, "combat": {"mode": 9}, "joust": {}, "flag_capture": {}, "freeway": {}}
Played = list[tuple[bytes, tuple[int, ...], tuple[int, ...]]]


def play(core: Any, frames: int, seed: int = 0) -> Played:
    """RAM, rewards and lives of each frame of a game at random; a new game begins where one ends."""
    source = random.Random(seed)
    played = []
    for _ in range(frames):
        if core.game_over or core.truncated:
            core.reset()
        rewards = core.act_players([source.randrange(18) for _ in range(core.players)])
        played.append((core.ram().tobytes(), tuple(rewards), tuple(core.player_lives)))
    return played


def frames_of(replay: Replay, start: int = 0) -> Played:
    return [(frame.ram.tobytes(), frame.rewards, frame.all_lives) for frame in replay.frames(start)]


def record(path: Path, game: str = "pong", frames: int = 300, **options: Any) -> Played:
    with RecordReplay(MultiplayerCore(game, **options), path) as match:
        match.reset()
        return play(match, frames)


@pytest.mark.parametrize("game", GAMES)
def test_a_game_plays_again(game: str, tmp_path: Path) -> None:
    played = record(tmp_path / "a.a26r", game, 700, seed=7, repeat_action_probability=0.25, **GAMES[game])
    replay = Replay.load(tmp_path / "a.a26r")
    assert replay.verify()
    assert replay.complete
    assert frames_of(replay) == played
    assert frames_of(replay, 650) == played[650:]
    assert (replay.players, replay.seeds, replay.game.id) == (len(played[0][1]), (7,), game)
    assert (replay.steps, replay.frames_rewound) == (0, 0)


def test_the_caption_has_all_players(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    captions = []
    monkeypatch.setattr(VideoWriter, "write", lambda self, image, audio, caption: captions.append(caption))
    record(tmp_path / "a.a26r", frames=400)
    replay = Replay.load(tmp_path / "a.a26r")
    replay.render(tmp_path / "a.gif", overlay=("score", "action"))
    *_, last = replay.frames()
    first, second = (atari.Action(action).name for action in last.actions)
    assert list(last.scores) == replay.episodes[-1].scores
    assert captions[-1] == f"score {last.scores[0]}, {last.scores[1]}   action {first}, {second}"
    with pytest.raises(ValueError, match="has 2 players, and no task; `options` has what was played"):
        replay.task  # noqa: B018


@pytest.mark.parametrize("when", ["before", "during"])
def test_writes_are_recorded(when: str, tmp_path: Path) -> None:
    core = MultiplayerCore("pong", seed=7)
    frozen = [Freeze(core, {13: 5})] if when == "before" else []
    with RecordReplay(core, tmp_path / "a.a26r") as match:
        match.reset()
        frozen = frozen or [Freeze(match, {13: 5})]
        played = play(match, 90)
        for freeze in frozen:
            freeze.release()
        played += play(match, 30)
    replay = Replay.load(tmp_path / "a.a26r")
    assert replay.verify()
    assert frames_of(replay) == played
    assert {ram[13] for ram, *_ in played[:90]} == {5}


def test_options_may_be_numpy_s(tmp_path: Path) -> None:
    options: dict[str, Any] = {"difficulty": np.int64(0), "max_num_frames_per_episode": np.int64(500)}
    record(tmp_path / "a.a26r", frames=10, **options)
    assert Replay.load(tmp_path / "a.a26r").header["options"]["max_num_frames_per_episode"] == 500


def test_options_are_kept(tmp_path: Path) -> None:
    options: dict[str, Any] = {
        "mode": 4,
        "seed": 3,
        "repeat_action_probability": [0.5, 0.0],
        "difficulty": 1,
        "max_num_frames_per_episode": 200,
        "mode_numbers": "ale_py",
        "end_of_reset": "ale_py",
        "random_words": "ale_py",
    }
    played = record(tmp_path / "a.a26r", "pong", 500, **{**options, "mode": 3})
    replay = Replay.load(tmp_path / "a.a26r")
    assert replay.verify()
    assert frames_of(replay) == played
    assert {episode.end for episode in replay.episodes[:-1]} == {"truncated"}
    kept = MultiplayerCore("pong", **{**options, "mode": 3}).options
    assert replay.options == kept
    assert MultiplayerCore("pong", **kept).options == kept
    with RecordReplay(MultiplayerCore("flag_capture", corrected_scores=True), tmp_path / "b.a26r") as match:
        match.reset()
    assert Replay.load(tmp_path / "b.a26r").options["corrected_scores"] is True


def test_episodes_have_the_scores_of_all(tmp_path: Path) -> None:
    played = record(tmp_path / "a.a26r", "pong", 1500, max_num_frames_per_episode=700)
    first, *rest = Replay.load(tmp_path / "a.a26r").episodes
    assert first.end == "truncated"
    assert first.scores is not None
    assert first.score == first.scores[0]
    assert rest
    total = np.sum([rewards for _, rewards, _ in played], 0).tolist()
    scores = [episode.scores or [] for episode in (first, *rest)]
    assert np.sum(scores, 0).tolist() == total


def test_from_the_middle_on_and_with_snapshots_writes_and_seeds(tmp_path: Path) -> None:
    core = MultiplayerCore("combat", seed=5)
    core.reset()
    play(core, 50)
    with RecordReplay(core, tmp_path / "a.a26r") as match:
        before = match.snapshot()
        played = play(match, 100)
        match.restore(before)
        played += play(match, 60, seed=1)
        match.set_ram(3, 7)
        played += play(match, 10)
        match.seed(9)
        match.reset()
        played += play(match, 10)
    replay = Replay.load(tmp_path / "a.a26r")
    assert replay.verify()
    assert frames_of(replay) == played
    assert replay.seeds == (5, 9)
    again = replay.seek(130)
    assert again.ram().tobytes() == played[129][0]


def test_a_replay_becomes_a_video(tmp_path: Path) -> None:
    played = record(tmp_path / "a.a26r", "joust", 120, seed=2)
    replay = Replay.load(tmp_path / "a.a26r")
    assert replay.frames_total == 120
    assert replay.episodes[0].scores == [sum(rewards[player] for _, rewards, _ in played) for player in range(2)]
    pytest.importorskip("av")
    assert replay.render(tmp_path / "a.mkv", stop=20).stat().st_size > 1000


def test_wrong_uses(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="frameskip=1, got 4"):
        RecordReplay(MultiplayerCore("pong", frameskip=4), tmp_path / "a.a26r")
    with RecordReplay(MultiplayerCore("pong"), tmp_path / "a.a26r") as match:
        match.reset()
        for call in (lambda: match.act(0), lambda: match.set_mode(3), lambda: match.set_difficulty(1)):
            with pytest.raises(RuntimeError):
                call()
        with pytest.raises(ValueError, match="2 players"):
            match.act_players([0])
        match.act_players([1, 1])
    replay = Replay.load(tmp_path / "a.a26r")
    assert replay.verify()
    for wrong in (lambda: replay.make_env(), lambda: replay.verify("ale"), lambda: list(replay.frames(core="plain"))):
        with pytest.raises(ValueError, match="players"):
            wrong()
    with pytest.raises(ValueError, match="players"):
        list(replay.walk(atari.cores.NativeCore("pong")))


def write(path: Path, *chunks: tuple[bytes, bytes]) -> Path:
    path.write_bytes(b"ATARIRPL" + b"".join(file_format._chunk(*chunk) for chunk in chunks))
    return path


def use(path: Path) -> bool:
    """Whether a replay can be used; nothing but `ValueError` is raised."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            replay = Replay.load(path)
            assert isinstance(repr((replay.options, replay.episodes, replay.seeds)), str)
            replay.verify()
        except ValueError:
            return False
    return True


def test_changed_headers_and_ends(tmp_path: Path) -> None:
    record(tmp_path / "a.a26r", frames=20)
    content = file_format.read(tmp_path / "a.a26r")
    play_chunk, header, end = (b"P", content.plays[0].pack()), content.header, content.end
    assert end is not None
    values: list[Any] = [
        None,
        True,
        -1,
        3,
        2.0,
        2**40,
        10**300,
        0.5,
        float("nan"),
        "",
        "x",
        [],
        [[]],
        [1],
        {},
        {"x": 1},
    ]
    results = []
    for value in values:
        changed = [{**header, name: value} for name in (*header, "more")]
        changed += [{**header, "options": {**header["options"], name: value}} for name in header["options"]]
        changed += [{**header, "options": {**header["options"], name: value}} for name in ("game", "rom", "sound", "x")]
        for one in changed:
            chunks = (b"H", json.dumps(one).encode()), play_chunk, (b"E", json.dumps(end).encode())
            results.append(use(write(tmp_path / "b.a26r", *chunks)))
        for name in ("score", "scores", "frames", "end", "more"):
            other = {**end, "episodes": [{**end["episodes"][0], name: value}]}
            chunks = (b"H", json.dumps(header).encode()), play_chunk, (b"E", json.dumps(other).encode())
            results.append(use(write(tmp_path / "b.a26r", *chunks)))
    assert results.count(False) > 250
    assert results.count(True) > 10


def test_changed_events(tmp_path: Path) -> None:
    record(tmp_path / "a.a26r", frames=20)
    content = file_format.read(tmp_path / "a.a26r")
    header = b"H", json.dumps(content.header).encode()
    events = unpack(content.plays[0].events)
    wrong = [
        [Event(Kind.ACT, (1, 5))],
        [Event(Kind.ACTIONS, (18**2, 1))],
        [Event(Kind.ACTIONS, (0, ACTS_PER_CHUNK + 1))],
        [Event(Kind.MODE, (3,))],
        [Event(Kind.DIFFICULTY, (1,))],
        [Event(Kind.ADD_WRITE, (0, 0))],
        [Event(Kind.REMOVE_WRITE, (0,))],
        [Event(Kind.LOAD, (0,))],
        [Event(Kind.RESTORE, (0,))],
        [Event(Kind.POKE, (128, 0))],
        [Event(Kind.SEED, (2**32 - 1,)), Event(Kind.RESTORE, (1,))],
        [Event(Kind.CONTINUOUS_ACTION, (), (1.0, 1.0, 1.0))],
    ]
    for change in wrong:
        chunk = content.plays[0]._replace(events=pack([*change, *events]))
        assert not use(write(tmp_path / "b.a26r", header, (b"P", chunk.pack()))), change
    data = (tmp_path / "a.a26r").read_bytes()
    source = random.Random(1)
    for size in source.sample(range(len(data)), 60):
        (tmp_path / "b.a26r").write_bytes(data[:size])
        use(tmp_path / "b.a26r")
    for _ in range(60):
        damaged = bytearray(data)
        damaged[source.randrange(len(data))] ^= 1 << source.randrange(8)
        (tmp_path / "b.a26r").write_bytes(damaged)
        assert not use(tmp_path / "b.a26r")


def test_actions_of_several_players_in_a_replay_of_one_are_refused(tmp_path: Path) -> None:
    from replay_tools import record as record_one

    content = file_format.read(record_one(tmp_path / "a.a26r", steps=3))
    events = [Event(Kind.ACTIONS, (0, 1)), *unpack(content.plays[0].events)]
    chunk = content.plays[0]._replace(events=pack(events))
    header = b"H", json.dumps(content.header).encode()
    assert not use(write(tmp_path / "b.a26r", header, (b"P", chunk.pack())))
    several = b"H", json.dumps({**content.header, "players": 2}).encode()
    assert not use(write(tmp_path / "b.a26r", several, (b"P", content.plays[0].pack())))
