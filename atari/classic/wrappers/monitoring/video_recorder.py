"""`VideoRecorder`: write the frames of an environment to a video."""

from atari.classic.video_recorder import ImageEncoder, TextEncoder, VideoRecorder, touch

__all__ = ["ImageEncoder", "TextEncoder", "VideoRecorder", "touch"]
