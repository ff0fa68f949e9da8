"""`VideoFlags`: the options that say how videos and pictures look, for the commands that write them."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from atari.games.game import Game
from atari.recording import VideoWriter
from atari.recording.replay.file_format import SUFFIX
from atari.recording.video.formats import FORMATS, has_sound, is_picture
from atari.recording.video.overlay import OVERLAYS, Overlay
from atari.recording.video.writer import SPEEDS
from atari.task.parser import number

_SCALE = 2


def add_video_flags(parser: argparse.ArgumentParser) -> None:
    """Add the options of `VideoFlags`."""
    parser.add_argument(
        "--scale", type=number(int, 1, 16), metavar="N", help=f"rows of the video a pixel (default: {_SCALE})"
    )
    parser.add_argument(
        "--speed",
        type=number(float, *SPEEDS),
        metavar="X",
        help=f"speed of the video, within {SPEEDS[0]}..{SPEEDS[1]} (default: 1): 0.25 is slow motion with lower sound, "
        "4 is fast with higher sound",
    )
    parser.add_argument(
        "--frame",
        type=best_or_number,
        metavar="N",
        help="the frame of a picture (-o FILE.png): its number, from 0, in all games; or best, the first with the "
        "greatest reward (default: the last frame)",
    )
    parser.add_argument(
        "--overlay",
        type=_overlay,
        metavar="PARTS",
        help=f"show values below the screen: some of {', '.join(OVERLAYS)}, with commas between",
    )
    parser.add_argument("--no-sound", action="store_true", help="write no sound")


class VideoFlags:
    """How videos and pictures look, by the options of `add_video_flags`.

    Args:
        args: the parsed arguments.
        files: the files that the command writes; their suffixes decide their formats.

    Raises:
        ValueError: an option has no effect on any of the files.
    """

    def __init__(self, args: argparse.Namespace, files: Sequence[Path]) -> None:
        shown = [path for path in files if path.suffix.lower() in FORMATS]
        kinds = {
            "scale": ("a video or a picture", shown),
            "overlay": ("a video or a picture", shown),
            "speed": ("a video", [path for path in shown if _has_speed(path)]),
            "frame": ("a picture, such as -o game.png", [path for path in shown if is_picture(path)]),
            "no_sound": ("a video with sound", [path for path in shown if has_sound(path)]),
        }
        known = all(path.suffix.lower() in (*FORMATS, SUFFIX) for path in files)  # else the ending is the error
        for name, (kind, affected) in kinds.items():
            value = getattr(args, name)
            if value is not None and value is not False and not affected and known:
                option = f"--{name.replace('_', '-')}"
                written = ", ".join(map(str, files)) or "nothing"
                raise ValueError(f"{option} is for {kind}, and the command writes {written}; leave it out")
        self._speed, self._frame = args.speed or 1, args.frame
        self._options = {"scale": args.scale or _SCALE, "sound": not args.no_sound, "overlay": args.overlay}

    def options(self, path: Path) -> dict[str, Any]:
        """The options of `Replay.render` for a file."""
        frame = {"frame": self._frame} if is_picture(path) else {}
        return {**self._options, "speed": self._speed if _has_speed(path) else 1, **frame}

    def check(self, path: Path, game: Game) -> None:
        """Check a file before games are played, which may take hours.

        Raises:
            TypeError, ValueError, OSError, gymnasium.error.DependencyNotInstalled: see `VideoWriter`.
        """
        overlay = Overlay(self._options["overlay"], game)
        (rows, columns), sound = overlay.size(game.screen.shape), self._options["sound"] and has_sound(path)
        VideoWriter(
            path, (rows, columns), 60, scale=self._options["scale"], sound=sound, caption_lines=overlay.caption_lines
        ).close()  # without frames it leaves no file


def best_or_number(text: str) -> int | str:
    """A number of a frame or of an episode, or "best"."""
    try:
        return text if text == "best" else int(number(int, 0)(text))
    except argparse.ArgumentTypeError as error:
        raise argparse.ArgumentTypeError(f"{error}, nor best") from None


def _has_speed(path: Path) -> bool:
    return path.suffix.lower() != ".png"


def _overlay(text: str) -> tuple[str, ...]:
    parts = tuple(text.split(","))
    for part in set(parts) - set(OVERLAYS):
        raise argparse.ArgumentTypeError(f"{part!r} is none of {', '.join(OVERLAYS)}")
    return parts
