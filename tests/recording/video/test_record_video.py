"""`RecordVideo`: every frame is recorded, results do not change, and file names are Gymnasium's."""

import copy
import errno
import gc
import inspect
import pickle
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import av
import gymnasium
import gymnasium.utils
import numpy as np
import pytest
from env_tools import data_equivalence, needs_gymnasium_1
from film import always, files
from replay_tools import full_disk
from video_reader import NTSC, Screen, sound, video_frames

import atari
from atari.lab import RamLabels, Watch
from atari.recording import RecordReplay, RecordVideo, VideoWriter
from atari.recording.video import writer
from atari.recording.video.audio import to_16_bit
from atari.recording.video.images import line_height
from atari.recording.video.overlay import CURVE_ROWS, Overlay
from atari.wrappers import DqnPreprocessing, EpisodicLife

Env = gymnasium.Env[Any, Any]


def record_video(env: Env, folder: Path, **options: Any) -> RecordVideo:
    return RecordVideo(env, folder / "videos", **{"episode_trigger": always, **options})


def play(env: Env, steps: int, seed: int = 0) -> list[Any]:
    """The results of an environment over several episodes."""
    results: list[Any] = [env.reset(seed=seed)]
    env.action_space.seed(seed)
    for _ in range(steps):
        results.append(env.step(env.action_space.sample()))
        if results[-1][2] or results[-1][3]:
            results.append(env.reset())
    return results


# What the environment does.


@pytest.mark.parametrize("make", [lambda: atari.make("pong"), lambda: atari.AtariVectorEnv("pong", 2)])
@pytest.mark.parametrize("kind", [RecordVideo, RecordReplay, RamLabels, Watch])
def test_an_argument_that_a_recorder_or_a_wrapper_lacks_is_named(make: Any, kind: Any) -> None:
    with pytest.raises(TypeError, match=f"^{kind.__name__} has no option 'bset'; "):
        kind(make(), "ball_x", bset=True)


@pytest.mark.parametrize("core", ["native", "ale"])
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"frameskip": (2, 5), "sound_obs": True},
        {"frameskip": 1, "obs_type": "ram", "repeat_action_probability": 0.0},
        {"continuous": True, "obs_type": "grayscale", "max_num_frames_per_episode": 90},
        {"preset": "dqn2015"},
        {"preset": "envpool"},
    ],
)
def test_recording_changes_nothing(tmp_path: Path, videos: Any, core: str, options: dict[str, Any]) -> None:
    plain = play(atari.make("breakout", core=core, **options), 60)
    env = record_video(atari.make("breakout", core=core, **options), tmp_path)
    assert data_equivalence(play(env, 60), plain)
    env.close()
    assert len(videos["rl-video-episode-0.mp4"].images) > 60


def test_the_environment_is_left_as_it_was_when_it_is_closed(tmp_path: Path) -> None:
    env = record_video(atari.make("pong"), tmp_path)
    play(env, 3)
    assert env.recording
    env.close()
    assert not env.recording
    with pytest.raises(RuntimeError, match="closed"):
        env.unwrapped.step(0)


def test_a_copy_and_a_pickle_go_on_and_record_from_their_next_episode_on(tmp_path: Path, videos: Any) -> None:
    env = record_video(atari.make("breakout", frameskip=4), tmp_path)
    play(env, 5)
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert not other.recording
        assert other.episode_id == 0
        assert data_equivalence(other.step(1), copy.deepcopy(env).step(1))
        other.reset()
        assert other.recording
        other.stop_recording()
    assert env.recording
    env.close()
    assert files(tmp_path) == ["rl-video-episode-0.mp4", "rl-video-episode-1.mp4"]


def test_the_spec_makes_it_again(tmp_path: Path) -> None:
    env = RecordVideo(gymnasium.make("ALE/Breakout-v5"), tmp_path / "videos", format="gif", scale=1)
    env.close()
    again = gymnasium.make(env.spec)
    again.reset()
    again.close()
    assert files(tmp_path) == ["rl-video-episode-0.gif"]


def test_snapshots_fit_environments_that_make_sound_too(tmp_path: Path, videos: Any) -> None:
    env, plain = record_video(atari.make("breakout"), tmp_path), atari.make("breakout")
    play(env, 5)
    saved = env.unwrapped.snapshot()  # type: ignore[attr-defined]
    plain.reset()
    with pytest.raises(ValueError, match="taken with sound = True"):
        plain.unwrapped.restore(saved)  # type: ignore[attr-defined]
    plain.unwrapped.driver.make_sound()  # type: ignore[attr-defined]
    plain.unwrapped.restore(saved)  # type: ignore[attr-defined]
    assert data_equivalence(plain.step(2), env.step(2))
    env.close()


# What is in the videos.


@pytest.mark.parametrize("core", ["native", "ale"])
@pytest.mark.parametrize("frame_skip", [4, 7])
def test_every_emulated_frame_is_in_it_with_its_sound(tmp_path: Path, core: str, frame_skip: int) -> None:
    env = record_video(atari.make("seaquest", frameskip=frame_skip, core=core), tmp_path, format="mkv", scale=1)
    reference = atari.cores.CORES[core]("seaquest", sound=True)
    seed = int(env.reset(seed=2)[1]["seeds"][1])
    reference.seed(seed)
    reference.reset()
    screens, samples = [reference.screen_rgb()], [np.zeros(512, np.int16)]
    for action in [1, 3, 9, 1, 4, 0, 2, 5]:
        env.step(action)
        for _ in range(frame_skip):
            reference.act(int(env.unwrapped.driver.actions[action]))  # type: ignore[attr-defined]
            screens.append(reference.screen_rgb())
            samples.append(to_16_bit(reference.audio()))
    env.close()
    assert np.abs(samples).max() > 0
    path = tmp_path / "videos" / "rl-video-episode-0.mkv"
    expected = [screen.repeat(2, axis=1) for screen in screens]
    assert len(expected) == 1 + 8 * frame_skip
    assert all(np.array_equal(a, b) for a, b in zip(video_frames(path), expected, strict=True))
    assert np.array_equal(sound(path)[0], np.concatenate(samples))


class Counter:
    """An observer that counts its calls."""

    def __init__(self) -> None:
        self.frames = 0

    def game_begun(self) -> None:
        self.frames = 1

    def frame_played(self, action: int, reward: int) -> None:
        self.frames += 1


@pytest.mark.parametrize("preset", [None, *atari.PRESETS])
def test_under_every_preset_the_video_has_the_frames_that_were_played(tmp_path: Path, preset: str | None) -> None:
    env = record_video(atari.make("pong", preset=preset), tmp_path, scale=1)
    counter = Counter()
    env.unwrapped.driver.observers.append(counter)  # type: ignore[attr-defined]
    env.reset(seed=1)
    at_reset = counter.frames
    for action in (2, 3) * 10:
        env.step(action)
    assert counter.frames - at_reset == 80
    assert (at_reset > 1) == (preset in ("dqn2015", "baselines", "gymnasium", "envpool", "ale_vector"))
    env.close()
    path = tmp_path / "videos" / "rl-video-episode-0.mp4"
    with av.open(str(path)) as container:
        assert [stream.codec_context.name for stream in container.streams] == ["h264", "aac"]
        video = container.streams.video[0]
        assert video.average_rate == NTSC
        assert video.frames == counter.frames
        assert video.duration * video.time_base == counter.frames / NTSC
        assert container.duration / av.time_base == pytest.approx(float(counter.frames / NTSC), abs=1 / 60)


def test_it_records_inside_other_wrappers_too(tmp_path: Path, videos: Any) -> None:
    env = DqnPreprocessing(record_video(atari.AtariEnv("breakout", frameskip=1), tmp_path))
    plain = DqnPreprocessing(atari.AtariEnv("breakout", frameskip=1))
    assert data_equivalence(play(env, 20), play(plain, 20))
    env.close()
    assert env.get_wrapper_attr("step_id") == 79


def test_nothing_is_recorded_after_the_end_of_a_game(tmp_path: Path, videos: Any) -> None:
    env = record_video(atari.make("breakout", max_num_frames_per_episode=9, frameskip=4), tmp_path)
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="after the episode had ended"):
        truncations = [env.step(0)[3] for _ in range(4)]
    assert truncations == [False, False, True, True]
    env.close()
    assert len(videos["rl-video-episode-0.mp4"].images) == 1 + 9


def test_after_a_lost_life_the_video_begins_with_the_screen_that_there_is(tmp_path: Path, videos: Any) -> None:
    env = record_video(EpisodicLife(atari.AtariEnv("breakout", frameskip=1), on_reset="continue"), tmp_path)
    env.reset(seed=0)
    env.unwrapped.core.set_ram(0x39, 1)  # type: ignore[attr-defined]
    terminated = False
    while not terminated:
        terminated = env.step(1)[2]
    screen: Screen = env.unwrapped.core.screen_rgb()  # type: ignore[attr-defined]
    env.reset()
    env.step(0)
    env.close()
    second = videos["rl-video-episode-1.mp4"].images
    assert len(second) == 2
    assert np.array_equal(second[0], screen)


@pytest.mark.parametrize("overlay", [("score",), ("action", "score"), ("ram",), ("score", "action", "ram")])
def test_the_overlay_is_below_the_frame_and_changes(tmp_path: Path, videos: Any, overlay: tuple[str, ...]) -> None:
    env = record_video(atari.make("breakout", frameskip=4), tmp_path, overlay=overlay, format="mkv", scale=1)
    env.reset(seed=1)
    rewards = [env.step(action)[1] for action in [1, 0, 2, 2, 3, 3] * 8]
    env.close()
    frames = videos["rl-video-episode-0.mkv"].images
    lines = (overlay != ("ram",)) + 8 * ("ram" in overlay)
    assert frames[0].shape == (210 + line_height(1) * lines, 320, 3)
    captions = [image[210:].tobytes() for image in frames]
    different = len(set(captions))
    if overlay == ("score",):
        assert different == 1 + np.count_nonzero(rewards)
    else:
        assert different > (4 if "ram" not in overlay else 100)


def test_captions_say_score_action_and_ram(tmp_path: Path, videos: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    captions: list[str] = []
    monkeypatch.setattr(writer, "add_caption", lambda image, text, *_: captions.append(text) or image)
    env = record_video(atari.make("breakout", frameskip=2), tmp_path, overlay=("score", "action", "ram"))
    env.reset(seed=1)
    env.step(1)
    core = env.unwrapped.core  # type: ignore[attr-defined]
    assert [caption.splitlines()[0] for caption in captions] == ["score 0   action -", *["score 0   action FIRE"] * 2]
    rows = captions[-1].splitlines()[1:]
    assert [row[:5] for row in rows] == ["80:  ", "90:  ", "A0:  ", "B0:  ", "C0:  ", "D0:  ", "E0:  ", "F0:  "]
    assert bytes.fromhex("".join(row[5:] for row in rows)) == core.ram().tobytes()


@pytest.mark.parametrize(("format", "streams"), [("mp4", 2), ("mkv", 2), ("webm", 2), ("gif", 1)])
def test_every_format(tmp_path: Path, format: str, streams: int) -> None:
    env = record_video(atari.make("pong", frameskip=4), tmp_path, format=format, scale=1)
    play(env, 5)
    env.close()
    with av.open(str(tmp_path / "videos" / f"rl-video-episode-0.{format}")) as container:
        assert len(container.streams) == streams


def test_a_png_sequence_is_a_folder(tmp_path: Path) -> None:
    env = record_video(atari.make("pong", frameskip=2), tmp_path, format="png", scale=1, name_prefix="100%")
    play(env, 2)
    env.close()
    assert files(tmp_path) == [f"100%-episode-0/{i:06}.png" for i in range(5)]


def test_without_sound_the_emulator_stays_the_same(tmp_path: Path) -> None:
    env = atari.make("pong")
    core = env.unwrapped.core  # type: ignore[attr-defined]
    silent = record_video(env, tmp_path, sound=False)
    assert env.unwrapped.core is core  # type: ignore[attr-defined]
    play(silent, 2)
    silent.close()
    with av.open(str(tmp_path / "videos" / "rl-video-episode-0.mp4")) as container:
        assert not container.streams.audio


def test_another_rate_is_slow_motion(tmp_path: Path) -> None:
    env = record_video(atari.make("pong", frameskip=4), tmp_path, fps=30)
    play(env, 5)
    env.close()
    with av.open(str(tmp_path / "videos" / "rl-video-episode-0.mp4")) as container:
        assert container.streams.video[0].average_rate == 30
        assert container.duration / av.time_base == pytest.approx(21 / 30, abs=0.022)


# When it records, and under which names.


@needs_gymnasium_1
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"episode_trigger": lambda episode: episode % 2 == 1},
        {"step_trigger": lambda step: step % 50 == 20},
        {"step_trigger": lambda step: step in (0, 30), "video_length": 12, "name_prefix": "x"},
        {"episode_trigger": lambda episode: episode == 1, "video_length": 100},
        {"episode_trigger": lambda episode: episode < 3, "step_trigger": lambda step: step == 50, "video_length": 1},
        {"episode_trigger": lambda episode: False},
    ],
)
def test_names_and_lengths_are_gymnasiums(
    tmp_path: Path, moviepy: dict[str, int], videos: Any, options: dict[str, Any]
) -> None:
    task = {"frameskip": 1, "max_num_frames_per_episode": 40, "render_mode": "rgb_array"}
    theirs = gymnasium.wrappers.RecordVideo(atari.make("breakout", **task), str(tmp_path / "theirs"), **options)
    play(theirs, 200)
    theirs.close()
    ours = RecordVideo(atari.make("breakout", **task), tmp_path / "videos", **options, sound=False)
    play(ours, 200)
    ours.close()
    assert {name: len(video.images) for name, video in videos.items()} == moviepy
    assert files(tmp_path) == sorted(moviepy)
    assert (ours.episode_id, ours.step_id) == (theirs.episode_id, theirs.step_id)


@needs_gymnasium_1
def test_its_arguments_are_gymnasiums(tmp_path: Path) -> None:
    theirs = list(inspect.signature(gymnasium.wrappers.RecordVideo.__init__).parameters.values())
    ours = list(inspect.signature(RecordVideo.__init__).parameters.values())
    assert [parameter.name for parameter in ours[: len(theirs)]] == [parameter.name for parameter in theirs]
    assert len(ours) - 5 >= len(theirs)  # older releases have fewer
    for our, their in zip(ours, theirs, strict=False):
        if our.name != "gc_trigger":
            assert (our.default, our.kind) == (their.default, their.kind)


def test_recordings_can_be_started_and_stopped_by_hand(tmp_path: Path, videos: Any) -> None:
    env = record_video(atari.make("pong"), tmp_path, episode_trigger=lambda episode: False)
    play(env, 2)
    env.start_recording("by hand")
    assert env.recording
    env.step(0)
    env.stop_recording()
    env.stop_recording()
    env.close()
    assert files(tmp_path) == ["by hand.mp4"]
    assert len(videos["by hand.mp4"].images) == 4


def test_a_video_is_completed_without_close(tmp_path: Path) -> None:
    env = record_video(atari.make("pong", frameskip=1), tmp_path, format="mkv", scale=1)
    play(env, 9)
    del env
    gc.collect()
    assert len(video_frames(tmp_path / "videos" / "rl-video-episode-0.mkv")) == 10


def test_videos_that_will_be_replaced_are_warned_of(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of a folder without videos
        for _ in range(2):
            env = record_video(atari.make("pong"), tmp_path)
    play(env, 3)
    env.close()
    with pytest.warns(UserWarning, match="will be replaced"):
        record_video(atari.make("pong"), tmp_path)


# Errors.


@pytest.mark.parametrize(
    ("options", "error", "text"),
    [
        ({"format": "avi"}, ValueError, "format must be one of 'mp4', 'mkv', 'webm', 'gif', 'png', got 'avi'"),
        ({"overlay": "score"}, ValueError, "overlay is a tuple of some of 'score', .*'curve', got 'score'"),
        ({"keep": "worst"}, ValueError, "keep must be one of"),
        ({"overlay": ("frames",)}, ValueError, "overlay is a tuple of some"),
        ({"scale": 0}, ValueError, "scale must be within 1..16"),
        ({"fps": "60"}, TypeError, "fps is a number"),
    ],
)
def test_wrong_arguments_are_refused_before_a_folder_is_made(
    tmp_path: Path, options: dict[str, Any], error: type[Exception], text: str
) -> None:
    env = atari.make("pong")
    core = env.unwrapped.core  # type: ignore[attr-defined]
    with pytest.raises(error, match=text):
        record_video(env, tmp_path, **options)
    assert not list(tmp_path.iterdir())
    assert env.unwrapped.core is core  # type: ignore[attr-defined]
    assert not env.unwrapped.driver.observers  # type: ignore[attr-defined]


def test_without_pyav_the_error_comes_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match=r"pip install 'av>=14'"):
        VideoWriter(tmp_path / "a.mp4", (210, 160), NTSC)
    assert not list(tmp_path.iterdir())
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match=r"pip install 'av>=14'"):
        record_video(atari.make("pong"), tmp_path)
    record_video(atari.make("pong"), tmp_path, format="png").close()


def test_a_folder_that_cannot_be_made_or_written_to_is_an_error_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "videos").touch()
    with pytest.raises(OSError, match="videos"):
        record_video(atari.make("pong"), tmp_path)
    monkeypatch.setattr("os.access", lambda path, mode: False)  # permissions do not bind root
    with pytest.raises(PermissionError, match=r"videos cannot be written into .*; choose another video_folder"):
        RecordVideo(atari.make("pong"), tmp_path)


@pytest.mark.parametrize("trigger", ["episode_trigger", "step_trigger"])
def test_a_video_that_cannot_be_begun_is_an_error_and_the_game_goes_on(tmp_path: Path, trigger: str) -> None:
    plain = atari.make("breakout")
    env = RecordVideo(atari.make("breakout"), tmp_path / "videos", **{trigger: lambda number: number == 0})
    name = f"rl-video-{trigger.removesuffix('_trigger')}-0.mp4"
    (tmp_path / "videos" / name).mkdir()
    call: Callable[[], Any] = lambda: env.reset(seed=0)  # noqa: E731
    if trigger == "step_trigger":
        env.reset(seed=0)
        call = lambda: env.step(1)  # noqa: E731
    with pytest.raises(IsADirectoryError, match=name):
        call()
    result = call()
    expected = plain.reset(seed=0)
    if trigger == "step_trigger":
        expected = plain.step(1)  # type: ignore[assignment]
    assert data_equivalence(result, expected)
    assert not env.recording
    env.close()


def test_a_full_disk_ends_the_video_and_the_game_continues(tmp_path: Path) -> None:
    plain, env = atari.make("breakout"), record_video(atari.make("breakout"), tmp_path, format="mkv")
    expected, results, errors = [plain.reset(seed=1)], [env.reset(seed=1)], []
    with full_disk(20_000):
        for i in range(40):
            expected.append(plain.step(i % 4))
            try:
                results.append(env.step(i % 4))
            except OSError as error:
                errors.append((error.errno, error.strerror, error.filename))
                results.append(env.step(i % 4))
    assert data_equivalence(results, expected)
    assert not env.recording
    text = "the recording has ended after 17 frames: File too large; incomplete, after 17 frames"
    assert errors == [(errno.EFBIG, text, str(tmp_path / "videos" / "rl-video-episode-0.mkv"))]
    env.reset()
    env.step(0)
    env.close()
    assert len(video_frames(tmp_path / "videos" / "rl-video-episode-1.mkv")) == 5


# The best video, and the curve.


def test_only_the_best_video_is_kept(tmp_path: Path, videos: Any) -> None:
    options: dict[str, Any] = {"max_num_frames_per_episode": 1200, "frameskip": 4, "repeat_action_probability": 0.0}
    env = record_video(atari.make("space_invaders", **options), tmp_path, keep="best")
    env.action_space.seed(1)
    returns: list[float] = []
    for episode in range(4):
        env.reset(seed=episode)
        returns.append(0.0)
        over = False
        while not over:
            _, reward, terminated, truncated, _ = env.step(env.action_space.sample())
            returns[-1] += float(reward)
            over = terminated or truncated
        env.stop_recording()
        videos.clear()
        assert files(tmp_path) == [f"rl-video-episode-{returns.index(max(returns))}.mp4"]
    env.close()
    assert len(set(returns)) > 1
    assert 0 < returns.index(max(returns)) < 3  # it replaced one, and was better than one after it


def test_the_curve_is_the_score_from_the_first_frame_to_this_one() -> None:
    overlay = Overlay(("curve",), atari.games["pong"])
    screen = np.full((210, 160, 3), 7, np.uint8)
    assert overlay.size((210, 160)) == (210 + CURVE_ROWS, 160)
    for reward in [0] * 50 + [10] + [0] * 49:
        overlay.add(reward)
    image = overlay.draw(screen)
    assert image.shape == (210 + CURVE_ROWS, 160, 3)
    assert (image[:210] == 7).all()
    rows = image[210:, :, 0].argmax(0)
    assert (rows[2:75] == CURVE_ROWS - 2).all()
    assert (rows[85:158] == 1).all()
    overlay.begin_game()
    assert (overlay.draw(screen)[210:, 1:-1, 0].argmax(0) == CURVE_ROWS - 2).all()


def test_the_curve_goes_below_zero() -> None:
    overlay = Overlay(("curve",), atari.games["pong"])
    for reward in (1, -3):
        overlay.add(reward)
    strip = overlay.draw(np.zeros((10, 160, 3), np.uint8))[10:, :, 0]
    zero = round((CURVE_ROWS - 3) / 3) + 1
    assert strip[:, 1].argmax() == zero
    assert (strip[CURVE_ROWS - 2, 158], strip[zero, 80]) == (236, 74)
