"""Replays: a recorded game is reproduced exactly on every core, and a difference names its frame."""

import os
import sys
import warnings
from pathlib import Path
from typing import Any

import av
import gymnasium
import numpy as np
import pytest
from replay_tools import play, record

import atari
from atari import wrappers
from atari.cores import CORES
from atari.recording import RecordReplay, RecordVideo, Replay, to_minari
from atari.recording.replay.events import Event, Kind, pack, unpack
from atari.recording.replay.file_format import ReplayContent, ReplayFileWriter, read
from atari.recording.replay.results import Divergence, EpisodeSummary
from atari.recording.video.writer import frame_rate

GAMES = [game.id for game in atari.games.playable()]


@pytest.mark.parametrize(
    ("setting", "value", "played"), [("Int", 3, "frame_skip=1"), ("Bool", True, "color_averaging=False")]
)
def test_what_ale_has_set_and_no_task_has_is_refused(setting: str, value: Any, played: str, tmp_path: Path) -> None:
    env = atari.AtariEnv("breakout")
    getattr(env.ale, f"set{setting}")(played.partition("=")[0], value)
    env.reset(seed=0)
    with pytest.raises(ValueError, match=f"a replay needs {played}, and env.ale has set {value}; set it back"):
        RecordReplay(env, tmp_path / "a.a26r")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("game", GAMES)
def test_every_game_plays_as_recorded_on_the_other_core(game: str, tmp_path: Path) -> None:
    number = GAMES.index(game)
    recorded_on, core = ("ale", "native") if number % 8 == 7 else ("native", "ale")  # ale-py loads a game for each seed
    path = record(tmp_path / "a.a26r", game, 16, seed=number, core=recorded_on)
    replay = Replay.load(path)
    assert replay.header["core"] == recorded_on
    assert 60 <= replay.frames_total <= 64
    result = replay.verify(core)
    assert result, result.divergence
    assert result.frames == replay.frames_total


@pytest.mark.parametrize(
    "options",
    [
        {"frameskip": (2, 5), "repeat_action_probability": 0.0},
        {"frameskip": 1, "repeat_action_probability": 0.7, "full_action_space": True},
        {"max_num_frames_per_episode": 50},
        {"mode": 4, "difficulty": 1, "obs_type": "ram"},
        {"sound_obs": True, "obs_type": "grayscale"},
    ],
)
def test_options_are_kept(options: dict[str, Any], tmp_path: Path) -> None:
    replay = Replay.load(record(tmp_path / "a.a26r", "breakout", 120, **options))
    assert {name: replay.options[name] for name in options} == options
    assert replay.verify("native")
    assert replay.verify("ale")
    with replay.make_env() as env:
        assert env.core.name == "native"
        assert {name: env.ale_options()[name] for name in options} == options
        assert env.task == replay.task


def test_continuous_actions_are_kept(tmp_path: Path) -> None:
    replay = Replay.load(record(tmp_path / "a.a26r", "pong", 40, continuous=True))
    assert replay.verify("ale")
    assert len({frame.strength for frame in replay.frames()}) == 40


def test_frames_show_what_was_played(tmp_path: Path) -> None:
    env = RecordReplay(atari.AtariEnv("breakout", obs_type="ram"), tmp_path / "a.a26r")
    played = play(env, 150, seed=4)
    env.close()
    frames = list(Replay.load(env.path).frames())
    last_of_steps = [frame for frame in frames if frame.ends_step]
    assert len(last_of_steps) == len(played) == 150
    for frame, (ram, _, terminated, truncated, info) in zip(last_of_steps, played, strict=True):
        assert np.array_equal(frame.ram, ram)
        assert (frame.terminated, frame.truncated, frame.lives) == (terminated, truncated, info["lives"])
    assert sum(frame.reward for frame in frames) == sum(result[1] for result in played) > 0
    assert [frame.index for frame in frames] == list(range(len(frames)))
    assert not any(frame.audio.any() for frame in frames)


def test_a_seed_gives_the_game_it_always_gives(tmp_path: Path) -> None:
    env = RecordReplay(atari.AtariEnv("seaquest", obs_type="ram"), tmp_path / "a.a26r")
    recorded = [result[0] for result in play(env, 50, seed=8)]
    plain = [result[0] for result in play(atari.AtariEnv("seaquest", obs_type="ram"), 50, seed=8)]
    env.close()
    assert np.array_equal(recorded, plain)


def test_a_game_without_a_seed_is_another_each_time_and_plays_again(tmp_path: Path) -> None:
    checks = set()
    for name in ("a.a26r", "b.a26r"):
        replay = Replay.load(record(tmp_path / name, "seaquest", 60, seed=None))
        assert replay.verify("ale")
        checks.add(b"".join(frame.ram.tobytes() for frame in replay.frames()))
    assert len(checks) == 2


def test_episodes_are_listed(tmp_path: Path) -> None:
    replay = Replay.load(record(tmp_path / "a.a26r", "breakout", 900, seed=2, max_num_frames_per_episode=2000))
    ends = [episode.end for episode in replay.episodes]
    assert ends[:-1] == ["game over"] * (len(ends) - 1)
    assert len(ends) >= 3
    assert sum(episode.frames for episode in replay.episodes) == replay.frames_total
    frames = list(replay.frames())
    for number, episode in enumerate(replay.episodes):
        assert sum(frame.reward for frame in frames if frame.episode == number) == episode.score
    cut = Replay.load(tmp_path / "a.a26r")
    cut._content = ReplayContent(replay._content.header, replay._content.plays, (), None)
    assert cut.episodes == replay.episodes


def test_steps_after_the_end_are_kept_and_are_no_frames(tmp_path: Path) -> None:
    env = RecordReplay(atari.AtariEnv("pong", max_num_frames_per_episode=10), tmp_path / "a.a26r")
    env.reset(seed=0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of steps after the end
        for _ in range(8):
            env.step(2)
    env.reset()
    env.step(0)
    env.close()
    replay = Replay.load(env.path)
    assert replay.episodes == (EpisodeSummary(10, 0, "truncated"), EpisodeSummary(4, 0, "open"))
    assert replay.frames_total == 14
    assert replay.verify("ale")
    # The end of the game cut the third step short.
    assert [frame.index for frame in replay.frames() if frame.ends_step] == [3, 7, 9, 13]
    assert replay.steps == 9


@pytest.mark.parametrize("name", ["dqn2015", "baselines", "envpool"])
def test_wrappers_may_be_inside_or_outside(name: str, tmp_path: Path) -> None:
    outside = RecordReplay(atari.make("breakout", preset=name), tmp_path / "outside.a26r")
    inside = wrappers.preset(
        RecordReplay(atari.AtariEnv("breakout", **wrappers.preset_options(name)), tmp_path / "inside.a26r"), name
    )
    for env in (outside, inside):
        play(env, 120, seed=5)
        env.close()
    first, second = (Replay.load(tmp_path / f"{name}.a26r") for name in ("outside", "inside"))
    assert first.frames_total == second.frames_total > 400
    assert first.verify("ale")
    assert second.verify("ale")
    pairs = zip(first.frames(), second.frames(), strict=True)
    assert all(a.action == b.action and np.array_equal(a.ram, b.ram) for a, b in pairs)


@pytest.mark.parametrize("core", CORES)
def test_restoring_snapshots_plays_on_every_core(core: str, tmp_path: Path) -> None:
    env = RecordReplay(atari.AtariEnv("breakout", core="native" if core == "ale" else "ale"), tmp_path / "a.a26r")
    inner: Any = env.unwrapped
    play(env, 30)
    early = inner.snapshot()
    for _ in range(20):
        env.step(1)
    late = inner.snapshot()
    inner.snapshot()
    for data in (early, late, early):
        inner.restore(data)
        for _ in range(15):
            env.step(3)
    env.close()
    replay = Replay.load(env.path)
    assert replay.frames_total == 4 * (30 + 20 + 3 * 15)
    result = replay.verify(core)
    assert result, result.divergence


def test_pokes_and_modes_are_kept(tmp_path: Path) -> None:
    env = RecordReplay(atari.AtariEnv("breakout"), tmp_path / "a.a26r")
    core: Any = env.unwrapped.core  # type: ignore[attr-defined]
    play(env, 20)
    core.set_ram(57, 1)
    assert core.ram()[57] == 1
    play(env, 20, seed=None)
    env.close()
    assert Replay.load(env.path).verify("ale")
    env = RecordReplay(atari.AtariEnv("breakout"), tmp_path / "b.a26r")
    env.unwrapped.core.set_mode(12)  # type: ignore[attr-defined]
    env.unwrapped.core.set_difficulty(1)  # type: ignore[attr-defined]
    play(env, 40)
    env.close()
    assert Replay.load(env.path).verify("plain")
    assert Replay.load(env.path).verify("ale")


def test_what_is_set_by_ale_is_recorded_or_refused(tmp_path: Path) -> None:
    env = RecordReplay(atari.AtariEnv("breakout"), tmp_path / "a.a26r")
    ale: Any = env.unwrapped.ale  # type: ignore[attr-defined]
    play(env, 20)
    ale.setMode(8)
    env.reset()
    play(env, 20, seed=None)
    env.reset(seed=3)
    play(env, 20, seed=None)
    ale.setInt("frame_skip", 2)
    with pytest.raises(RuntimeError, match="close the recorder first"):
        env.unwrapped.load_game()  # type: ignore[attr-defined]
    env.close()
    assert Replay.load(env.path).verify()
    assert Replay.load(env.path).verify("ale")


def test_from_the_middle_on_it_plays_on_its_own_core_only(tmp_path: Path) -> None:
    for core, sound in (("native", False), ("native", True), ("ale", False)):
        env: Any = atari.AtariEnv("breakout", core=core, sound_obs=sound)
        play(env, 30)
        recorded = RecordReplay(env, tmp_path / "a.a26r")
        for _ in range(30):
            recorded.step(3)
        recorded.close()
        replay = Replay.load(recorded.path)
        assert (replay.frames_total, replay.frames_rewound, replay.steps) == (120, 0, 30)
        assert replay.verify(core)
        assert any(frame.audio.any() for frame in replay.frames(sound=True, core=core)) == (core == "native")
        with pytest.raises(ValueError, match=r"cannot continue after frame 0 on core .* LOAD .*with core = "):
            replay.verify("ale" if core == "native" else "native")


def test_cloned_states_are_kept_on_the_native_core_and_refused_on_ale_py(tmp_path: Path) -> None:
    env: Any = RecordReplay(atari.AtariEnv("breakout"), tmp_path / "a.a26r")
    play(env, 20)
    state = env.unwrapped.clone_state()
    play(env, 20, seed=None)
    env.unwrapped.restore_state(state)
    for _ in range(20):
        env.step(2)
    env.close()
    assert Replay.load(env.path).verify()
    env = RecordReplay(atari.AtariEnv("breakout", core="ale"), tmp_path / "b.a26r")
    play(env, 20)
    ram = env.unwrapped.core.ram()
    state = env.unwrapped.clone_state()
    with pytest.raises(RuntimeError, match="cannot be recorded"):
        env.unwrapped.restore_state(state)
    assert np.array_equal(env.unwrapped.core.ram(), ram)
    env.close()
    assert Replay.load(env.path).verify("native")


def changed(path: Path, frame: int) -> Path:
    """The replay with another action at a frame."""
    content = read(path)
    writer = ReplayFileWriter(path.with_name("changed.a26r"), {name: content.header[name] for name in content.header})
    for chunk in content.plays:
        events, at = [], chunk.first
        for event in unpack(chunk.events):
            frames = event.numbers[1] if event.kind == Kind.ACT else 0
            if at <= frame < at + frames:
                action = 4 if event.numbers[0] == 3 else 3
                before, after = frame - at, at + frames - frame - 1
                pieces = [(event.numbers[0], before), (action, 1), (event.numbers[0], after)]
                events += [Event(Kind.ACT, piece, (), True) for piece in pieces if piece[1]]
            else:
                events.append(event)
            at += frames
        writer.play(chunk._replace(events=pack(events)))
    writer.end(content.end or {})
    return writer.path


def test_a_changed_action_is_found_near_its_frame(tmp_path: Path) -> None:
    path = record(tmp_path / "a.a26r", "pong", 200, repeat_action_probability=0.0, frameskip=1)
    assert Replay.load(path).verify()
    lateness = []
    for frame in range(70, 190, 13):
        for core in ("native", "ale") if frame % 3 == 0 else ("native",):
            result = Replay.load(changed(path, frame)).verify(core)
            assert not result
            assert result.divergence is not None
            assert result.divergence.since - 1 <= frame <= result.divergence.frame  # a game may look a frame later
            assert f"frame {result.divergence.frame} differs in RAM" in str(result.divergence)
            lateness.append(result.divergence.frame - frame)
    assert sorted(lateness)[len(lateness) // 2] <= 1
    assert max(lateness) < 10


def test_a_difference_that_only_the_full_hashes_report(tmp_path: Path) -> None:
    path = record(tmp_path / "a.a26r", "pong", 50)
    content = read(path)
    (chunk,) = content.plays
    writer = ReplayFileWriter(tmp_path / "b.a26r", content.header)
    writer.play(chunk._replace(full_hashes=(chunk.full_hashes[0], chunk.full_hashes[1] ^ 1, chunk.full_hashes[2])))
    writer.end(content.end or {})
    result = Replay.load(writer.path).verify()
    assert result.divergence == Divergence(119, 60, "RAM, screen, reward, lives or end")
    assert str(result.divergence).endswith("reward, lives or end; it may have begun at frame 60")
    writer = ReplayFileWriter(tmp_path / "c.a26r", content.header)
    writer.play(chunk)
    writer.end({**(content.end or {}), "check": 1})
    assert Replay.load(writer.path).verify().divergence == Divergence(199, 180, "how it ends")


def test_a_game_that_ends_elsewhere_is_a_difference(tmp_path: Path) -> None:
    path = record(tmp_path / "a.a26r", "pong", 40, max_num_frames_per_episode=100)
    for limit in (90, 110):
        replay = Replay.load(path)
        replay.header["options"]["max_num_frames_per_episode"] = limit
        divergence = replay.verify().divergence
        assert divergence is not None
        assert min(limit, 100) - 1 <= divergence.frame < 110


def test_frames_from_the_middle_are_those_of_the_whole(tmp_path: Path) -> None:
    env = RecordReplay(atari.AtariEnv("breakout"), tmp_path / "a.a26r")
    play(env, 300)
    data = env.unwrapped.snapshot()  # type: ignore[attr-defined]
    play(env, 400, seed=None)
    env.unwrapped.restore(data)  # type: ignore[attr-defined]
    for _ in range(300):
        env.step(0)
    env.close()
    replay = Replay.load(env.path)
    whole = list(replay.frames())
    for core in ("native", "plain"):
        for start in (0, 1, 960, 1500, 3990, replay.frames_total - 1, replay.frames_total):
            part = list(replay.frames(start, start + 30, core=core))
            assert [frame.index for frame in part] == list(range(start, min(start + 30, replay.frames_total)))
            for frame in part:
                expected = whole[frame.index]
                assert np.array_equal(frame.screen, expected.screen)
                assert (frame.episode, frame.action) == (expected.episode, expected.action)
    assert list(replay.frames(5, 5)) == []
    core = replay.seek(1234)
    assert np.array_equal(core.ram(), whole[1233].ram)
    core.act(1)
    assert np.array_equal(replay.seek(60, core="ale").ram(), whole[59].ram)
    with pytest.raises(ValueError, match="frame must be within 0"):
        replay.seek(replay.frames_total + 1)
    with pytest.raises(ValueError, match="core must be one of 'native', 'ale', 'plain', got 'stella'"):
        list(replay.frames(core="stella"))


def test_a_replay_becomes_a_video_with_sound(tmp_path: Path) -> None:
    replay = Replay.load(record(tmp_path / "a.a26r", "space_invaders", 60))
    counted: list[int] = []
    path = replay.render(tmp_path / "a.mp4", scale=1, start=20, stop=200, progress=counted.append)
    with av.open(str(path)) as container:
        video, audio = container.streams.video[0], container.streams.audio[0]
        assert (video.width, video.height, video.frames) == (320, 210, 180)
        assert video.average_rate == frame_rate(replay.game)
        heard = np.concatenate([frame.to_ndarray().ravel() for frame in container.decode(audio)])
    assert np.abs(heard).max() > 0.01
    assert sum(counted) == 180
    replay.render(tmp_path / "a.gif", stop=5)
    replay.render(tmp_path / "b.mp4", sound=False, stop=5)
    with av.open(str(tmp_path / "b.mp4")) as container:
        assert not container.streams.audio


@pytest.mark.parametrize(("start", "stop"), [(5, 5), (5, 3), (30, None)])
@pytest.mark.parametrize("name", ["a.gif", "a.png"])
def test_a_part_without_frames_is_refused_and_keeps_the_file(
    name: str, start: int, stop: int | None, tmp_path: Path
) -> None:
    replay = Replay.load(record(tmp_path / "a.a26r", "pong", 30))
    (tmp_path / name).write_bytes(b"mine")
    with pytest.raises(ValueError, match="there are no frames to render: the replay has"):
        replay.render(tmp_path / name, start=replay.frames_total if stop is None else start, stop=stop)
    assert (tmp_path / name).read_bytes() == b"mine"


@pytest.mark.parametrize("video_inside", [True, False])
def test_a_video_can_be_recorded_with_it(video_inside: bool, tmp_path: Path) -> None:
    env: Any = atari.make("breakout")
    if video_inside:
        env = RecordReplay(RecordVideo(env, tmp_path / "v"), tmp_path / "a.a26r")
    else:
        env = RecordVideo(RecordReplay(env, tmp_path / "a.a26r"), tmp_path / "v")
    play(env, 30)
    env.close()
    assert Replay.load(tmp_path / "a.a26r").verify("ale")
    assert len(list((tmp_path / "v").iterdir())) == 1


def test_half_an_hour_of_random_play_fits_in_a_hundred_kilobytes(tmp_path: Path) -> None:
    steps = 2700  # a tenth of it
    size = record(tmp_path / "a.a26r", "seaquest", steps, obs_type="ram").stat().st_size
    assert 10 * size < 100_000


class AtariVecEnv:
    """The attribute by which recorders know the class of `atari.sb3`."""

    vector = atari.AtariVectorEnv("pong", 1)


def test_wrong_uses(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match=r"no AtariVecEnv of Stable-Baselines3; use atari\.sb3\.RecordReplay"):
        RecordReplay(AtariVecEnv(), tmp_path / "a.a26r")  # type: ignore[call-overload]
    with pytest.raises(ValueError, match="must end in"):
        RecordReplay(atari.AtariEnv("pong"), tmp_path / "a.mp4")
    env = RecordReplay(atari.AtariEnv("pong"), tmp_path / "a.a26r")
    with pytest.raises(ValueError, match="recorded already"):
        RecordReplay(env, tmp_path / "b.a26r")
    env.reset()
    with pytest.raises(ValueError, match="is not within 0"):
        env.step(99)
    env.step(1)
    env.close()
    assert Replay.load(env.path).frames_total == 4
    assert not (tmp_path / "b.a26r").exists()


def test_another_rom_is_refused(tmp_path: Path) -> None:
    path = record(tmp_path / "a.a26r", "pong", 3)
    content = read(path)
    ReplayFileWriter(tmp_path / "b.a26r", {**content.header, "rom": "0" * 32}).end({})
    with pytest.raises(ValueError, match=f"recorded with a ROM of MD5 {'0' * 32}, but the ROM of pong here"):
        Replay.load(tmp_path / "b.a26r")
    ReplayFileWriter(tmp_path / "c.a26r", {"game": 3}).end({})
    with pytest.raises(ValueError, match="its header has no game"):
        Replay.load(tmp_path / "c.a26r")
    without = {name: fact for name, fact in content.header.items() if name != "task"}
    ReplayFileWriter(tmp_path / "d.a26r", without).end({})
    with pytest.raises(ValueError, match="its header has no task"):
        Replay.load(tmp_path / "d.a26r")
    with pytest.raises(FileNotFoundError):
        Replay.load(tmp_path / "none.a26r")


def test_a_whole_file_gives_no_warning(tmp_path: Path) -> None:
    path = record(tmp_path / "a.a26r", "pong", 3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert Replay.load(path).complete
    os.truncate(path, path.stat().st_size - 1)
    with pytest.warns(UserWarning, match="was cut"):
        assert not Replay.load(path).complete


def test_without_minari_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "minari", None)
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match=r"pip install 'minari>=0.5.3'"):
        to_minari(record(tmp_path / "a.a26r", steps=3), "a-v0")


def test_a_game_of_your_own(tmp_path: Path) -> None:
    folder = Path(__file__).parents[3] / "examples" / "catch"
    path = record(tmp_path / "a.a26r", str(folder / "catch.toml"), 60, rom=folder / "catch.bin")
    replay = Replay.load(path, game=folder / "catch.toml", rom=folder / "catch.bin")
    assert replay.verify("plain")
    assert next(replay.frames(100)).screen.shape == (210, 160, 3)
    with pytest.raises(ValueError, match="there is no game 'catch'"):
        Replay.load(path)
    with pytest.raises(ValueError, match="ale-py has only its own games"):
        replay.verify("ale")


def test_it_knows_its_seeds(tmp_path: Path) -> None:
    with RecordReplay(atari.AtariEnv("pong"), tmp_path / "a.a26r") as env:
        words = [int(env.reset(seed=seed)[1]["seeds"][1]) for seed in (3, 4)]
    assert list(Replay.load(env.path).seeds) == words


def test_the_task_is_kept_with_its_wrappers(tmp_path: Path) -> None:
    task = atari.Task.of("breakout", preset="dqn2015", frameskip=3, interventions=["strong_ball"])
    with RecordReplay(atari.make(task), tmp_path / "a.a26r") as env:
        env.reset(seed=0)
        for step in range(20):
            env.step(step % 4)
    replay = Replay.load(tmp_path / "a.a26r")
    assert replay.task == task
    assert replay.options["frameskip"] == 1
    assert replay.verify()


def test_settings_of_ale_before_the_recording_are_in_it(tmp_path: Path) -> None:
    env = atari.AtariEnv("breakout", repeat_action_probability=0.5)
    env.ale.setFloat("repeat_action_probability", 0.0)
    env.load_game()
    env.ale.setMode(4)
    assert env.task == atari.AtariEnv("breakout", repeat_action_probability=0.0, mode=4).task
    env.reset(seed=0)
    with RecordReplay(env, tmp_path / "a.a26r") as recorder:
        play(recorder, 30, seed=1)
    replay = Replay.load(tmp_path / "a.a26r")
    assert replay.task.repeat_action_probability == replay.options["repeat_action_probability"] == 0.0
    assert replay.task.mode == 0  # a reset with a seed loads the game, as in ale-py
    assert replay.verify()
