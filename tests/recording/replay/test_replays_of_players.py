"""Replays of several players: the same game again, also after snapshots; a damaged file is a `ValueError`."""

import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from video_reader import sound, video_frames

import atari
from atari.lab import Freeze
from atari.multiplayer import MultiplayerCore
from atari.recording import RecordReplay, Replay, VideoWriter
from atari.recording.video.audio import to_16_bit

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
    options: dict[str, Any] = {"mode": 3, "seed": 3, "repeat_action_probability": [0.5, 0.0], "difficulty": 1}
    options |= dict.fromkeys(("mode_numbers", "end_of_reset", "random_words"), "ale_py")
    options["max_num_frames_per_episode"] = 200
    played = record(tmp_path / "a.a26r", "pong", 500, **options)
    replay = Replay.load(tmp_path / "a.a26r")
    assert replay.verify()
    assert frames_of(replay) == played
    assert {episode.end for episode in replay.episodes[:-1]} == {"truncated"}
    kept = MultiplayerCore("pong", **options).options
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


def test_a_video_has_the_frames_and_the_sound_of_the_game(tmp_path: Path) -> None:
    actions = np.random.default_rng(0).integers(0, 18, (60, 2)).tolist()
    with RecordReplay(MultiplayerCore("combat"), tmp_path / "match.a26r") as match:
        match.reset()
        for action in actions:
            match.act_players(action)
    path = Replay.load(tmp_path / "match.a26r").render(tmp_path / "match.mkv", scale=1)
    again = MultiplayerCore("combat", sound=True)
    again.reset()
    frames, samples = [], []
    for action in actions:
        again.act_players(action)
        frames.append(again.screen_rgb())
        samples.append(to_16_bit(again.audio()))
    assert np.ptp(np.concatenate(samples)) > 0
    shown = video_frames(path)
    assert len(shown) == 60
    assert all(np.array_equal(one[:, ::2], two) for one, two in zip(shown, frames, strict=True))
    assert np.array_equal(sound(path)[0], np.concatenate(samples))


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
