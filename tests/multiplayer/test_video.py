"""`record_game` writes each frame of a game, with its sound."""

from pathlib import Path

import numpy as np
import pytest

from atari.multiplayer import MultiplayerCore
from atari.multiplayer.video import record_game

av = pytest.importorskip("av")


def test_a_video_has_the_frames_and_the_sound_of_the_game(tmp_path: Path) -> None:
    source = np.random.default_rng(0)
    actions = source.integers(0, 18, (120, 2)).tolist()
    core = MultiplayerCore("combat", sound=True)
    moves = iter(actions)
    totals = record_game(tmp_path / "match.mkv", core, lambda _: next(moves), frames=120)
    assert len(totals) == 2

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
    assert len(shown) == 120
    assert all(np.array_equal(one[::2, ::4], two) for one, two in zip(shown, frames, strict=True))
    assert np.array_equal(heard, (np.concatenate(samples).astype(np.int32) - 128) * 128)


def test_a_frame_skip_is_refused_before_a_file_exists(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="frameskip=1, got 4"):
        record_game(tmp_path / "match.mkv", MultiplayerCore("combat", frameskip=4), lambda _: [0, 0])
    assert not list(tmp_path.iterdir())
