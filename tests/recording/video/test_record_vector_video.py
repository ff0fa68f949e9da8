"""`RecordVideo` of a vector: shadow cores equal their environments, and videos have every frame."""

import re
import warnings
from pathlib import Path
from typing import Any

import av
import gymnasium
import numpy as np
import pytest
from env_tools import data_equivalence
from gymnasium.vector import SyncVectorEnv
from video_reader import NTSC, sound, video_frames

import atari
from atari import AtariVectorEnv
from atari.base.gymnasium_versions import AutoresetMode
from atari.env.rendering import tile
from atari.recording import RecordReplay, RecordVideo
from atari.recording.video.audio import to_16_bit

OPTIONS: list[dict[str, Any]] = [
    {},
    {"repeat_action_probability": 0.25, "frameskip": (2, 6), "full_action_space": True},
    {"episodic_life": True, "noop_max": 5},
    {"life_loss_info": True, "max_num_frames_per_episode": 70},
    {"continuous": True, "repeat_action_probability": 0.5},
    {"preset": "dqn2015"},
    {"preset": "baselines"},
    {"preset": "envpool", "episodic_life": True},
]


def record_video(envs: Any, folder: Path, **options: Any) -> Any:
    options = {"episode_trigger": lambda episode: True, "format": "mkv", "scale": 1, **options}
    return RecordVideo(envs, folder / "videos", **options)


def play(envs: Any, steps: int) -> list[Any]:
    """Return copies of the results; reset the environments that are done if autoreset is disabled."""
    envs.action_space.seed(1)
    results = [envs.reset(seed=3)]
    for _ in range(steps):
        results.append(envs.step(envs.action_space.sample()))
        done = results[-1][2] | results[-1][3]
        if envs.metadata["autoreset_mode"] == AutoresetMode.DISABLED and done.any():
            results.append(envs.reset(options={"reset_mask": done}))
        results[-1] = (results[-1][0].copy(), *results[-1][1:])
        for info in (results[-1][-1], results[-1][-1].get("final_info", {})):
            info.get("episode", {}).pop("t", None)  # seconds
    return results[1:]


@pytest.mark.parametrize(
    ("mode", "options"),
    [
        *[(AutoresetMode.NEXT_STEP, options) for options in OPTIONS],
        *[(AutoresetMode.SAME_STEP, options) for options in OPTIONS],
        *[(AutoresetMode.DISABLED, options) for options in OPTIONS[2:4]],
    ],
)
def test_recording_changes_nothing_and_shadows_only_jump_at_resets(
    tmp_path: Path, videos: Any, monkeypatch: pytest.MonkeyPatch, mode: AutoresetMode, options: dict[str, Any]
) -> None:
    plain = play(AtariVectorEnv("breakout", 3, autoreset_mode=mode, **options), 60)
    envs = record_video(AtariVectorEnv("breakout", 3, autoreset_mode=mode, **options), tmp_path, video_length=999)
    jumps: list[int] = []
    for shadow in envs._shadows:
        copy_to = shadow._lane.copy_to
        jump = lambda core, index=shadow.index, copy_to=copy_to: (jumps.append(index), copy_to(core))  # noqa: E731
        monkeypatch.setattr(shadow._lane, "copy_to", jump)
    assert data_equivalence(play(envs, 60), plain)
    ends = sum(int((result[2] | result[3]).sum()) for result in plain if len(result) == 5)
    assert 3 <= len(jumps) <= 3 + ends
    assert_shadows_equal(envs)
    envs.close()


def assert_shadows_equal(envs: Any) -> None:
    for shadow in envs._shadows:
        assert np.array_equal(shadow.core.ram(), shadow._lane.ram())
        assert np.array_equal(shadow.screen, shadow._lane.screen_rgb())


@pytest.mark.parametrize("preset", [None, "dqn2015"])
def test_one_environments_video_is_that_of_its_core(tmp_path: Path, preset: str | None) -> None:
    options = {"preset": preset} if preset else {"noop_max": 1, "use_fire_reset": False}
    envs = record_video(AtariVectorEnv("seaquest", 3, **options), tmp_path, record_first_only=True, index=1)
    envs.reset(seed=5)
    core = atari.cores.NativeCore("seaquest", repeat_action_probability=0.0, sound=True)
    envs.unwrapped.lanes[1].copy_to(core)
    screens, samples = [core.screen_rgb()], [np.zeros(512, np.int16)]
    for action in [1, 3, 4, 1, 5, 2] * 3:
        envs.step(np.array([0, action, 0]))
        for _ in range(4):
            core.act(int(core.game.minimal_actions[action]))
            screens.append(core.screen_rgb())
            samples.append(to_16_bit(core.audio()))
    assert np.array_equal(core.ram(), envs.unwrapped.lanes[1].ram())
    envs.close()
    path = tmp_path / "videos" / "rl-video-episode-0.mkv"
    read = video_frames(path)
    assert len(read) == len(screens) == 73
    assert all(np.array_equal(a, b.repeat(2, axis=1)) for a, b in zip(read, screens, strict=True))
    assert np.array_equal(sound(path)[0], np.concatenate(samples))
    assert np.abs(samples).max() > 0


def test_a_mosaic_shows_all_environments_in_step(tmp_path: Path) -> None:
    vector = AtariVectorEnv(["breakout", "air_raid", "pong"], render_mode="rgb_array")
    envs = record_video(vector, tmp_path)
    envs.reset(seed=0)
    shown = [tile(vector.render() or (), 2)]
    for _ in range(10):
        envs.step(np.full(3, 1))
        shown.append(tile(vector.render() or (), 2))
    envs.close()
    read = video_frames(tmp_path / "videos" / "rl-video-episode-0.mkv")
    assert len(read) == 1 + 40
    assert read[0].shape == (500, 640, 3)
    for i, mosaic in enumerate(shown):
        assert np.array_equal(read[4 * i], mosaic.repeat(2, axis=1))
    with av.open(str(tmp_path / "videos" / "rl-video-episode-0.mkv")) as container:
        assert container.streams.video[0].average_rate == pytest.approx(float(NTSC), abs=0.001)
        assert container.streams.audio[0].codec_context.name == "flac"


@pytest.mark.parametrize("preset", [None, "dqn2015"])
@pytest.mark.parametrize("first_only", [False, True])
def test_over_episodes_each_step_ends_with_what_the_environments_show(
    tmp_path: Path, videos: Any, preset: str | None, first_only: bool
) -> None:
    limit = {"preset": preset, "episodic_life": True} if preset else {"max_num_frames_per_episode": 30}
    vector = AtariVectorEnv("breakout", 3, render_mode="rgb_array", **limit)
    first = {"episode_trigger": lambda episode: episode == 0, "video_length": 1000}
    envs = record_video(vector, tmp_path, record_first_only=first_only, **first)
    envs.reset(seed=0)
    expected = {0: vector.render() or ()}
    ends = 0
    for i in range(60):
        _, _, terminations, truncations, _ = envs.step(np.array([1, i % 4, 2]))
        ends += int((terminations | truncations)[0])
        expected[envs._recorder.frames - 1] = vector.render() or ()
    assert ends
    envs.close()
    written = videos["rl-video-episode-0.mkv"].images
    assert len(written) == max(expected) + 1
    for i, screens in expected.items():
        image = screens[0] if first_only else tile(screens, envs._columns)
        assert np.array_equal(written[i], image.repeat(2, axis=1))


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_a_new_episodes_video_begins_with_its_first_screen(tmp_path: Path, videos: Any, mode: AutoresetMode) -> None:
    vector = AtariVectorEnv("seaquest", 2, max_num_frames_per_episode=30, autoreset_mode=mode, render_mode="rgb_array")
    envs = record_video(vector, tmp_path, record_first_only=True)
    envs.reset(seed=0)
    while envs.episode_id == 0:
        envs.step(np.array([3, 4]))
    (first, _) = vector.render() or ()
    envs.step(np.array([3, 4]))
    envs.close()
    second = videos["rl-video-episode-1.mkv"].images
    assert len(second) == 5
    assert np.array_equal(second[0], first.repeat(2, axis=1))
    assert len(videos["rl-video-episode-0.mkv"].images) == 1 + 30


def test_ended_environments_that_wait_for_a_reset_are_not_recorded(tmp_path: Path, videos: Any) -> None:
    vector = AtariVectorEnv("pong", 1, max_num_frames_per_episode=6, autoreset_mode=AutoresetMode.DISABLED)
    envs = record_video(vector, tmp_path)
    envs.reset(seed=0)
    for _ in range(5):
        envs.step(np.array([2]))
    envs.close()
    assert len(videos["rl-video-episode-0.mkv"].images) == 1 + 6


@pytest.mark.parametrize(
    ("count", "ratio", "shape"),
    [
        (1, (1, 1), (210, 320)),
        (4, (1, 1), (420, 640)),
        (4, (1, 4), (840, 320)),
        (4, (16, 1), (210, 1280)),
        (5, (16, 9), (420, 960)),
    ],
)
def test_the_mosaic_has_about_the_wanted_sides(
    tmp_path: Path, videos: Any, count: int, ratio: tuple[int, int], shape: tuple[int, int]
) -> None:
    envs = record_video(AtariVectorEnv("pong", count), tmp_path, video_aspect_ratio=ratio)
    envs.reset()
    envs.close()
    (image,) = videos["rl-video-episode-0.mkv"].images
    assert image.shape == (*shape, 3)


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"episode_trigger": lambda episode: episode % 3 == 1},
        {"step_trigger": lambda step: step in (5, 40), "video_length": 7},
        {"step_trigger": lambda step: step == 9},
    ],
)
def test_names_and_counts_are_gymnasiums(
    tmp_path: Path, moviepy: dict[str, int], videos: Any, mode: AutoresetMode, options: dict[str, Any]
) -> None:
    task = {"autoreset_mode": mode, "max_num_frames_per_episode": 60, "render_mode": "rgb_array"}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Gymnasium's lacks an episode's last frame in SAME_STEP
        vector = AtariVectorEnv("breakout", 2, **task)
        theirs = gymnasium.wrappers.vector.RecordVideo(vector, str(tmp_path / "theirs"), **options)
    play(theirs, 90)
    theirs.close()
    ours = RecordVideo(AtariVectorEnv("breakout", 2, **task), tmp_path / "videos", scale=1, **options)
    play(ours, 90)
    ours.close()
    assert sorted(path.name for path in (tmp_path / "videos").iterdir()) == sorted(videos) == sorted(moviepy)
    assert (ours.episode_id, ours.step_id) == (theirs.episode_id, theirs.step_id)


def test_the_overlay_is_of_the_chosen_environment(tmp_path: Path, videos: Any) -> None:
    envs = record_video(AtariVectorEnv("pong", 2), tmp_path, overlay=("action",), index=1)
    envs.reset(seed=0)
    for actions in ([0, 2], [1, 2], [2, 3]):
        envs.step(np.array(actions))
    envs.close()
    bands = [image[420:].tobytes() for image in videos["rl-video-episode-0.mkv"].images]
    assert bands[1:9] == [bands[1]] * 8
    assert len({bands[0], bands[1], bands[9]}) == 3


@pytest.mark.parametrize(
    ("options", "error", "text"),
    [
        ({"video_aspect_ratio": (1, 0)}, ValueError, r"video_aspect_ratio is \(width, height\)"),
        ({"video_aspect_ratio": 1.5}, ValueError, r"two numbers above 0, got 1\.5"),
    ],
)
def test_wrong_arguments_are_refused(
    tmp_path: Path, options: dict[str, Any], error: type[Exception], text: str
) -> None:
    with pytest.raises(error, match=text):
        record_video(AtariVectorEnv("pong", 2), tmp_path, **options)
    assert not list(tmp_path.iterdir())


def test_it_synchronizes_with_environments_that_were_restored_or_changed(tmp_path: Path, videos: Any) -> None:
    vector = AtariVectorEnv("breakout", 2)
    envs = record_video(vector, tmp_path)
    envs.reset(seed=0)
    envs.step(np.array([1, 1]))
    saved = vector.snapshot()
    envs.step(np.array([2, 3]))
    vector.restore(None, saved)
    vector.lanes[1].set_ram(3, 7)
    envs.step(np.array([0, 3]))
    assert_shadows_equal(envs)
    envs.close()


def test_an_ended_environment_that_was_restored_shows_its_frames(tmp_path: Path, videos: Any) -> None:
    vector = AtariVectorEnv("pong", 1, max_num_frames_per_episode=12, noop_max=1)
    first = {"episode_trigger": lambda episode: episode == 0, "video_length": 100}
    envs = record_video(vector, tmp_path, **first)
    envs.reset(seed=0)
    saved = vector.snapshot()
    while not envs.step(np.array([2]))[3][0]:
        pass
    vector.restore(None, saved)
    before = envs._recorder.frames
    envs.step(np.array([2]))
    assert envs._recorder.frames == before + 4
    envs.close()


def test_inner_wrappers_may_change_actions(tmp_path: Path, videos: Any) -> None:
    """The video has what the consoles got."""
    written = []
    for changes in (False, True):
        envs: Any = AtariVectorEnv("pong", 2, noop_max=1, use_fire_reset=False)
        if changes:
            envs = gymnasium.wrappers.vector.TransformAction(envs, lambda actions: 5 - actions)
        envs = record_video(envs, tmp_path / str(changes), sound=False, overlay=("action",))
        envs.reset(seed=0)
        generator = np.random.default_rng(0)
        for _ in range(20):
            actions = generator.integers(6, size=2)
            envs.step(actions if changes else 5 - actions)
        envs.close()
        written.append(np.array(videos["rl-video-episode-0.mkv"].images))
    assert len(written[0]) > 80
    np.testing.assert_array_equal(*written)


@pytest.mark.parametrize(
    ("game", "options"),
    [
        *[
            (game, {"autoreset_mode": mode})
            for game in ("ALE/Pong-v5", "ALE/Breakout-v5", "PongDeterministic-v0")
            for mode in ("NextStep", "SameStep")
        ],
        *[("pong", {"preset": preset}) for preset in ("machado2018", "dopamine", "baselines", "envpool")],
    ],
)
def test_sticky_actions_after_a_reset_that_plays_no_frame(
    game: str, options: dict[str, Any], tmp_path: Path, videos: Any
) -> None:
    """A first state equals the recorder's in RAM and frame number, and not in its generator."""
    envs: Any = RecordVideo(AtariVectorEnv(game, 2, **options), tmp_path / "videos", video_length=20)
    for seed in (0, 1):
        envs.reset(seed=seed)
        for _ in range(19):
            envs.step(np.full(2, 2))
        if seed == 0:
            assert_shadows_equal(envs)
    envs.close()
    assert len(videos) == 2


@pytest.mark.parametrize("recorder", [RecordVideo, RecordReplay])
@pytest.mark.parametrize(
    ("make", "options", "error", "text"),
    [
        (lambda: gymnasium.make("CartPole-v1"), {}, TypeError, "an AtariEnv or an AtariVectorEnv, got CartPoleEnv"),
        (lambda: SyncVectorEnv([lambda: atari.make("pong")]), {}, TypeError, "an AtariVectorEnv, got SyncVectorEnv"),
        (lambda: "pong", {}, TypeError, "records an AtariEnv or an AtariVectorEnv, got str"),
        (lambda: atari.AtariEnv("pong"), {"index": 1}, TypeError, "has no option 'index'"),
        (lambda: AtariVectorEnv("pong", 2), {"index": 2}, ValueError, "index must be within 0..1, got 2"),
        (lambda: AtariVectorEnv("pong", 2, batch_size=1), {}, ValueError, "needs batches of all environments, got b"),
        (lambda: AtariVectorEnv("pong", 2, players=2), {}, ValueError, "got players=2; games of several players are"),
    ],
)
def test_what_no_recorder_takes(
    recorder: Any, make: Any, options: dict[str, Any], error: type[Exception], text: str, tmp_path: Path
) -> None:
    with pytest.raises(error, match=re.escape(text)) as caught:
        recorder(make(), tmp_path / "a.a26r", **options)
    other = "; for other environments use gymnasium.wrappers.RecordVideo"
    with_other = ("CartPoleEnv", "str", *["SyncVectorEnv"] * issubclass(SyncVectorEnv, gymnasium.Env))  # Gymnasium 0.29
    assert (other in str(caught.value)) == (recorder is RecordVideo and text.endswith(with_other))
    assert not list(tmp_path.iterdir())
