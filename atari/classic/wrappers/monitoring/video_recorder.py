"""`VideoRecorder`: write the frames of an environment to a video."""

from atari.classic.video_recorder import VideoRecorder

__all__ = ["VideoRecorder"]
