"""`record_game`: a video with sound of a game of several players."""

from collections.abc import Callable, Sequence
from os import PathLike

from atari.multiplayer.core import MultiplayerCore
from atari.recording import VideoWriter, frame_rate


def record_game(
    path: str | PathLike[str],
    core: MultiplayerCore,
    policy: Callable[[MultiplayerCore], Sequence[int]],
    frames: int = 3600,
) -> list[int]:
    """Play a game from a reset to its end, and write each frame with its sound to a video.

    Args:
        path: the file, in a format of `VideoWriter`.
        core: the game, with frame_skip=1, and with sound=True unless the video is to be silent.
        policy: gives the action of each player, ALE's numbers, for the core in its present state.
        frames: the most frames that are played.

    Returns:
        The sum of the rewards of each player.

    Raises:
        ValueError: the core has a frame skip.
        TypeError, OSError, gymnasium.error.DependencyNotInstalled: as `VideoWriter`.
    """
    if core.frame_skip != 1:
        raise ValueError(f"a video needs each frame: make the core with frame_skip=1, got {core.frame_skip}")
    core.reset()
    totals = [0] * core.players
    with VideoWriter(path, core.game.screen.shape, frame_rate(core.game), sound=core.sound) as video:
        while not (core.game_over or core.truncated) and video.frames < frames:
            rewards = core.act_players(policy(core))
            totals = [total + reward for total, reward in zip(totals, rewards, strict=True)]
            video.write(core.screen_rgb(), core.audio() if core.sound else None)
    return totals
