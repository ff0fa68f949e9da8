"""`Replay.render` of a picture: one chosen frame of a replay; and of the best episode."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from replay_tools import record
from video_reader import Screen, video_frames

from atari.recording import Replay
from atari.recording.replay.results import Frame
from atari.recording.video.overlay import CURVE_ROWS


@pytest.fixture(scope="module")
def replay(tmp_path_factory: pytest.TempPathFactory) -> Replay:
    """Several episodes of Breakout."""
    found = Replay.load(
        record(tmp_path_factory.mktemp("replay") / "a.a26r", "breakout", 250, max_num_frames_per_episode=240)
    )
    assert len(found.episodes) > 2
    assert found.best_episode > 0
    return found


@pytest.fixture(scope="module")
def frames(replay: Replay) -> list[Frame]:
    return list(replay.frames())


def picture(replay: Replay, path: Path, **options: Any) -> Screen:
    image = cv2.imread(str(replay.render(path / "a.png", scale=1, **options)))
    return np.asarray(image[..., ::-1], np.uint8)


@pytest.mark.parametrize("number", [0, 77, 300])
def test_a_chosen_frame(replay: Replay, frames: list[Frame], tmp_path: Path, number: int) -> None:
    assert np.array_equal(picture(replay, tmp_path, frame=number), frames[number].screen.repeat(2, axis=1))


def test_without_a_choice_it_is_the_last_frame(replay: Replay, frames: list[Frame], tmp_path: Path) -> None:
    in_the_second = [frame for frame in frames if frame.episode == 1]
    for options, shown in (
        ({}, frames[-1]),
        ({"stop": 100}, frames[99]),
        ({"start": 50, "stop": 100}, frames[99]),
        ({"episode": 1}, in_the_second[-1]),
    ):
        assert np.array_equal(picture(replay, tmp_path, **options), shown.screen.repeat(2, axis=1)), options


def test_the_best_frame_has_the_greatest_reward(replay: Replay, frames: list[Frame], tmp_path: Path) -> None:
    for options, part in (
        ({}, frames),
        ({"start": 1, "stop": 60}, frames[1:60]),
        ({"episode": "best"}, [frame for frame in frames if frame.episode == replay.best_episode]),
    ):
        best = max(part, key=lambda frame: frame.reward)
        shown = picture(replay, tmp_path, frame="best", **options)
        assert np.array_equal(shown, best.screen.repeat(2, axis=1)), options


def test_a_picture_has_the_overlay_of_its_frame_in_a_video(replay: Replay, tmp_path: Path) -> None:
    overlay = ("score", "action", "ram", "curve")
    video = video_frames(replay.render(tmp_path / "a.mkv", scale=1, stop=61, overlay=overlay))
    image = picture(replay, tmp_path, frame=60, overlay=overlay)
    assert image.shape[0] == 210 + CURVE_ROWS + 9 * 10
    assert np.array_equal(image, video[60])
    image = picture(replay, tmp_path, frame=60, overlay=("score",))
    alone = video_frames(replay.render(tmp_path / "a.mkv", scale=1, stop=61, overlay=("score",)))
    assert np.array_equal(image, alone[60])


@pytest.mark.parametrize("count", [1, 100, 700])
def test_the_part_with_the_most_points(replay: Replay, frames: list[Frame], count: int) -> None:
    count = min(count, len(frames))
    sums = [sum(frame.reward for frame in frames[i : i + count]) for i in range(len(frames) - count + 1)]
    assert sums[replay.best_start(count)] == max(sums)
    with pytest.raises(ValueError, match=f"frames must be within 1..{len(frames)}, got 0"):
        replay.best_start(0)


def test_the_best_episode_by_name(replay: Replay, tmp_path: Path) -> None:
    named = replay.render(tmp_path / "named.gif", scale=1, episode="best")
    numbered = replay.render(tmp_path / "numbered.gif", scale=1, episode=replay.best_episode)
    assert named.read_bytes() == numbered.read_bytes()


@pytest.mark.parametrize(
    ("name", "options", "error", "text"),
    [
        ("a.mp4", {"frame": 3}, ValueError, r"frame=3 chooses the frame of a picture, such as 'pong\.png', got "),
        ("%06d.png", {"frame": "best"}, ValueError, "frame='best' chooses the frame of a picture"),
        ("a.png", {"frame": 3, "stop": 9}, ValueError, "frame=3 is a frame of the whole replay; leave episode, start"),
        ("a.png", {"frame": 3, "episode": 0}, ValueError, "frame=3 is a frame of the whole replay"),
        ("a.png", {"frame": 10**6}, ValueError, 'a frame other than "best" must be within 0'),
        ("a.png", {"frame": "worst"}, TypeError, 'a frame other than "best" must be an integer within 0'),
        ("a.png", {"start": 9, "stop": 9}, ValueError, "there are no frames to render"),
        ("a.png", {"start": -1}, ValueError, "start must be within 0"),
        ("a.png", {"speed": 2}, ValueError, "a PNG has no speed, got speed=2"),
        ("a.mp4", {"episode": "worst"}, TypeError, 'an episode other than "best" must be an integer within 0'),
        (
            "a.mp4",
            {"episode": "best", "stop": 3},
            ValueError,
            "episode='best' is a whole episode; leave start and stop out",
        ),
    ],
)
def test_wrong_choices(
    replay: Replay, tmp_path: Path, name: str, options: dict[str, Any], error: type[Exception], text: str
) -> None:
    with pytest.raises(error, match=text):
        replay.render(tmp_path / name, **options)
    assert not list(tmp_path.iterdir())
