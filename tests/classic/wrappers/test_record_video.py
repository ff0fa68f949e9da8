"""`RecordVideo`: which steps are in which videos."""

import json
import re
import tempfile
from pathlib import Path
from typing import Any

import av
import pytest

import atari.classic as gym
from atari.classic.wrappers import RecordVideo, TimeLimit
from atari.classic.wrappers.monitoring.video_recorder import VideoRecorder


def frames(path: Path) -> int:
    with av.open(str(path)) as container:
        return sum(1 for _ in container.decode(video=0))


def play(env: gym.Env, episodes: int) -> None:
    for _ in range(episodes):
        env.reset()
        while not env.step(0)[2]:
            pass
    env.close()


def test_episodes_of_a_trigger(tmp_path: Path) -> None:
    env = TimeLimit(gym.make("Pong-ram-v4"), 4)
    play(RecordVideo(env, tmp_path / "videos", episode_trigger=lambda episode: episode == 1, name_prefix="pong"), 3)
    (video,) = (tmp_path / "videos").glob("*.mp4")
    assert (video.name, frames(video)) == ("pong-episode-1.mp4", 5)
    assert json.loads(video.with_suffix(".meta.json").read_text()) == {
        "encoder_version": {"backend": "PyAV", "version": av.__version__},
        "content_type": "video/mp4",
        "step_id": 4,
        "episode_id": 1,
        "frames_per_second": env.metadata["video.frames_per_second"],
    }


def test_steps_of_a_trigger(tmp_path: Path) -> None:
    """A video of a length goes on through the end of an episode."""
    env = TimeLimit(gym.make("Pong-ram-v4"), 4)
    play(RecordVideo(env, tmp_path, step_trigger=lambda step: step in (3, 8), video_length=3), 3)
    assert {file.name: frames(file) for file in tmp_path.glob("*.mp4")} == {
        "rl-video-step-3.mp4": 4,
        "rl-video-step-8.mp4": 4,
    }


def test_without_a_trigger_episodes_of_cubes_are_recorded(tmp_path: Path) -> None:
    play(RecordVideo(TimeLimit(gym.make("Pong-ram-v4"), 1), tmp_path), 9)
    names = sorted(file.name for file in tmp_path.glob("*.mp4"))
    assert names == [f"rl-video-episode-{number}.mp4" for number in (0, 1, 8)]


def test_two_triggers_are_an_error(tmp_path: Path) -> None:
    with pytest.raises(
        ValueError, match=r"^RecordVideo takes episode_trigger or step_trigger, got both; leave one out$"
    ):
        RecordVideo(gym.make("Pong-ram-v4"), tmp_path / "x", lambda _: True, lambda _: True)
    assert not (tmp_path / "x").exists()


def test_a_recorder_by_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path.parent))
    env = gym.make("CartPole-v0")
    env.reset()
    recorder = VideoRecorder(env, base_path=str(tmp_path / "cart"))
    for _ in range(3):
        recorder.capture_frame()
    recorder.close()
    recorder.close()
    assert (recorder.path, frames(tmp_path / "cart.mp4")) == (str(tmp_path / "cart.mp4"), 3)
    somewhere = VideoRecorder(env)
    somewhere.capture_frame()
    somewhere.close()
    assert frames(Path(somewhere.path)) == 1
    off = VideoRecorder(env, str(tmp_path / "off.mp4"), enabled=False)
    off.capture_frame()
    off.close()
    assert sorted(file.name for file in tmp_path.iterdir()) == ["cart.meta.json", "cart.mp4"]


def test_an_environment_without_an_image(tmp_path: Path) -> None:
    class Blind(gym.Env):
        action_space = observation_space = gym.spaces.Discrete(2)

        def render(self, mode: str = "human", **_: Any) -> Any:
            return None

    text = "render(mode='rgb_array') of <Blind instance> returned nothing; return the image"
    with pytest.raises(gym.error.Error, match=f"^{re.escape(text)}$"):
        VideoRecorder(Blind(), tmp_path / "a.mp4").capture_frame()


@pytest.mark.parametrize(
    ("paths", "text"),
    [
        ({"path": "a.mp4", "base_path": "a"}, "give either path or base_path, got path='a.mp4' and base_path='a'"),
        ({"path": "a.gif"}, "videos are MP4 files, so path ends with .mp4, got 'a.gif'"),
    ],
)
def test_wrong_paths(paths: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(text)}$"):
        VideoRecorder(gym.make("CartPole-v0"), **paths)
