"""Videos of replays of several players have each frame of the game, with its sound."""

from pathlib import Path

import numpy as np
import pytest

from atari.multiplayer import MultiplayerCore
from atari.recording import RecordReplay, Replay

av = pytest.importorskip("av")


def test_a_video_has_the_frames_and_the_sound_of_the_game(tmp_path: Path) -> None:
    source = np.random.default_rng(0)
    actions = source.integers(0, 18, (60, 2)).tolist()
    with RecordReplay(MultiplayerCore("combat"), tmp_path / "match.a26r") as match:
        match.reset()
        for action in actions:
            match.act_players(action)
    Replay.load(tmp_path / "match.a26r").render(tmp_path / "match.mkv", scale=1)

    again = MultiplayerCore("combat", sound=True)
    again.reset()
    frames, samples = [], []
    for action in actions:
        again.act_players(action)
        frames.append(again.screen_rgb())
        samples.append(again.audio())
    assert np.ptp(np.concatenate(samples)) > 0
    with av.open(str(tmp_path / "match.mkv")) as video:
        shown = [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]
        video.seek(0)
        heard = np.concatenate([part.to_ndarray().reshape(-1) for part in video.decode(audio=0)])
    assert len(shown) == 60
    assert all(np.array_equal(one[:, ::2], two) for one, two in zip(shown, frames, strict=True))
    assert np.array_equal(heard, (np.concatenate(samples).astype(np.int32) - 128) * 128)
