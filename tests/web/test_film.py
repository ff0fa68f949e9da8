"""Films: read by the text of `atari.web.film`, and compared with the frames of recordings."""

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from replay_tools import record

from atari.multiplayer.core import MultiplayerCore
from atari.recording import RecordReplay, Replay
from atari.web import film as module
from atari.web.film import ByteArray, film, frames_of

REPLAYS = Path(__file__).parents[2] / "docs" / "games" / "replays"


@dataclass
class Read:
    """A film that was read."""

    total: int
    rate: float
    players: int
    screens: list[ByteArray]
    facts: npt.NDArray[np.int32]
    sound: ByteArray
    rows: list[int]


def read(packed: bytes) -> Read:
    """Read a film, written anew from the description of the format."""
    data = zlib.decompress(packed)
    magic, version, colours, height, frames, total, rate, players, zero = struct.unpack_from("<4sBBHIIHBB", data)
    assert (magic, version, zero) == (b"A26F", 1, 0)
    at = 20
    palette = np.frombuffer(data, np.uint8, 3 * (colours + 1), at).reshape(-1, 3)
    at += palette.size
    screen = np.zeros((height, 160), np.uint8)
    screens, rows = [], []
    for _ in range(frames):
        mask = data[at : at + -(-height // 8)]
        at += len(mask)
        has = [row for row in range(height) if mask[row // 8] & (128 >> (row % 8))]
        for row in has:
            screen[row] = np.frombuffer(data, np.uint8, 160, at)
            at += 160
        rows.append(len(has))
        screens.append(palette[screen])
    facts = np.frombuffer(data, "<i4", 3 * frames, at).reshape(3, frames)
    sound = np.frombuffer(data, np.uint8, 512 * frames, at + 12 * frames).reshape(frames, 512)
    assert at + 524 * frames == len(data)
    return Read(total, rate / 100, players, screens, facts, sound, rows)


@dataclass
class Drawn:
    """A frame of a test."""

    screen: ByteArray
    audio: ByteArray
    scores: Sequence[int] = (0,)
    lives: int = 0


def drawn(screen: ByteArray) -> Drawn:
    return Drawn(screen, np.zeros(512, np.uint8))


@pytest.mark.parametrize("name", ["breakout", "pong", "enduro", "air_raid", "ms_pacman", "surround", "journey_escape"])
def test_a_film_is_the_recording(name: str) -> None:
    replay = Replay.load(REPLAYS / f"{name}.a26r")
    frames = list(replay.frames(0, 700, sound=True))
    seen = read(film(frames, replay.frames_total, replay.game.screen.frame_rate, replay.players))
    assert (seen.total, seen.rate, seen.players) == (replay.frames_total, replay.game.screen.frame_rate, 1)
    assert len(seen.screens) == 700
    for shown, frame in zip(seen.screens, frames, strict=True):
        assert (shown == frame.screen).all()
    assert seen.facts.tolist() == [[f.score for f in frames], [0] * 700, [f.lives for f in frames]]
    assert (seen.sound == [frame.audio for frame in frames]).all()
    assert seen.sound.any()
    height = replay.game.screen.height
    assert [index for index, rows in enumerate(seen.rows) if rows == height][:1] == [0]
    assert seen.rows[300] == seen.rows[600] == height
    assert min(seen.rows) < height / 2  # the others have what changed


def test_two_players(tmp_path: Path) -> None:
    with RecordReplay(MultiplayerCore("pong"), tmp_path / "game.a26r") as match:
        match.reset()
        for _ in range(600):
            match.act_players([0, 2])
    replay = Replay.load(tmp_path / "game.a26r")
    frames = list(replay.frames(sound=True))
    seen = read(film(frames, replay.frames_total, 60, 2))
    assert seen.players == 2
    assert seen.facts[:2].T.tolist() == [list(frame.scores) for frame in frames]
    assert seen.facts[:2, -1].any()


def test_what_a_film_of_these_games_must_cover() -> None:
    screens = {Replay.load(REPLAYS / f"{name}.a26r").game.screen for name in ("breakout", "air_raid", "journey_escape")}
    assert len({screen.height for screen in screens}) == 3
    assert any(screen.height % 8 for screen in screens)
    assert any(screen.format == "PAL" for screen in screens)


def test_a_film_ends_before_it_is_too_large(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    replay = Replay.load(record(tmp_path / "game.a26r", "pong", steps=100))
    whole = read(film(replay.frames(sound=True), 400, 60))
    monkeypatch.setattr(module, "MOST_BYTES", 100_000)
    packed = film(replay.frames(sound=True), 400, 60)
    part = read(packed)
    assert 1 < len(part.screens) == frames_of(packed) < len(whole.screens) == 400
    assert all((one == other).all() for one, other in zip(part.screens, whole.screens, strict=False))
    sizes = np.cumsum([27 + 160 * rows + 512 + 12 for rows in whole.rows])
    assert len(part.screens) == int(np.sum(sizes <= 100_000))


def test_colours() -> None:
    screen = np.zeros((200, 160, 3), np.uint8)
    screen[0, :, 1] = np.arange(160)
    screen[1, :95, 0] = 1 + np.arange(95)
    seen = read(film([drawn(screen)], 1, 50))
    assert (seen.screens[0] == screen).all()
    screen[1, 95:98, 2] = 1, 2, 3
    with pytest.raises(ValueError, match="at most 256 colours"):
        film([drawn(screen)], 1, 50)


def test_no_frame() -> None:
    with pytest.raises(ValueError, match="a film needs a frame"):
        film([], 0, 60)
