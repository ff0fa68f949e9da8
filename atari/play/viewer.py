"""`show_replay`: a replay in a window, at the console's speed."""

from typing import Any

from atari.play.loop import Pacer
from atari.play.speaker import Speaker
from atari.play.window import GameWindow, start_pygame
from atari.recording import Replay
from atari.recording.video.writer import frame_rate


def show_replay(replay: Replay, *, scale: int = 3, sound: bool = True) -> bool:
    """Show a replay until its end, a closed window or the Escape key; returns whether it reached its end.

    Raises:
        gymnasium.error.DependencyNotInstalled: pygame-ce is not installed.
        gymnasium.error.Error: there is no display.
    """
    pygame = start_pygame()
    window = GameWindow(pygame, replay.game, scale)
    rate = float(frame_rate(replay.game))
    speaker = Speaker(pygame, rate) if sound else None
    pacer, score = Pacer(rate), 0
    try:
        for frame in replay.frames(sound=sound):
            if any(_closes(pygame, event) for event in pygame.event.get()):
                return False
            score += frame.reward
            window.show(frame.screen, f"{replay.game.title}: {score:,}")
            if speaker is not None:
                speaker.play(frame.audio)
            pacer.wait()
    finally:
        if speaker is not None:
            speaker.close()
        window.close()
    return True


def _closes(pygame: Any, event: Any) -> bool:
    return bool(event.type == pygame.QUIT or (event.type == pygame.KEYDOWN and event.key == pygame.K_ESCAPE))
