"""`record_game`: a video with sound of a game of several players, or a replay."""

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from os import PathLike
from pathlib import Path
from typing import Any

from atari.multiplayer.core import MultiplayerCore
from atari.recording import RecordMatch, VideoWriter, frame_rate
from atari.recording.replay.file_format import SUFFIX


def record_game(
    path: str | PathLike[str],
    core: MultiplayerCore,
    policy: Callable[[MultiplayerCore], Sequence[int]],
    frames: int = 3600,
) -> list[int]:
    """Play a game from a reset to its end, and write each frame with its sound to a video, or the calls to a replay.

    Args:
        path: the file, in a format of `VideoWriter`, or ".a26" for a replay (see `RecordMatch`).
        core: the game, with frameskip=1, and with sound=True unless the video is to be silent.
        policy: gives the action of each player, ALE's numbers, for the core in its present state.
        frames: the most frames that are played.

    Returns:
        The sum of the rewards of each player.

    Raises:
        ValueError: the core has a frame skip.
        TypeError, OSError, gymnasium.error.DependencyNotInstalled: as `VideoWriter`.
    """
    if core.frame_skip != 1:
        raise ValueError(f"a video needs each frame: make the core with frameskip=1, got {core.frame_skip}")
    with ExitStack() as stack:
        game: Any = core
        video = None
        if Path(path).suffix.lower() == SUFFIX:
            game = stack.enter_context(RecordMatch(core, path))
        game.reset()
        totals, played = [0] * core.players, 0
        if game is core:
            video = stack.enter_context(
                VideoWriter(path, core.game.screen.shape, frame_rate(core.game), sound=core.sound)
            )
        while not (core.game_over or core.truncated) and played < frames:
            rewards = game.act_players(policy(core))
            totals = [total + reward for total, reward in zip(totals, rewards, strict=True)]
            played += 1
            if video is not None:
                video.write(core.screen_rgb(), core.audio() if core.sound else None)
    return totals
