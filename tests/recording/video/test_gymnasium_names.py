"""The attributes of Gymnasium's `RecordVideo`, which programs read, and set between phases of a training."""

import gc
from pathlib import Path
from typing import Any

import gymnasium
import pytest
from film import always, files
from video_reader import video_frames

import atari
from atari.recording import RecordVideo


def never(number: int) -> bool:
    return False


def recorder(tmp_path: Path, vector: bool = False, **options: Any) -> Any:
    env: Any = atari.AtariVectorEnv("pong", 2, noop_max=1, max_num_frames_per_episode=12) if vector else None
    if env is None:
        env = atari.AtariEnv("pong", max_num_frames_per_episode=12)
    chosen = {"episode_trigger": never, "format": "gif", "fps": 10, "scale": 1, **options}
    return RecordVideo(env, tmp_path / "videos", **chosen)


def play(env: Any, episodes: int = 1) -> None:
    for _ in range(episodes):
        env.reset(seed=0)
        for _ in range(2):
            env.step(env.action_space.sample())


KINDS = pytest.mark.parametrize("vector", [False, True], ids=["env", "vector"])


@KINDS
def test_triggers_and_names_can_change_between_phases(tmp_path: Path, vector: bool) -> None:
    env = recorder(tmp_path, vector)
    play(env)
    assert env.episode_trigger is never
    env.episode_trigger, env.name_prefix = always, "second"
    play(env)
    env.episode_trigger, env.step_trigger, env.name_prefix = None, always, "third"
    play(env)
    env.step_trigger = None
    env.close()
    assert [name for name in files(tmp_path) if name.startswith("second")] == ["second-episode-1.gif"]
    assert {name.partition("-")[0] for name in files(tmp_path)} == {"second", "third"}


@KINDS
def test_the_length_can_change(tmp_path: Path, vector: bool) -> None:
    env = recorder(tmp_path, vector, step_trigger=lambda step: step % 2 == 0, episode_trigger=None, video_length=2)
    assert env.video_length == 2
    env.video_length = 0
    assert env.video_length == float("inf")
    env.reset()
    env.step(env.action_space.sample())
    assert env.recording
    env.video_length = 1
    env.step(env.action_space.sample())
    assert not env.recording
    env.close()


def test_the_rate_can_change(tmp_path: Path) -> None:
    env = recorder(tmp_path, fps=None, format="mp4")
    assert env.frames_per_sec == pytest.approx(60, abs=0.2)
    assert isinstance(env.frames_per_sec, float)
    env.frames_per_sec = 10
    assert env.frames_per_sec == 10
    with pytest.raises((TypeError, ValueError)):
        env.frames_per_sec = 0
    assert env.frames_per_sec == 10
    env.close()


@KINDS
def test_the_frames_are_counted(tmp_path: Path, vector: bool) -> None:
    env = recorder(tmp_path, vector, episode_trigger=always)
    assert len(env.recorded_frames) == 0
    play(env)
    count = len(env.recorded_frames)
    with pytest.raises(LookupError, match="not kept in memory"):
        env.recorded_frames[0]
    env.stop_recording()
    assert len(env.recorded_frames) == 0
    env.close()
    assert len(video_frames(tmp_path / "videos" / "rl-video-episode-0.gif")) == count > 2


def test_the_history_is_that_of_the_next_render(tmp_path: Path) -> None:
    env = RecordVideo(atari.AtariEnv("pong", render_mode="rgb_array_list"), tmp_path, episode_trigger=never)
    play(env)
    assert len(env.render_history) == 3
    assert len(env.render()) == 3
    assert env.render_history == []
    env.close()
    assert recorder(tmp_path).render_history == []


def test_garbage_is_collected_after_a_video(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    collected: list[int] = []
    monkeypatch.setattr(gc, "collect", lambda: collected.append(len(asked)))
    env = recorder(tmp_path, episode_trigger=always, gc_trigger=lambda episode: asked.append(episode) or episode == 1)
    play(env, 3)
    env.close()
    assert asked == [0, 1, 2]
    assert collected == [2]


def test_a_logger_prints_each_video(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    env = recorder(tmp_path, episode_trigger=always, disable_logger=False)
    play(env, 2)
    env.disable_logger = True
    play(env)
    env.close()
    first = tmp_path / "videos" / "rl-video-episode-0.gif"
    assert capsys.readouterr().out.splitlines()[0] == f"atari.recording: the video {first} is complete"


@pytest.mark.parametrize(
    ("name", "value", "error", "text"),
    [
        ("episode_trigger", 3, TypeError, "episode_trigger is a function of a number, got 3"),
        ("step_trigger", "x", TypeError, "step_trigger is a function"),
        ("video_length", -1, ValueError, "video_length must be within"),
        ("video_length", 1.5, TypeError, "video_length must be an integer"),
        ("name_prefix", 3, TypeError, "name_prefix is a text"),
    ],
)
def test_a_wrong_value_changes_nothing(
    tmp_path: Path, name: str, value: Any, error: type[Exception], text: str
) -> None:
    env = recorder(tmp_path / "a")
    before = getattr(env, name)
    with pytest.raises(error, match=text):
        setattr(env, name, value)
    assert getattr(env, name) == before
    with pytest.raises(error, match=text):
        recorder(tmp_path / "b", **{name: value})
    assert not (tmp_path / "b").exists()
    env.close()


def test_the_names_of_a_mosaic(tmp_path: Path) -> None:
    env = RecordVideo(atari.AtariVectorEnv("pong", 3), tmp_path / "videos", format="gif", fps=10, scale=1)
    env.reset()
    assert (env.frame_cols, env.frame_rows) in ((3, 1), (2, 2), (1, 3))
    assert (env.record_first_only, env.video_aspect_ratio) == (False, (1, 1))
    assert env.autoreset_mode == gymnasium.vector.AutoresetMode.NEXT_STEP
    assert env.has_autoreset is False
    env.close()


def test_an_autoreset_is_announced(tmp_path: Path) -> None:
    env = recorder(tmp_path, vector=True)
    env.reset()
    seen = []
    for _ in range(8):
        before = env.has_autoreset
        _, _, _, _, info = env.step(env.action_space.sample())
        seen.append((before, bool(info["episode_frame_number"][0] <= 4)))
    env.close()
    assert (True, True) in seen
    assert all(announced == begins for announced, begins in seen[1:])
