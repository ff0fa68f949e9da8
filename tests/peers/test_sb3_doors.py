"""What Stable-Baselines3's own tools expect of an `AtariVecEnv`: seeds of rl-baselines3-zoo, and `VecVideoRecorder`."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from video_reader import video_frames

pytestmark = pytest.mark.peers


def make(**options: Any) -> Any:
    from atari.sb3 import AtariVecEnv

    return AtariVecEnv("breakout", 2, **{"preset": "baselines", **options})


@pytest.mark.parametrize("seed", [2**31 - 1, 2**31, 3_000_000_000, 2**32 - 1])
def test_seeds_of_the_zoo_give_what_make_atari_env_gives(seed: int) -> None:
    """The zoo draws them below 2**32. Environment i has the seed plus i."""
    from stable_baselines3.common.env_util import make_atari_env
    from stable_baselines3.common.vec_env import VecFrameStack

    ours, theirs = make(), VecFrameStack(make_atari_env("BreakoutNoFrameskip-v4", n_envs=2), 4)
    for envs in (ours, theirs):
        envs.seed(seed)
    np.testing.assert_array_equal(theirs.reset().transpose(0, 3, 1, 2), ours.reset())
    for number in range(20):
        actions = np.full(2, number % 4)
        np.testing.assert_array_equal(theirs.step(actions)[0].transpose(0, 3, 1, 2), ours.step(actions)[0])


def test_vec_video_recorder(tmp_path: Path) -> None:
    pytest.importorskip("moviepy")
    from stable_baselines3.common.vec_env import VecVideoRecorder

    envs = VecVideoRecorder(make(), str(tmp_path), record_video_trigger=lambda step: step == 0, video_length=12)
    envs.reset()
    for _ in range(20):
        envs.step(np.zeros(2, int))
    envs.close()
    (file,) = tmp_path.glob("*.mp4")
    frames = video_frames(file)
    assert len(frames) >= 12
    assert frames[0].shape[:2] == (420, 160)  # the screens of two environments


def test_the_render_mode_is_that_of_make_atari_env() -> None:
    from stable_baselines3.common.env_util import make_atari_env

    theirs = make_atari_env("BreakoutNoFrameskip-v4", n_envs=2)
    assert make().render_mode == theirs.render_mode == "rgb_array"
    assert make().metadata["render_fps"] == 15
    assert make(render_mode=None).render_mode is None


def test_a_reset_in_the_middle_of_a_game_begins_a_new_one() -> None:
    """Stable-Baselines3's environments go on: the exception to equality that the documentation names."""
    from stable_baselines3.common.env_util import make_atari_env

    for envs, goes_on in ((make(), False), (make_atari_env("BreakoutNoFrameskip-v4", n_envs=2), True)):
        envs.seed(0)
        envs.reset()
        for _ in range(30):
            envs.step(np.ones(2, int))
        before = [info["episode_frame_number"] for info in envs.step(np.zeros(2, int))[3]]
        envs.reset()
        after = [info["episode_frame_number"] for info in envs.step(np.zeros(2, int))[3]]
        assert [new > old for old, new in zip(before, after, strict=True)] == [goes_on] * 2
